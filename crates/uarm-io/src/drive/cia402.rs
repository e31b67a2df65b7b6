//! The power state machine of CiA 402-2: statusword, controlword, states, commands, transitions.
//!
//! One definition for both ends: the master decodes what a drive encodes and the other way round.

use core::fmt;

/// The states of the power state machine (CiA 402-2, 6041h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PowerState {
    /// Initialising; no command is heard.
    NotReadyToSwitchOn,
    /// Initialised; no power.
    SwitchOnDisabled,
    /// Power may be switched on.
    ReadyToSwitchOn,
    /// Power stage on, no torque.
    SwitchedOn,
    /// Torque follows its target; the only state in which the brake is open.
    OperationEnabled,
    /// Stopping or stopped by a quick stop.
    QuickStopActive,
    /// Stopping because of a fault.
    FaultReactionActive,
    /// In fault, waiting for a fault reset.
    Fault,
}

impl PowerState {
    /// All states.
    pub const ALL: [Self; 8] = [
        Self::NotReadyToSwitchOn,
        Self::SwitchOnDisabled,
        Self::ReadyToSwitchOn,
        Self::SwitchedOn,
        Self::OperationEnabled,
        Self::QuickStopActive,
        Self::FaultReactionActive,
        Self::Fault,
    ];

    /// The state to which `command` leads from this one; this one again where the standard has no such transition.
    ///
    /// Transitions that a drive makes by itself are not here: 0 and 1 (initialising), 12 (quick stop done),
    /// 13 ([`PowerState::after_fault`]), 14 ([`PowerState::after_fault_reaction`]).
    /// *Enable operation* in *Ready to switch on* makes transitions 3 and 4 in one go, as the standard allows.
    pub const fn after(self, command: Command) -> Self {
        match (self, command) {
            (Self::SwitchOnDisabled, Command::Shutdown) => Self::ReadyToSwitchOn,
            (Self::ReadyToSwitchOn, Command::SwitchOn) => Self::SwitchedOn,
            (Self::ReadyToSwitchOn | Self::SwitchedOn, Command::EnableOperation) => Self::OperationEnabled,
            (Self::OperationEnabled, Command::SwitchOn) => Self::SwitchedOn,
            (Self::SwitchedOn | Self::OperationEnabled, Command::Shutdown) => Self::ReadyToSwitchOn,
            (Self::OperationEnabled, Command::QuickStop) => Self::QuickStopActive,
            (Self::ReadyToSwitchOn | Self::SwitchedOn, Command::QuickStop) => Self::SwitchOnDisabled,
            (
                Self::ReadyToSwitchOn | Self::SwitchedOn | Self::OperationEnabled | Self::QuickStopActive,
                Command::DisableVoltage,
            ) => Self::SwitchOnDisabled,
            (Self::Fault, Command::FaultReset) => Self::SwitchOnDisabled,
            (state, _) => state,
        }
    }

    /// The state when a fault occurs (transition 13).
    pub const fn after_fault(self) -> Self {
        match self {
            Self::Fault => Self::Fault,
            _ => Self::FaultReactionActive,
        }
    }

    /// The state when the fault reaction is done (transition 14).
    pub const fn after_fault_reaction(self) -> Self {
        match self {
            Self::FaultReactionActive => Self::Fault,
            state => state,
        }
    }

    /// True where the power stage is on, or may be.
    pub const fn has_power(self) -> bool {
        matches!(self, Self::SwitchedOn | Self::OperationEnabled | Self::QuickStopActive | Self::FaultReactionActive)
    }

    /// The command that brings a drive in this state one step nearer to *Operation enabled*; `None` where one can only
    /// wait.
    pub const fn command_towards_operation(self) -> Option<Command> {
        match self {
            Self::NotReadyToSwitchOn | Self::FaultReactionActive => None,
            Self::SwitchOnDisabled => Some(Command::Shutdown),
            Self::ReadyToSwitchOn => Some(Command::SwitchOn),
            Self::SwitchedOn | Self::OperationEnabled => Some(Command::EnableOperation),
            Self::QuickStopActive => Some(Command::DisableVoltage),
            Self::Fault => Some(Command::FaultReset),
        }
    }

    /// The bits of a statusword that tell the state, as an encoder sets them.
    const fn status_bits(self) -> u16 {
        match self {
            Self::NotReadyToSwitchOn => 0b000_0000,
            Self::SwitchOnDisabled => 0b100_0000,
            Self::ReadyToSwitchOn => 0b010_0001,
            Self::SwitchedOn => 0b010_0011,
            Self::OperationEnabled => 0b010_0111,
            Self::QuickStopActive => 0b000_0111,
            Self::FaultReactionActive => 0b000_1111,
            Self::Fault => 0b000_1000,
        }
    }
}

impl fmt::Display for PowerState {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::NotReadyToSwitchOn => "Not ready to switch on",
            Self::SwitchOnDisabled => "Switch on disabled",
            Self::ReadyToSwitchOn => "Ready to switch on",
            Self::SwitchedOn => "Switched on",
            Self::OperationEnabled => "Operation enabled",
            Self::QuickStopActive => "Quick stop active",
            Self::FaultReactionActive => "Fault reaction active",
            Self::Fault => "Fault",
        })
    }
}

/// The statusword, object 6041h.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Statusword(u16);

impl Statusword {
    /// Bit 4: the power stage has its voltage.
    pub const VOLTAGE_ENABLED: u16 = 1 << 4;
    /// Bit 7: a warning is present; the state is unchanged.
    pub const WARNING: u16 = 1 << 7;
    /// Bit 9: the drive obeys its controlword.
    pub const REMOTE: u16 = 1 << 9;
    /// Bit 10 in homing mode: the motor stands.
    pub const TARGET_REACHED: u16 = 1 << 10;
    /// Bit 11: an internal limit is active, for example the drive's torque limit.
    pub const INTERNAL_LIMIT_ACTIVE: u16 = 1 << 11;
    /// Bit 12 in the cyclic synchronous modes: the drive follows its target.
    pub const FOLLOWS_TARGET: u16 = 1 << 12;

    /// Bit 12 in homing mode: the home position was found.
    pub const HOMING_ATTAINED: u16 = 1 << 12;
    /// Bit 13 in homing mode: it was not, and will not be.
    pub const HOMING_ERROR: u16 = 1 << 13;

    /// A statusword with these bits.
    pub const fn from_bits(bits: u16) -> Self {
        Self(bits)
    }

    /// The statusword of a drive in `state`, with no other bit set.
    pub const fn of(state: PowerState) -> Self {
        Self(state.status_bits())
    }

    /// This statusword with `bits` set as well.
    #[must_use]
    pub const fn with(self, bits: u16) -> Self {
        Self(self.0 | bits)
    }

    /// All 16 bits.
    pub const fn bits(self) -> u16 {
        self.0
    }

    /// True if all of `bits` are set.
    pub const fn contains(self, bits: u16) -> bool {
        self.0 & bits == bits
    }

    /// How far a homing procedure is, in homing mode (CiA 402-2, table of bits 10, 12 and 13).
    pub const fn homing(self) -> HomingState {
        let stands = self.contains(Self::TARGET_REACHED);
        let attained = self.contains(Self::HOMING_ATTAINED);
        match (self.contains(Self::HOMING_ERROR), attained, stands) {
            (true, _, _) => HomingState::Failed,
            (false, true, true) => HomingState::Done,
            (false, true, false) => HomingState::Attained,
            (false, false, true) => HomingState::Idle,
            (false, false, false) => HomingState::Running,
        }
    }

    /// The state of the power state machine; `None` for a pattern that the standard does not define.
    pub const fn state(self) -> Option<PowerState> {
        // Bits 0-3 and 6 tell these four states; bit 5 (quick stop, active low) does not count there.
        match self.0 & 0b100_1111 {
            0b000_0000 => return Some(PowerState::NotReadyToSwitchOn),
            0b100_0000 => return Some(PowerState::SwitchOnDisabled),
            0b000_1111 => return Some(PowerState::FaultReactionActive),
            0b000_1000 => return Some(PowerState::Fault),
            _ => {}
        }
        match self.0 & 0b110_1111 {
            0b010_0001 => Some(PowerState::ReadyToSwitchOn),
            0b010_0011 => Some(PowerState::SwitchedOn),
            0b010_0111 => Some(PowerState::OperationEnabled),
            0b000_0111 => Some(PowerState::QuickStopActive),
            _ => None,
        }
    }
}

impl fmt::Display for Statusword {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.state() {
            Some(state) => write!(formatter, "{state} (statusword {:04X}h)", self.0),
            None => write!(formatter, "no state of CiA 402 (statusword {:04X}h)", self.0),
        }
    }
}

/// How far a homing procedure is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HomingState {
    /// In progress.
    Running,
    /// Interrupted, or not started.
    Idle,
    /// The home position was found, and the motor still moves.
    Attained,
    /// The home position was found, and the motor stands.
    Done,
    /// It failed.
    Failed,
}

/// The commands of the power state machine (CiA 402-2, 6040h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Command {
    /// Towards *Ready to switch on*, from either side.
    Shutdown,
    /// Towards *Switched on*, from either side; from above the standard calls it *Disable operation*.
    SwitchOn,
    /// To *Operation enabled*.
    EnableOperation,
    /// To *Switch on disabled* at once; the motor coasts, brakes close.
    DisableVoltage,
    /// Stop as 605Ah says.
    QuickStop,
    /// Leave *Fault*; acts on the rising edge of its bit only.
    FaultReset,
}

impl fmt::Display for Command {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Shutdown => "Shutdown",
            Self::SwitchOn => "Switch on",
            Self::EnableOperation => "Enable operation",
            Self::DisableVoltage => "Disable voltage",
            Self::QuickStop => "Quick stop",
            Self::FaultReset => "Fault reset",
        })
    }
}

/// The controlword, object 6040h.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Controlword(u16);

impl Controlword {
    const SWITCH_ON: u16 = 1 << 0;
    const ENABLE_VOLTAGE: u16 = 1 << 1;
    /// Active low: cleared, it asks for a quick stop.
    const NO_QUICK_STOP: u16 = 1 << 2;
    const ENABLE_OPERATION: u16 = 1 << 3;
    const FAULT_RESET: u16 = 1 << 7;
    /// Bit 4 in homing mode: the procedure goes on while it is set, and starts when it rises.
    pub const HOMING_START: u16 = 1 << 4;

    /// A controlword with these bits.
    pub const fn from_bits(bits: u16) -> Self {
        Self(bits)
    }

    /// The controlword that carries `command`.
    pub const fn of(command: Command) -> Self {
        let ready = Self::ENABLE_VOLTAGE | Self::NO_QUICK_STOP;
        Self(match command {
            Command::Shutdown => ready,
            Command::SwitchOn => ready | Self::SWITCH_ON,
            Command::EnableOperation => ready | Self::SWITCH_ON | Self::ENABLE_OPERATION,
            Command::DisableVoltage => 0,
            Command::QuickStop => Self::ENABLE_VOLTAGE,
            Command::FaultReset => Self::FAULT_RESET,
        })
    }

    /// This controlword with `bits` set as well.
    #[must_use]
    pub const fn with(self, bits: u16) -> Self {
        Self(self.0 | bits)
    }

    /// True if all of `bits` are set.
    pub const fn contains(self, bits: u16) -> bool {
        self.0 & bits == bits
    }

    /// True if it asks for *Operation enabled*, whatever bits of the mode are set beside.
    pub const fn enables(self) -> bool {
        matches!(self.command(self), Command::EnableOperation)
    }

    /// All 16 bits.
    pub const fn bits(self) -> u16 {
        self.0
    }

    /// The command that a drive reads from this controlword after `previous`: a fault reset is a rising edge.
    pub const fn command(self, previous: Self) -> Command {
        let switch_on = self.0 & Self::SWITCH_ON != 0;
        let enable_operation = self.0 & Self::ENABLE_OPERATION != 0;
        if self.0 & Self::FAULT_RESET != 0 && previous.0 & Self::FAULT_RESET == 0 {
            Command::FaultReset
        } else if self.0 & Self::ENABLE_VOLTAGE == 0 {
            Command::DisableVoltage
        } else if self.0 & Self::NO_QUICK_STOP == 0 {
            Command::QuickStop
        } else if !switch_on {
            Command::Shutdown
        } else if !enable_operation {
            Command::SwitchOn
        } else {
            Command::EnableOperation
        }
    }
}

#[cfg(test)]
mod tests;
