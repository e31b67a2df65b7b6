//! The states of a run, its events, and the one table of what leads where; `docs/safety.md` has the same table.

use std::fmt;

/// What a run is doing, whichever law is in control.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum State {
    /// Nothing is under way: torques zero, brakes closed, or on their way there. Every run begins and should end so.
    #[default]
    Disarmed,
    /// The drives are set up, without power.
    Configuring,
    /// The drives are set up, and the motion was found to be within the limits; brakes still closed.
    Armed,
    /// Brakes open: the drives follow the law's torques.
    Running,
    /// Somebody asked for the end: the torques fade to zero.
    Stopping,
    /// Something failed: torques zero, quick stop, brakes. Only [`Event::Rearm`] leads away.
    Faulted,
}

/// What moves a run from state to state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Event {
    /// The run begins: the drives may be set up.
    Begin,
    /// The drives are set up, and the motion may be made.
    Prepared,
    /// The drives are enabled, brakes open.
    Enabled,
    /// The motion is over.
    Completed,
    /// Somebody asks for the end.
    StopRequested,
    /// Somebody asks again: without a ramp.
    StopRequestedAgain,
    /// The torques have faded to zero.
    Faded,
    /// Anything failed.
    Fault,
    /// An operator looked at the fault and says that a run may begin again.
    Rearm,
}

/// Where `event` leads from `state`. What is not listed is refused, and changes nothing.
pub const TRANSITIONS: &[(State, Event, State)] = &[
    (State::Disarmed, Event::Begin, State::Configuring),
    (State::Disarmed, Event::Fault, State::Faulted),
    (State::Configuring, Event::Prepared, State::Armed),
    (State::Configuring, Event::StopRequested, State::Disarmed),
    (State::Configuring, Event::Fault, State::Faulted),
    (State::Armed, Event::Enabled, State::Running),
    (State::Armed, Event::StopRequested, State::Disarmed),
    (State::Armed, Event::Fault, State::Faulted),
    (State::Running, Event::Completed, State::Disarmed),
    (State::Running, Event::StopRequested, State::Stopping),
    (State::Running, Event::Fault, State::Faulted),
    (State::Stopping, Event::StopRequestedAgain, State::Disarmed),
    (State::Stopping, Event::Faded, State::Disarmed),
    (State::Stopping, Event::Fault, State::Faulted),
    (State::Faulted, Event::Fault, State::Faulted),
    (State::Faulted, Event::Rearm, State::Disarmed),
];

/// Whether torque may flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TorquePermission {
    /// None: the drives are to be stopped.
    Withheld,
    /// Torque may flow.
    Granted(Authority),
}

/// How much torque the law has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Authority {
    /// Up to the limits of the robot.
    #[default]
    Full,
    /// Within an envelope that shrinks to zero.
    Fading,
}

impl State {
    /// Every state.
    pub const ALL: [Self; 6] =
        [Self::Disarmed, Self::Configuring, Self::Armed, Self::Running, Self::Stopping, Self::Faulted];

    /// Where `event` leads; nothing if it is refused here.
    pub fn after(self, event: Event) -> Option<Self> {
        TRANSITIONS.iter().find(|(from, by, _)| *from == self && *by == event).map(|(_, _, to)| *to)
    }

    /// Whether torque may flow in this state.
    pub const fn torque(self) -> TorquePermission {
        match self {
            Self::Running => TorquePermission::Granted(Authority::Full),
            Self::Stopping => TorquePermission::Granted(Authority::Fading),
            Self::Disarmed | Self::Configuring | Self::Armed | Self::Faulted => TorquePermission::Withheld,
        }
    }
}

impl Event {
    /// Every event.
    pub const ALL: [Self; 9] = [
        Self::Begin,
        Self::Prepared,
        Self::Enabled,
        Self::Completed,
        Self::StopRequested,
        Self::StopRequestedAgain,
        Self::Faded,
        Self::Fault,
        Self::Rearm,
    ];
}

impl fmt::Display for State {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Disarmed => "disarmed",
            Self::Configuring => "configuring",
            Self::Armed => "armed",
            Self::Running => "running",
            Self::Stopping => "stopping",
            Self::Faulted => "faulted",
        })
    }
}

impl fmt::Display for Event {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Begin => "begin",
            Self::Prepared => "prepared",
            Self::Enabled => "enabled",
            Self::Completed => "completed",
            Self::StopRequested => "stop requested",
            Self::StopRequestedAgain => "stop requested again",
            Self::Faded => "faded",
            Self::Fault => "fault",
            Self::Rearm => "re-arm",
        })
    }
}
