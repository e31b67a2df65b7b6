//! Decides in each cycle whether torque may flow, independently of the law in control.
//!
//! A fault latches: the first cause is kept, later ones are counted, and only an operator's [`Supervisor::rearm`] leads away
//! from it. A run does not re-arm itself; each `uarm run` is an operator's new start.

mod transitions;

pub use transitions::{Authority, Event, State, TRANSITIONS, TorquePermission};

/// The state of one run, and the first cause `F` of a fault.
#[derive(Clone, Debug)]
pub struct Supervisor<F> {
    state: State,
    first_cause: Option<F>,
    later_faults: u64,
}

impl<F> Default for Supervisor<F> {
    /// Disarmed, without a fault.
    fn default() -> Self {
        Self { state: State::default(), first_cause: None, later_faults: 0 }
    }
}

impl<F> Supervisor<F> {
    /// What the run is doing.
    pub const fn state(&self) -> State {
        self.state
    }

    /// Whether torque may flow now.
    pub const fn torque(&self) -> TorquePermission {
        self.state.torque()
    }

    /// Takes an event that is no fault. One that the table refuses changes nothing.
    pub fn take(&mut self, event: Ordinary) {
        if let Some(next) = self.state.after(event.into()) {
            self.state = next;
        }
    }

    /// Takes a fault, from whatever state: the first is kept as the cause, later ones are counted.
    pub fn fault(&mut self, cause: F) {
        if let Some(next) = self.state.after(Event::Fault) {
            self.state = next;
        }
        if self.first_cause.is_none() {
            self.first_cause = Some(cause);
        } else {
            self.later_faults = self.later_faults.saturating_add(1);
        }
    }

    /// Why the run faulted.
    pub const fn first_cause(&self) -> Option<&F> {
        self.first_cause.as_ref()
    }

    /// Faults after the first.
    pub const fn later_faults(&self) -> u64 {
        self.later_faults
    }

    /// An operator's word that a run may begin again: returns the cause of the fault that was latched, and disarms. Nothing
    /// happens without a fault.
    pub fn rearm(&mut self) -> Option<F> {
        if let Some(next) = self.state.after(Event::Rearm) {
            self.state = next;
            self.later_faults = 0;
            return self.first_cause.take();
        }
        None
    }

    /// The first cause, at the end of a run.
    pub fn into_first_cause(self) -> Option<F> {
        self.first_cause
    }
}

/// An event that neither brings a fault nor takes one away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ordinary {
    /// See [`Event::Begin`].
    Begin,
    /// See [`Event::Prepared`].
    Prepared,
    /// See [`Event::Enabled`].
    Enabled,
    /// See [`Event::Completed`].
    Completed,
    /// See [`Event::StopRequested`].
    StopRequested,
    /// See [`Event::StopRequestedAgain`].
    StopRequestedAgain,
    /// See [`Event::Faded`].
    Faded,
}

impl From<Ordinary> for Event {
    fn from(event: Ordinary) -> Self {
        match event {
            Ordinary::Begin => Self::Begin,
            Ordinary::Prepared => Self::Prepared,
            Ordinary::Enabled => Self::Enabled,
            Ordinary::Completed => Self::Completed,
            Ordinary::StopRequested => Self::StopRequested,
            Ordinary::StopRequestedAgain => Self::StopRequestedAgain,
            Ordinary::Faded => Self::Faded,
        }
    }
}
