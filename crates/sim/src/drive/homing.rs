//! How the drive finds its home position by itself: mode of operation 6.
//!
//! It looks at index and switches once per SYNC, and takes the position of the edge itself for home, as a latch does.

use super::encoder::whole;
use super::homing_state::{HomingMethod, Phase, Sight, Way};
use super::speed_loop::SpeedLoop;
use super::state::EmulatedDrive;
use canopen_rs::Address;
use core::f64::consts::TAU;
use core::time::Duration;
use nalgebra::ComplexField;
use uarm_io::drive::cia402::{Controlword, PowerState};
use uarm_io::drive::objects as od;
use uarm_io::encoder::Direction;
use uarm_io::time::Instant;

/// Bits of 60FDh.
const NEGATIVE_SWITCH: u32 = 1;
const POSITIVE_SWITCH: u32 = 1 << 1;
const DIGITAL_INPUTS: Address = Address::new(0x60FD, 0);
/// A motor that is to turn and stands for so long is blocked.
const STALL: Duration = Duration::from_millis(500);

impl<const N: usize> EmulatedDrive<N> {
    /// In homing mode, and enabled.
    pub(super) fn is_homing(&self) -> bool {
        let mode = self.number(od::MODE_OF_OPERATION.address());
        self.power == PowerState::OperationEnabled && mode == Some(od::HOMING.into())
    }

    /// Takes what the surroundings show where the joint stands at `angle`, rad, and the counter at `counts`.
    pub(super) fn look_around(&mut self, angle: f64, counts: i32) {
        let direction = self.parameters.direction();
        let motor = direction.apply(angle * self.parameters.transmission().ratio().factor());
        let revolution = whole(ComplexField::floor(motor / TAU));
        let switches = self.parameters.limit_switches().map_or([false; 2], |[least, most]| match direction {
            Direction::Positive => [angle <= least, angle >= most],
            Direction::Negative => [angle >= most, angle <= least],
        });
        self.sight = Sight { counts, revolution, switches };
        let bits = switches.iter().zip([NEGATIVE_SWITCH, POSITIVE_SWITCH]).filter(|(is_on, _)| **is_on);
        self.set_number(DIGITAL_INPUTS, bits.map(|(_, bit)| i128::from(bit)).sum());
    }

    /// Obeys bit 4 of the controlword.
    pub(super) fn on_homing_command(&mut self, before: Controlword) {
        if !self.is_homing() {
            return;
        }
        let starts = self.controlword.contains(Controlword::HOMING_START);
        match (before.contains(Controlword::HOMING_START), starts) {
            (false, true) => self.start_homing(),
            (true, false) if self.homing.phase.moves() => self.homing.phase = Phase::Idle,
            _ => {}
        }
    }

    fn start_homing(&mut self) {
        let method = self.number(od::HOMING_METHOD.address()).and_then(HomingMethod::of);
        self.homing.stalled_since = None;
        self.homing.phase = match method {
            None => Phase::Failed,
            Some(HomingMethod::LimitSwitch(_)) if self.parameters.limit_switches().is_none() => Phase::Failed,
            Some(HomingMethod::LimitSwitch(way)) => Phase::SeekSwitch(way),
            Some(HomingMethod::Index(way)) => Phase::SeekIndex(way, self.sight.revolution),
            Some(HomingMethod::Here) => {
                self.come_home(self.sight.counts);
                Phase::Done
            }
        };
    }

    /// One step of the procedure and of the loop that turns the motor, at a SYNC, after the position was latched.
    pub(super) fn home(&mut self, now: Instant) {
        if !self.is_homing() {
            self.homing.speed = SpeedLoop::default();
            if self.homing.phase.moves() {
                self.homing.phase = Phase::Idle;
            }
            return;
        }
        self.homing.phase = self.next_phase(now);
        let speed = |object: &od::Object| self.number(object.address()).and_then(|speed| u32::try_from(speed).ok());
        let (fast, slow) = (speed(&od::HOMING_SWITCH_SPEED), speed(&od::HOMING_ZERO_SPEED));
        let (way, wanted) = match self.homing.phase {
            Phase::SeekSwitch(way) => (way, fast),
            Phase::LeaveSwitch(way) => (way.back(), slow),
            Phase::SeekIndex(way, _) => (way, slow),
            Phase::Idle | Phase::Done | Phase::Failed => (Way::Positive, None),
        };
        let wanted = way.sign() * f64::from(wanted.unwrap_or_default());
        let ramp = speed(&od::HOMING_ACCELERATION).filter(|ramp| *ramp > 0).map(f64::from);
        let limit = self.torque_limit();
        let (counts, parameters) = (self.sight.counts, self.parameters);
        self.homing.speed.step(wanted, ramp, counts, limit, &parameters, now);
    }

    fn next_phase(&mut self, now: Instant) -> Phase {
        let Sight { revolution, switches: [negative, positive], .. } = self.sight;
        let on = |way| if way == Way::Negative { negative } else { positive };
        let phase = self.homing.phase;
        if phase.moves() && self.is_blocked(now) {
            return Phase::Failed;
        }
        match phase {
            Phase::SeekSwitch(way) if on(way) => Phase::LeaveSwitch(way),
            Phase::SeekSwitch(way) if on(way.back()) => Phase::Failed,
            Phase::LeaveSwitch(way) if !on(way) => {
                self.come_home_at(self.switch_angle(way));
                Phase::Done
            }
            Phase::SeekIndex(_, began) if revolution != began => {
                self.come_home_at(self.index_angle(began.max(revolution)));
                Phase::Done
            }
            phase => phase,
        }
    }

    fn is_blocked(&mut self, now: Instant) -> bool {
        if !self.homing.speed.stands() {
            self.homing.stalled_since = None;
            return false;
        }
        let since = *self.homing.stalled_since.get_or_insert(now);
        now.since(since) >= STALL
    }

    /// The angle of the joint at which the switch on this side begins, rad.
    fn switch_angle(&self, way: Way) -> f64 {
        let [least, most] = self.parameters.limit_switches().unwrap_or_default();
        match (self.parameters.direction(), way) {
            (Direction::Positive, Way::Negative) | (Direction::Negative, Way::Positive) => least,
            (Direction::Positive, Way::Positive) | (Direction::Negative, Way::Negative) => most,
        }
    }

    /// The angle of the joint at the index with which a revolution of the motor begins, rad.
    fn index_angle(&self, revolution: i64) -> f64 {
        let revolution = i32::try_from(self.parameters.direction().apply(revolution)).unwrap_or_default();
        f64::from(revolution) * TAU / self.parameters.transmission().ratio().factor()
    }

    /// Home is where the joint is at `angle`, rad.
    fn come_home_at(&mut self, angle: f64) {
        let motor = angle * self.parameters.transmission().ratio().factor();
        let counts = self.parameters.encoder().counts(motor);
        self.come_home(counts.wrapping_add(self.faults.encoder_offset));
    }

    /// Home is where the counter, without its origin, shows `counts`: 6064h is −607Ch there (CiA 402-2, home offset).
    fn come_home(&mut self, counts: i32) {
        let offset = self.number(od::HOME_OFFSET.address()).and_then(|offset| i32::try_from(offset).ok());
        self.count_from(counts.wrapping_add(offset.unwrap_or_default()));
    }
}
