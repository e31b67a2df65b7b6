//! Who the axes are, and their supply voltages and temperatures: asked for by messages without data, one at a time in the cycle.

use super::error::{OdriveCycleError, OdriveStartError};
use super::master::{Axis, OdriveNetwork};
use super::start::Feeding;
use super::watched::{Inquiry, Watched};
use super::wire::{self, Message};
use crate::drive::readings::{Found, QUANTITIES, Quantity, Verdict};
use crate::link::Link;
use crate::time::{Clock, Duration, Instant};

/// How often something is asked for: a request and its answer take 0.2 ms of a bus of 1 Mbit/s.
const INTERVAL: Duration = Duration::from_millis(50);
/// Requests in a row that an axis may leave unanswered.
const MOST_UNANSWERED: u8 = 1;
/// How long it is waited for versions: a firmware that tells none is borne, unless the configuration says which it must be.
const VERSION_PATIENCE: Duration = Duration::from_millis(100);

type Outcome<L> = Result<(), OdriveStartError<<L as Link>::Error>>;

const fn message(quantity: Quantity) -> Message {
    match quantity {
        Quantity::SupplyVoltage => Message::BusVoltageCurrent,
        Quantity::Temperature => Message::Temperature,
    }
}

impl<L: Link, const JOINTS: usize> OdriveNetwork<L, JOINTS> {
    /// Asks each axis for its version; those that are pinned must be what they are said to be.
    pub(super) fn identify<C: Clock>(&mut self, clock: &C) -> Outcome<L> {
        for axis in &mut self.axes {
            axis.version = None;
        }
        for node in self.nodes() {
            self.send(&wire::request(Message::Version, node))?;
        }
        let deadline = clock.now() + VERSION_PATIENCE;
        self.wait(clock, deadline, Feeding::On, |axes| axes.iter().all(|axis| axis.version.is_some()))?;
        for (axis, made) in self.axes.iter().zip(&self.configuration.axes) {
            let found = axis.version;
            if let Some(product) = made.product.filter(|product| found.map(|found| found.product()) != Some(*product)) {
                return Err(OdriveStartError::AnotherProduct { axis: axis.node, product, found });
            }
        }
        Ok(())
    }

    /// Asks for everything that is watched, and waits for it.
    pub(super) fn read_watched<C: Clock>(&mut self, clock: &C) -> Outcome<L> {
        self.inquiry = Inquiry::default();
        for axis in &mut self.axes {
            axis.health.readings = Default::default();
        }
        for joint in 0..JOINTS {
            for quantity in Quantity::ALL {
                self.ask(joint, quantity)?;
            }
        }
        let waited = self.configuration.times.state;
        self.wait(clock, clock.now() + waited, Feeding::On, |axes| axes.iter().all(|axis| missing(axis).is_none()))?;
        if let Some((axis, quantity)) = self.axes.iter().find_map(|axis| Some((axis.node, missing(axis)?))) {
            return Err(OdriveStartError::NoReading { axis, quantity, waited });
        }
        self.beyond().map_or(Ok(()), |(axis, found)| Err(OdriveStartError::Reading { axis, found }))
    }

    /// In the cycle: judges what came, and asks for the next value if it is due.
    pub(super) fn inquire(&mut self, now: Instant) -> Result<(), OdriveCycleError<L::Error>> {
        if let Some((axis, found)) = self.beyond() {
            return Err(OdriveCycleError::Reading { axis, found });
        }
        if now < self.inquiry.next_at {
            return Ok(());
        }
        let Some((joint, quantity)) = self.next_watched() else { return Ok(()) };
        if let Some(axis) = self.axes.get(joint).filter(|axis| axis.unanswered(quantity) > MOST_UNANSWERED) {
            return Err(OdriveCycleError::NoReading { axis: axis.node, quantity });
        }
        self.inquiry.next_at = now + INTERVAL;
        Ok(self.ask(joint, quantity)?)
    }

    /// Asks the axis of a joint, if it is watched.
    fn ask(&mut self, joint: usize, quantity: Quantity) -> Result<(), L::Error> {
        let Some(axis) = self.axes.get_mut(joint) else { return Ok(()) };
        let Some(watched) = axis.watched_mut(quantity) else { return Ok(()) };
        watched.unanswered = watched.unanswered.saturating_add(1);
        let request = wire::request(message(quantity), axis.node);
        self.send(&request).map(|_| ())
    }

    /// The next one that is to be asked for; `None` if there is none at all.
    fn next_watched(&mut self) -> Option<(usize, Quantity)> {
        let total = JOINTS.saturating_mul(QUANTITIES);
        for _ in 0..total {
            let at = self.inquiry.next;
            self.inquiry.next = at.saturating_add(1).checked_rem(total).unwrap_or_default();
            let (joint, which) = (at.checked_div(QUANTITIES)?, at.checked_rem(QUANTITIES)?);
            let quantity = *Quantity::ALL.get(which)?;
            if self.axes.get_mut(joint)?.watched_mut(quantity).is_some() {
                return Some((joint, quantity));
            }
        }
        None
    }

    /// The first axis with a value that ends a run.
    fn beyond(&self) -> Option<(wire::AxisNode, Found)> {
        self.axes.iter().find_map(|axis| {
            let values = axis.watched.iter().zip(axis.health.readings).zip(Quantity::ALL);
            values.into_iter().find_map(|((watched, value), quantity)| {
                let (limits, value) = (watched.as_ref()?.limits, value?);
                let stops = limits.verdict(value) == Verdict::Stop;
                stops.then_some((axis.node, Found { quantity, value, allowed: limits.stop() }))
            })
        })
    }
}

const fn place(quantity: Quantity) -> usize {
    match quantity {
        Quantity::SupplyVoltage => 0,
        Quantity::Temperature => 1,
    }
}

fn missing(axis: &Axis) -> Option<Quantity> {
    let values = axis.watched.iter().zip(axis.health.readings).zip(Quantity::ALL);
    values
        .into_iter()
        .find_map(|((watched, value), quantity)| (watched.is_some() && value.is_none()).then_some(quantity))
}

impl Axis {
    fn watched_mut(&mut self, quantity: Quantity) -> Option<&mut Watched> {
        self.watched.get_mut(place(quantity))?.as_mut()
    }

    fn unanswered(&self, quantity: Quantity) -> u8 {
        self.watched.get(place(quantity)).copied().flatten().map_or(0, |watched| watched.unanswered)
    }

    /// Takes a value, asked for or sent by the axis itself.
    pub(super) fn reading(&mut self, quantity: Quantity, value: f32) {
        let value = f64::from(value);
        let Some(watched) = self.watched_mut(quantity) else { return };
        watched.unanswered = 0;
        let verdict = watched.limits.verdict(value);
        if let Some(kept) = self.health.readings.get_mut(place(quantity)) {
            *kept = Some(value);
        }
        if verdict == Verdict::Warning {
            self.health.reading_warnings = self.health.reading_warnings.saturating_add(1);
        }
    }
}
