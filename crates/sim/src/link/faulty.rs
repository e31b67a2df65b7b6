//! A wrapper that makes any link unreliable, the same way each time.

use core::time::Duration;
use heapless::Vec;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use uarm_io::frame::Frame;
use uarm_io::link::{Link, LinkHealth, Received};
use uarm_io::time::{Clock, Instant};

/// How often each thing goes wrong, as probabilities per frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FaultRates {
    /// The frame is lost.
    pub loss: f64,
    /// The frame comes twice.
    pub duplication: f64,
    /// One bit of the data is flipped; a real bus detects nearly all of these, so this tests what is left.
    pub corruption: f64,
    /// A received frame comes late, by up to [`FaultRates::longest_delay`]; later frames may overtake it.
    pub delay: f64,
    /// The longest delay.
    pub longest_delay: Duration,
}

/// Why fault rates are refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the probability of {name} is {found}, expected 0 to 1")]
pub struct FaultRateError {
    /// Which rate was refused.
    pub name: &'static str,
    /// The value that was refused.
    pub found: f64,
}

impl FaultRates {
    fn check(&self) -> Result<(), FaultRateError> {
        let named = [
            ("loss", self.loss),
            ("duplication", self.duplication),
            ("corruption", self.corruption),
            ("delay", self.delay),
        ];
        match named.into_iter().find(|(_, rate)| !(0.0..=1.0).contains(rate)) {
            Some((name, found)) => Err(FaultRateError { name, found }),
            None => Ok(()),
        }
    }
}

/// What a [`FaultyLink`] has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FaultCounts {
    /// Frames lost, in both directions.
    pub lost: u64,
    /// Frames doubled.
    pub duplicated: u64,
    /// Frames with a flipped bit.
    pub corrupted: u64,
    /// Frames that came late.
    pub delayed: u64,
}

/// How many frames are late or doubled at a time; when there are more, they come on time and once.
const IN_FLIGHT: usize = 32;

/// A frame that is late or doubled.
#[derive(Clone, Copy, Debug)]
struct InFlight {
    due: Instant,
    frame: Frame,
}

/// A link that loses, doubles, corrupts, delays and so reorders frames.
///
/// Deterministic: the same seed, rates and traffic give the same faults (the generator is `ChaCha8`). Frames sent
/// are lost, doubled or corrupted, but not delayed: the wire takes them when they are handed over.
#[derive(Debug)]
pub struct FaultyLink<L, C> {
    inner: L,
    clock: C,
    rates: FaultRates,
    random: ChaCha8Rng,
    in_flight: Vec<InFlight, IN_FLIGHT>,
    counts: FaultCounts,
}

impl<L: Link, C: Clock> FaultyLink<L, C> {
    /// Wraps `inner`; `clock` tells when a frame that is lost would have been sent.
    ///
    /// # Errors
    /// [`FaultRateError`] if a rate is not a probability.
    pub fn new(inner: L, clock: C, rates: FaultRates, seed: u64) -> Result<Self, FaultRateError> {
        rates.check()?;
        let random = ChaCha8Rng::seed_from_u64(seed);
        Ok(Self { inner, clock, rates, random, in_flight: Vec::new(), counts: FaultCounts::default() })
    }

    /// Goes on with other rates; what is in flight stays in flight.
    ///
    /// # Errors
    /// [`FaultRateError`] if a rate is not a probability; the old rates then stay.
    pub fn set_rates(&mut self, rates: FaultRates) -> Result<(), FaultRateError> {
        rates.check()?;
        self.rates = rates;
        Ok(())
    }

    /// What went wrong so far.
    pub const fn counts(&self) -> &FaultCounts {
        &self.counts
    }

    /// The link inside.
    pub const fn inner(&self) -> &L {
        &self.inner
    }

    /// The link inside.
    pub const fn inner_mut(&mut self) -> &mut L {
        &mut self.inner
    }

    fn happens(&mut self, probability: f64) -> bool {
        self.random.random::<f64>() < probability
    }

    /// The frame, perhaps with a flipped bit.
    fn perhaps_corrupted(&mut self, frame: Frame) -> Frame {
        let length = frame.data().len();
        if !self.happens(self.rates.corruption) || length == 0 {
            return frame;
        }
        let mut bytes = [0; Frame::CAPACITY];
        for (byte, original) in bytes.iter_mut().zip(frame.data()) {
            *byte = *original;
        }
        let bits = u64::try_from(8 * length).unwrap_or(u64::MAX);
        let flipped = usize::try_from(self.random.random_range(0..bits)).unwrap_or(0);
        if let Some(byte) = bytes.get_mut(flipped / 8) {
            *byte ^= 1 << (flipped % 8);
        }
        self.counts.corrupted += 1;
        bytes.get(..length).and_then(|data| Frame::new(frame.id(), data)).unwrap_or(frame)
    }

    /// What becomes of a frame that the inner link received: `None` if it is lost or late.
    fn pass(&mut self, received: Received) -> Option<Received> {
        if self.happens(self.rates.loss) {
            self.counts.lost += 1;
            return None;
        }
        let frame = self.perhaps_corrupted(received.frame);
        if self.happens(self.rates.duplication) && self.in_flight.push(InFlight { due: received.at, frame }).is_ok() {
            self.counts.duplicated += 1;
        }
        if self.happens(self.rates.delay) {
            let longest = u64::try_from(self.rates.longest_delay.as_nanos()).unwrap_or(u64::MAX);
            let delay = Duration::from_nanos(self.random.random_range(0..longest.max(1)));
            if self.in_flight.push(InFlight { due: received.at + delay, frame }).is_ok() {
                self.counts.delayed += 1;
                return None;
            }
        }
        Some(Received { frame, at: received.at })
    }

    /// When the next frame in flight arrives.
    fn next_arrival(&self) -> Option<Instant> {
        self.in_flight.iter().map(|frame| frame.due).min()
    }

    /// The frame in flight that arrives first, if it does by `until`; of two at once the one sent first.
    fn take_arrival(&mut self, until: Instant) -> Option<Received> {
        let (index, first) = self.in_flight.iter().enumerate().min_by_key(|(_, frame)| frame.due)?;
        if first.due > until {
            return None;
        }
        let InFlight { due, frame } = self.in_flight.remove(index);
        Some(Received { frame, at: due })
    }
}

impl<L: Link, C: Clock> Link for FaultyLink<L, C> {
    type Error = L::Error;

    fn send(&mut self, frame: &Frame) -> Result<Instant, L::Error> {
        if self.happens(self.rates.loss) {
            self.counts.lost += 1;
            return Ok(self.clock.now());
        }
        let frame = self.perhaps_corrupted(*frame);
        if self.happens(self.rates.duplication) {
            self.counts.duplicated += 1;
            self.inner.send(&frame)?;
        }
        self.inner.send(&frame)
    }

    fn health(&self) -> LinkHealth {
        self.inner.health()
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, L::Error> {
        loop {
            let wait_until = self.next_arrival().map_or(deadline, |due| due.min(deadline));
            match self.inner.receive(wait_until)? {
                Some(received) => {
                    if let Some(passed) = self.pass(received) {
                        return Ok(Some(passed));
                    }
                }
                None => {
                    if let Some(arrived) = self.take_arrival(wait_until) {
                        return Ok(Some(arrived));
                    }
                    if wait_until >= deadline {
                        return Ok(None);
                    }
                }
            }
        }
    }
}
