//! How long a cycle's frames occupy the bus at worst, and whether they fit.

use crate::drive::odrive::Positions;
use crate::drive::odrive::wire::{EncoderEstimates, Heartbeat, TORQUE_LENGTH};
use crate::drive::wire::{DriveCommand, DriveFeedback};
use core::time::Duration;

/// Bits of a classic 11-bit-identifier data frame with no data, with the interframe space: 44 + 3, and 8 stuff bits.
const EMPTY_FRAME_BITS: u32 = 55;
/// What each data byte adds: its 8 bits and, at worst, 2 stuff bits.
const BITS_PER_BYTE: u32 = 10;
/// Data bytes of a SYNC with counter and of a heartbeat.
const ONE_BYTE: usize = 1;

/// Bits that a frame with `data_bytes` bytes and an 11-bit identifier occupies at worst, interframe space included.
///
/// 47 + 8 L bits, and a stuff bit after every fourth of the 34 + 8 L bits that are stuffed: 55 + 10 L.
pub fn worst_case_frame_bits(data_bytes: usize) -> u32 {
    u32::try_from(data_bytes)
        .map_or(u32::MAX, |bytes| bytes.saturating_mul(BITS_PER_BYTE).saturating_add(EMPTY_FRAME_BITS))
}

/// Bits that a frame occupies at least, up to the end of its last bit: no stuff bit, no interframe space.
fn least_frame_bits(data_bytes: usize) -> u32 {
    u32::try_from(data_bytes).map_or(u32::MAX, |bytes| bytes.saturating_mul(8).saturating_add(44))
}

/// A bit rate of the bus, bit/s.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct BitRate(u32);

impl BitRate {
    /// 10 kbit/s to 1 Mbit/s: what CiA 301 knows.
    pub const RANGE: core::ops::RangeInclusive<u32> = 10_000..=1_000_000;

    /// 1 Mbit/s.
    pub const FASTEST: Self = Self(1_000_000);

    /// A bit rate.
    ///
    /// # Errors
    /// [`BusTimeError::BitRate`] outside [`BitRate::RANGE`].
    pub fn new(bits_per_second: u32) -> Result<Self, BusTimeError> {
        if Self::RANGE.contains(&bits_per_second) {
            Ok(Self(bits_per_second))
        } else {
            Err(BusTimeError::BitRate { bits_per_second })
        }
    }

    /// bit/s.
    pub const fn bits_per_second(self) -> u32 {
        self.0
    }

    /// The time of `bits` bits, rounded up to nanoseconds.
    pub fn time_of(self, bits: u32) -> Duration {
        Duration::from_nanos((u64::from(bits) * 1_000_000_000).div_ceil(u64::from(self.0)))
    }

    /// The earliest that a drive's TPDO1 can be here after a SYNC was handed to the bus. What comes sooner belongs to an
    /// earlier SYNC.
    pub fn earliest_feedback(self) -> Duration {
        self.time_of(least_frame_bits(ONE_BYTE) + least_frame_bits(DriveFeedback::LENGTH))
    }
}

/// What cannot be sent in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BusTimeError {
    /// See [`BitRate::RANGE`].
    #[error("{bits_per_second} bit/s, expected {} to {}", BitRate::RANGE.start(), BitRate::RANGE.end())]
    BitRate {
        /// The bit rate that was asked for, bit/s.
        bits_per_second: u32,
    },
    /// The period is zero.
    #[error("a period of zero")]
    ZeroPeriod,
    /// The frames of one cycle take longer than the cycle.
    #[error("{joints} joints need {needed:?} of bus time at {bits_per_second} bit/s in each period of {period:?}")]
    DoesNotFit {
        /// How many joints, each with one drive.
        joints: usize,
        /// Bit rate, bit/s.
        bits_per_second: u32,
        /// Worst-case bus time of a cycle in which all heartbeats fall too.
        needed: Duration,
        /// The cycle.
        period: Duration,
    },
}

/// The worst-case bus time of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BusTime {
    /// SYNC, the frames of feedback and command of every joint, and what other frames there are.
    pub cyclic_bits: u32,
    /// One heartbeat of every drive and of the master, should they all fall in one cycle.
    pub heartbeat_bits: u32,
    /// Time of the cyclic frames.
    pub cyclic: Duration,
    /// Time of the cyclic frames and all heartbeats.
    pub worst: Duration,
    /// Cyclic time over period, 0 … 1.
    pub load: f64,
}

impl BusTime {
    /// The bus time of `joints` drives at `bit_rate`, in cycles of `period`.
    ///
    /// # Errors
    /// [`BusTimeError::DoesNotFit`] if the worst cycle takes longer than the period, [`BusTimeError::ZeroPeriod`].
    pub fn of_cycle(joints: usize, bit_rate: BitRate, period: Duration) -> Result<Self, BusTimeError> {
        Self::of_cycle_with(joints, &[], bit_rate, period)
    }

    /// The same with one more frame in each cycle for each number of data bytes in `others`.
    ///
    /// # Errors
    /// As [`BusTime::of_cycle`].
    pub fn of_cycle_with(
        joints: usize,
        others: &[usize],
        bit_rate: BitRate,
        period: Duration,
    ) -> Result<Self, BusTimeError> {
        let count = u32::try_from(joints).unwrap_or(u32::MAX);
        let pdos = worst_case_frame_bits(DriveFeedback::LENGTH) + worst_case_frame_bits(DriveCommand::LENGTH);
        let others = others.iter().fold(0_u32, |bits, bytes| bits.saturating_add(worst_case_frame_bits(*bytes)));
        let cyclic_bits =
            worst_case_frame_bits(ONE_BYTE).saturating_add(pdos.saturating_mul(count)).saturating_add(others);
        let heartbeat_bits = worst_case_frame_bits(ONE_BYTE).saturating_mul(count.saturating_add(1));
        Self::new(joints, cyclic_bits, heartbeat_bits, bit_rate, period)
    }

    /// The bus time of `joints` ODrive axes at `bit_rate`, in cycles of `period`: a request and a position of each axis, or as
    /// many positions as it sends by itself, and a torque.
    ///
    /// # Errors
    /// As [`BusTime::of_cycle`].
    pub fn of_odrive_cycle(
        joints: usize,
        positions: Positions,
        bit_rate: BitRate,
        period: Duration,
    ) -> Result<Self, BusTimeError> {
        let count = u32::try_from(joints).unwrap_or(u32::MAX);
        let estimate = worst_case_frame_bits(EncoderEstimates::LENGTH);
        let feedback = match positions {
            Positions::OnRequest => estimate.saturating_add(worst_case_frame_bits(0)),
            Positions::Cyclic { every } => {
                let messages = period.as_nanos().div_ceil(every.as_nanos().max(1));
                estimate.saturating_mul(u32::try_from(messages).unwrap_or(u32::MAX))
            }
        };
        let cyclic_bits = feedback.saturating_add(worst_case_frame_bits(TORQUE_LENGTH)).saturating_mul(count);
        let heartbeat_bits = worst_case_frame_bits(Heartbeat::LENGTH).saturating_mul(count);
        Self::new(joints, cyclic_bits, heartbeat_bits, bit_rate, period)
    }

    fn new(
        joints: usize,
        cyclic_bits: u32,
        heartbeat_bits: u32,
        bit_rate: BitRate,
        period: Duration,
    ) -> Result<Self, BusTimeError> {
        if period.is_zero() {
            return Err(BusTimeError::ZeroPeriod);
        }
        let cyclic = bit_rate.time_of(cyclic_bits);
        let worst = bit_rate.time_of(cyclic_bits.saturating_add(heartbeat_bits));
        if worst > period {
            let bits_per_second = bit_rate.bits_per_second();
            return Err(BusTimeError::DoesNotFit { joints, bits_per_second, needed: worst, period });
        }
        let load = cyclic.as_secs_f64() / period.as_secs_f64();
        Ok(Self { cyclic_bits, heartbeat_bits, cyclic, worst, load })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_formula_is_frame_plus_stuffing() {
        for bytes in 0..=8_usize {
            let stuffed = 34 + 8 * bytes;
            let bits = 44 + 8 * bytes + 3 + (stuffed - 1) / 4;
            assert_eq!(worst_case_frame_bits(bytes), u32::try_from(bits).unwrap());
        }
    }

    #[test]
    fn the_robot_takes_about_seven_tenths_of_a_millisecond() {
        let time = BusTime::of_cycle(3, BitRate::FASTEST, Duration::from_millis(3)).unwrap();
        assert_eq!(time.cyclic, Duration::from_micros(65 + 3 * 115 + 3 * 95));
        assert!((time.load - 0.695 / 3.0).abs() < 1e-12);
        assert_eq!(time.worst - time.cyclic, Duration::from_micros(4 * 65));
    }

    /// 55 + 10 L bits each.
    #[test]
    fn other_frames_count() {
        let period = Duration::from_millis(3);
        let plain = BusTime::of_cycle(3, BitRate::FASTEST, period).unwrap();
        let more = BusTime::of_cycle_with(3, &[2, 8], BitRate::FASTEST, period).unwrap();
        assert_eq!(more.cyclic_bits - plain.cyclic_bits, 75 + 135);
    }

    #[test]
    fn what_cannot_fit_is_refused() {
        let slow = BitRate::new(125_000).unwrap();
        let refused = BusTime::of_cycle(3, slow, Duration::from_millis(3)).unwrap_err();
        assert!(matches!(refused, BusTimeError::DoesNotFit { joints: 3, needed, .. } if needed == slow.time_of(955)));
        assert!(BusTime::of_cycle(3, slow, Duration::from_millis(8)).is_ok());
        assert!(BusTime::of_cycle(usize::MAX, BitRate::FASTEST, Duration::from_secs(1)).is_err());
        assert_eq!(BitRate::new(2_000_000), Err(BusTimeError::BitRate { bits_per_second: 2_000_000 }));
        assert_eq!(BusTime::of_cycle(3, slow, Duration::ZERO), Err(BusTimeError::ZeroPeriod));
    }

    /// By hand: frames of 0, 8 and 4 bytes have 55, 135 and 95 bits.
    #[test]
    fn three_odrive_axes_take_a_request_a_position_and_a_torque_each() {
        let of =
            |positions| BusTime::of_odrive_cycle(3, positions, BitRate::FASTEST, Duration::from_millis(3)).unwrap();
        let asked = of(Positions::OnRequest);
        assert_eq!(asked.cyclic, Duration::from_micros(3 * (55 + 135 + 95)));
        assert_eq!(asked.worst - asked.cyclic, Duration::from_micros(3 * 135));
        let every_millisecond = of(Positions::Cyclic { every: Duration::from_millis(1) });
        assert_eq!(every_millisecond.cyclic, Duration::from_micros(3 * (3 * 135 + 95)));
        let slower = of(Positions::Cyclic { every: Duration::from_millis(10) });
        assert_eq!(slower.cyclic, Duration::from_micros(3 * (135 + 95)));
        let slow = BitRate::new(250_000).unwrap();
        let refused = BusTime::of_odrive_cycle(3, Positions::OnRequest, slow, Duration::from_millis(3)).unwrap_err();
        assert!(matches!(refused, BusTimeError::DoesNotFit { joints: 3, .. }));
        let never = BusTime::of_odrive_cycle(3, Positions::OnRequest, slow, Duration::ZERO);
        assert_eq!(never, Err(BusTimeError::ZeroPeriod));
    }

    #[test]
    fn feedback_needs_two_frames() {
        assert_eq!(BitRate::FASTEST.earliest_feedback(), Duration::from_micros(52 + 92));
    }
}
