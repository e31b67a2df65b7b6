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
