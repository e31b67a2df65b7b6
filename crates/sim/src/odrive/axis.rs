//! What an emulated axis does, without I/O: frames and instants in, frames out.

use super::parameters::AxisParameters;
use crate::outbox::Outbox;
use crate::plant::Brake;
use core::time::Duration;
use uarm_io::drive::odrive::axis_error::AxisError;
use uarm_io::drive::odrive::wire::{
    self, AxisState, ControllerMode, EncoderEstimates, Heartbeat, Message, Supply, Temperature,
};
use uarm_io::time::Instant;

/// A fault that a test injects. They last until they are repaired.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AxisFault {
    /// The axis disarms with this error, which [`Message::ClearErrors`] does not clear before the repair.
    Error(AxisError),
    /// The plug comes off the bus: the axis hears and says nothing, and goes on by itself.
    BusDisconnected,
    /// Its supply reads as this.
    SupplyVoltage {
        /// mV.
        millivolts: u32,
    },
    /// Its motor's temperature reads as this.
    Temperature {
        /// 0.1 °C.
        tenths: i16,
    },
    /// It answers no request for temperatures or supply any more.
    ReadingsSilent,
}

/// Temperature of an inverter that does little, °C.
const AMBIENT: f32 = 20.0;

/// One emulated axis.
#[derive(Clone, Copy, Debug)]
pub struct EmulatedAxis {
    parameters: AxisParameters,
    state: AxisState,
    error: AxisError,
    lasting_error: AxisError,
    off_bus: bool,
    mode: Option<ControllerMode>,
    torque: f64,
    turns: f32,
    heartbeat_due: Option<Instant>,
    estimates_due: Option<Instant>,
    watchdog_due: Option<Instant>,
    supply: f32,
    temperature: f32,
    readings_silent: bool,
}

impl EmulatedAxis {
    /// An axis without supply; `power_on` starts it.
    pub const fn new(parameters: AxisParameters) -> Self {
        Self {
            parameters,
            state: AxisState(0),
            error: AxisError(0),
            lasting_error: AxisError(0),
            off_bus: false,
            mode: None,
            torque: 0.0,
            turns: 0.0,
            heartbeat_due: None,
            estimates_due: None,
            watchdog_due: None,
            supply: parameters.supply,
            temperature: parameters.temperature,
            readings_silent: false,
        }
    }

    /// What it is made of.
    pub const fn parameters(&self) -> &AxisParameters {
        &self.parameters
    }

    /// What it does.
    pub const fn state(&self) -> AxisState {
        self.state
    }

    /// Its errors.
    pub const fn error(&self) -> AxisError {
        self.error
    }

    /// True if it follows its torque.
    pub fn is_armed(&self) -> bool {
        self.state == AxisState::CLOSED_LOOP_CONTROL
    }

    /// What a brake at its brake output does to the joint: it is released while the axis is armed.
    pub fn brake(&self) -> Brake {
        if self.is_armed() { Brake::Released } else { Brake::Engaged }
    }

    /// The motor's torque at the joint in the joint's positive direction, N·m.
    pub fn torque(&self) -> f64 {
        if !self.is_armed() || self.mode != Some(ControllerMode::TORQUE) {
            return 0.0;
        }
        let limit = self.parameters.maximum_torque;
        let motor = self.parameters.encoder.direction().apply(self.torque.clamp(-limit, limit));
        motor * self.parameters.transmission.torque_factor()
    }

    /// Boots: idle, without errors, cyclic messages running.
    pub(super) fn power_on(&mut self, now: Instant) {
        self.state = AxisState::IDLE;
        self.heartbeat_due = Some(now);
        self.estimates_due = self.parameters.encoder_period.map(|_| now + self.parameters.encoder_phase);
    }

    pub(super) fn inject(&mut self, fault: AxisFault) {
        match fault {
            AxisFault::Error(error) => {
                self.lasting_error = AxisError(self.lasting_error.0 | error.0);
                self.fail(error);
            }
            AxisFault::BusDisconnected => self.off_bus = true,
            AxisFault::SupplyVoltage { millivolts } => self.supply = narrow(f64::from(millivolts) * 1e-3),
            AxisFault::Temperature { tenths } => self.temperature = f32::from(tenths) * 0.1,
            AxisFault::ReadingsSilent => self.readings_silent = true,
        }
    }

    pub(super) fn repair(&mut self) {
        self.lasting_error = AxisError::default();
        self.off_bus = false;
        self.readings_silent = false;
        (self.supply, self.temperature) = (self.parameters.supply, self.parameters.temperature);
    }

    /// Takes the joint's angle, rad, into the position estimate.
    pub(super) fn measure(&mut self, angle: f64) {
        let encoder = &self.parameters.encoder;
        let counts = f64::from(encoder.counts(angle * self.parameters.transmission.ratio().factor()));
        self.turns = narrow(counts / f64::from(encoder.description().counts_per_revolution));
    }

    /// Handles a message to this axis, other than a request. True if it cleared the errors of an axis that is idle.
    pub(super) fn on_message(&mut self, message: Message, data: &[u8], now: Instant) -> bool {
        if self.off_bus {
            return false;
        }
        match message {
            Message::SetAxisState => {
                if let Ok(state) = wire::decode_state(data) {
                    self.go_to(state, now);
                }
            }
            Message::SetControllerMode => self.mode = ControllerMode::decode(data).ok().or(self.mode),
            Message::SetInputTorque => {
                if let Ok(torque) = wire::decode_torque(data)
                    && torque.is_finite()
                {
                    self.torque = f64::from(torque);
                    self.feed(now);
                }
            }
            Message::ClearErrors => {
                self.error = self.lasting_error;
                return !self.is_armed();
            }
            Message::Estop => self.fail(AxisError::ESTOP_REQUESTED),
            Message::Version
            | Message::Heartbeat
            | Message::EncoderEstimates
            | Message::Temperature
            | Message::BusVoltageCurrent => {}
        }
        false
    }

    /// Answers a request for anything but the position.
    pub(super) fn tell(&self, message: Message, now: Instant, outbox: &mut Outbox) {
        let node = self.parameters.node;
        let answer = match message {
            Message::Version => Some(self.parameters.version.frame(node)),
            Message::Temperature if !self.readings_silent => {
                Some(Temperature { inverter: AMBIENT, motor: self.temperature }.frame(node))
            }
            Message::BusVoltageCurrent if !self.readings_silent => {
                Some(Supply { voltage: self.supply, current: 0.0 }.frame(node))
            }
            _ => None,
        };
        if let Some(frame) = answer.filter(|_| !self.off_bus) {
            outbox.push(frame, now);
        }
    }

    /// Sends the position, as it was last measured.
    pub(super) fn answer(&self, now: Instant, outbox: &mut Outbox) {
        if !self.off_bus {
            let estimates = EncoderEstimates { position: self.turns, velocity: 0.0 };
            outbox.push(estimates.frame(self.parameters.node), now);
        }
    }

    /// True if a cyclic position is due by `now`.
    pub(super) fn measures_at(&self, now: Instant) -> bool {
        self.estimates_due.is_some_and(|due| due <= now)
    }

    /// The next instant at which the axis does something by itself.
    pub(super) fn next_deadline(&self) -> Option<Instant> {
        [self.heartbeat_due, self.estimates_due, self.watchdog_due].into_iter().flatten().min()
    }

    /// Does what is due by `now`.
    pub(super) fn on_time(&mut self, now: Instant, outbox: &mut Outbox) {
        if self.watchdog_due.is_some_and(|due| due <= now) {
            self.watchdog_due = None;
            self.fail(AxisError::WATCHDOG_TIMER_EXPIRED);
        }
        if let Some(due) = self.heartbeat_due.filter(|due| *due <= now) {
            self.heartbeat_due = Some(due + self.parameters.heartbeat);
            if !self.off_bus {
                let heartbeat = Heartbeat { error: self.error, state: self.state, ..Heartbeat::default() };
                outbox.push(heartbeat.frame(self.parameters.node), now);
            }
        }
        if let Some(due) = self.estimates_due.filter(|due| *due <= now) {
            let period = self.parameters.encoder_period.unwrap_or(Duration::MAX);
            self.estimates_due = Some(due + period);
            self.answer(now, outbox);
        }
    }

    /// Arms only without errors. Other states than the two are not emulated.
    fn go_to(&mut self, state: AxisState, now: Instant) {
        match state {
            AxisState::CLOSED_LOOP_CONTROL if self.error.is_none() => {
                self.state = state;
                self.feed(now);
            }
            AxisState::IDLE => self.disarm(),
            _ => {}
        }
    }

    /// The watchdog runs while the axis is armed.
    fn feed(&mut self, now: Instant) {
        self.watchdog_due = self.parameters.watchdog.filter(|_| self.is_armed()).map(|limit| now + limit);
    }

    fn fail(&mut self, error: AxisError) {
        self.error = AxisError(self.error.0 | error.0);
        self.disarm();
    }

    fn disarm(&mut self) {
        self.state = AxisState::IDLE;
        self.torque = 0.0;
        self.watchdog_due = None;
    }
}

/// The nearest `f32`.
#[expect(clippy::as_conversions, reason = "the only way from f64 to f32")]
const fn narrow(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests;
