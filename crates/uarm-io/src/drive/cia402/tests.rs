use super::*;
use proptest::prelude::*;

const COMMANDS: [Command; 6] = [
    Command::Shutdown,
    Command::SwitchOn,
    Command::EnableOperation,
    Command::DisableVoltage,
    Command::QuickStop,
    Command::FaultReset,
];

/// The table of the standard, written as it prints it (x = any): an independent second reading of the bits.
const PRINTED: [(&str, PowerState); 8] = [
    ("x0xx0000", PowerState::NotReadyToSwitchOn),
    ("x1xx0000", PowerState::SwitchOnDisabled),
    ("x01x0001", PowerState::ReadyToSwitchOn),
    ("x01x0011", PowerState::SwitchedOn),
    ("x01x0111", PowerState::OperationEnabled),
    ("x00x0111", PowerState::QuickStopActive),
    ("x0xx1111", PowerState::FaultReactionActive),
    ("x0xx1000", PowerState::Fault),
];

fn matches(pattern: &str, bits: u16) -> bool {
    pattern.bytes().rev().enumerate().all(|(bit, wanted)| match wanted {
        b'x' => true,
        digit => (bits >> bit) & 1 == u16::from(digit - b'0'),
    })
}

#[test]
fn every_statusword_decodes_as_the_standard_prints_it() {
    for bits in 0..=u16::MAX {
        let printed = PRINTED.iter().find(|(pattern, _)| matches(pattern, bits)).map(|(_, state)| *state);
        assert_eq!(Statusword::from_bits(bits).state(), printed, "{bits:016b}");
    }
}

#[test]
fn controlwords_have_the_usual_values() {
    let values = COMMANDS.map(|command| Controlword::of(command).bits());
    assert_eq!(values, [0x06, 0x07, 0x0F, 0x00, 0x02, 0x80]);
}

/// The commands as the standard prints them, bit 7 first.
const PRINTED_COMMANDS: [(&str, Command); 5] = [
    ("0xxxx110", Command::Shutdown),
    ("0xxx0111", Command::SwitchOn),
    ("0xxx1111", Command::EnableOperation),
    ("0xxxxx0x", Command::DisableVoltage),
    ("0xxxx01x", Command::QuickStop),
];

#[test]
fn every_controlword_decodes_as_the_standard_prints_it() {
    const RESET: u16 = 0x80;
    for bits in (0..=u16::MAX).filter(|bits| bits & RESET == 0) {
        let printed = PRINTED_COMMANDS.iter().find(|(pattern, _)| matches(pattern, bits)).map(|(_, command)| *command);
        for previous in [0, RESET, 0x0F, u16::MAX].map(Controlword::from_bits) {
            assert_eq!(Some(Controlword::from_bits(bits).command(previous)), printed, "{bits:016b}");
        }
        // With bit 7 it is a fault reset, but only when the bit has just risen.
        let raised = Controlword::from_bits(bits | RESET);
        assert_eq!(raised.command(Controlword::from_bits(bits)), Command::FaultReset, "{bits:016b}");
        assert_eq!(Some(raised.command(Controlword::from_bits(RESET))), printed, "{bits:016b}");
    }
}

#[test]
fn bits_of_a_statusword_are_set_and_asked_for_together() {
    let word = Statusword::from_bits(0b0001).with(0b0110);
    assert_eq!(word.bits(), 0b0111);
    assert_eq!(word.with(0b0101).bits(), 0b0111, "bits that are set stay set");
    assert!(word.contains(0b0111) && word.contains(0b0010) && word.contains(0));
    assert!(!word.contains(0b1000) && !word.contains(0b1001), "all of the bits, not one of them");
}

#[test]
fn the_bits_beside_the_state_lie_where_the_standard_puts_them() {
    let bits = [
        Statusword::VOLTAGE_ENABLED,
        Statusword::WARNING,
        Statusword::REMOTE,
        Statusword::INTERNAL_LIMIT_ACTIVE,
        Statusword::FOLLOWS_TARGET,
    ];
    assert_eq!(bits, [0x0010, 0x0080, 0x0200, 0x0800, 0x1000]);
}

/// The transitions of CiA 402-2 that a command makes, numbered as the standard numbers them.
const TRANSITIONS: [(PowerState, Command, PowerState); 15] = {
    use Command::*;
    use PowerState::*;
    [
        (PowerState::SwitchOnDisabled, Shutdown, ReadyToSwitchOn),  // 2
        (ReadyToSwitchOn, Command::SwitchOn, SwitchedOn),           // 3
        (ReadyToSwitchOn, EnableOperation, OperationEnabled),       // 3 and 4
        (SwitchedOn, EnableOperation, OperationEnabled),            // 4
        (OperationEnabled, Command::SwitchOn, SwitchedOn),          // 5
        (SwitchedOn, Shutdown, ReadyToSwitchOn),                    // 6
        (ReadyToSwitchOn, QuickStop, PowerState::SwitchOnDisabled), // 7
        (ReadyToSwitchOn, DisableVoltage, PowerState::SwitchOnDisabled), // 7
        (OperationEnabled, Shutdown, ReadyToSwitchOn),              // 8
        (OperationEnabled, DisableVoltage, PowerState::SwitchOnDisabled), // 9
        (SwitchedOn, QuickStop, PowerState::SwitchOnDisabled),      // 10
        (SwitchedOn, DisableVoltage, PowerState::SwitchOnDisabled), // 10
        (OperationEnabled, QuickStop, QuickStopActive),             // 11
        (QuickStopActive, DisableVoltage, PowerState::SwitchOnDisabled), // 12
        (Fault, FaultReset, PowerState::SwitchOnDisabled),          // 15
    ]
};

#[test]
fn a_command_makes_the_transitions_of_the_standard_and_no_other() {
    for state in PowerState::ALL {
        for command in COMMANDS {
            let listed = TRANSITIONS.iter().find(|(from, by, _)| (*from, *by) == (state, command));
            let expected = listed.map_or(state, |(_, _, to)| *to);
            assert_eq!(state.after(command), expected, "{state}, {command}");
        }
    }
}

#[test]
fn a_fault_ends_in_fault_by_its_reaction() {
    for state in PowerState::ALL {
        let reacting = if state == PowerState::Fault { PowerState::Fault } else { PowerState::FaultReactionActive };
        assert_eq!(state.after_fault(), reacting, "{state}");
        let done = if state == PowerState::FaultReactionActive { PowerState::Fault } else { state };
        assert_eq!(state.after_fault_reaction(), done, "{state}");
    }
}

#[test]
fn a_fault_reset_needs_an_edge() {
    let reset = Controlword::of(Command::FaultReset);
    assert_eq!(reset.command(Controlword::default()), Command::FaultReset);
    assert_eq!(reset.command(reset), Command::DisableVoltage);
}

#[test]
fn every_state_but_the_waiting_ones_reaches_operation() {
    for start in PowerState::ALL {
        let mut state = start;
        for _ in 0..4 {
            let Some(command) = state.command_towards_operation() else { break };
            state = state.after(command);
        }
        let waits = matches!(start, PowerState::NotReadyToSwitchOn | PowerState::FaultReactionActive);
        assert_eq!(state == PowerState::OperationEnabled, !waits, "{start}");
    }
}

#[test]
fn only_enable_operation_leads_to_operation() {
    for state in PowerState::ALL {
        for command in COMMANDS {
            let entered = state != PowerState::OperationEnabled && state.after(command) == PowerState::OperationEnabled;
            assert!(!entered || command == Command::EnableOperation, "{state} {command}");
        }
    }
}

proptest! {
    #[test]
    fn status_survives_the_wire(state in 0_usize..8, other in any::<u16>()) {
        let state = PowerState::ALL[state];
        // Bits 0-3, 5 and 6 belong to the state.
        let status = Statusword::of(state).with(other & !0b110_1111);
        prop_assert_eq!(status.state(), Some(state));
    }

    #[test]
    fn commands_survive_the_wire(command in 0_usize..6) {
        let command = COMMANDS[command];
        prop_assert_eq!(Controlword::of(command).command(Controlword::default()), command);
    }
}

/// The table of bits 13, 12 and 10 in homing mode as CiA 402-2 prints it.
#[test]
fn homing_states_are_read_as_the_standard_prints_them() {
    let read = |error: u16, attained: u16, reached: u16| {
        Statusword::from_bits(0x0027 | error << 13 | attained << 12 | reached << 10).homing()
    };
    assert_eq!(read(0, 0, 0), HomingState::Running);
    assert_eq!(read(0, 0, 1), HomingState::Idle);
    assert_eq!(read(0, 1, 0), HomingState::Attained);
    assert_eq!(read(0, 1, 1), HomingState::Done);
    assert_eq!(read(1, 0, 0), HomingState::Failed);
    assert_eq!(read(1, 0, 1), HomingState::Failed);
}

#[test]
fn bits_of_the_mode_leave_the_command_as_it_is() {
    let start = Controlword::of(Command::EnableOperation).with(Controlword::HOMING_START);
    assert_eq!(start.bits(), 0x001F);
    assert!(start.enables() && start.contains(Controlword::HOMING_START));
    assert!(!Controlword::of(Command::SwitchOn).with(Controlword::HOMING_START).enables());
}
