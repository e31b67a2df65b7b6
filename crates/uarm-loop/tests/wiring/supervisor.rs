//! No torque without permission, no permission after a fault without an operator.

use std::collections::BTreeSet;

use proptest::prelude::*;
use uarm_loop::supervisor::{Authority, Event, Ordinary, State, Supervisor, TRANSITIONS, TorquePermission};

/// Every event but faults and re-arming.
const ORDINARY: [Ordinary; 7] = [
    Ordinary::Begin,
    Ordinary::Prepared,
    Ordinary::Enabled,
    Ordinary::Completed,
    Ordinary::StopRequested,
    Ordinary::StopRequestedAgain,
    Ordinary::Faded,
];

/// The table of docs/safety.md: a row for each state, a column for each event; what is empty is refused.
fn documented() -> Vec<(String, String, String)> {
    let text = include_str!("../../../../docs/safety.md");
    let rows: Vec<Vec<&str>> = text
        .lines()
        .skip_while(|line| !line.starts_with("| state |"))
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    let events = &rows[0][1..];
    let row = |row: &Vec<&str>| -> Vec<_> {
        let cells = events.iter().zip(&row[1..]).filter(|(_, to)| !to.is_empty());
        cells.map(|(event, to)| (row[0].to_owned(), (*event).to_owned(), (*to).to_owned())).collect()
    };
    // Row 1 is the rule below the heads of the columns.
    rows[2..].iter().flat_map(row).collect()
}

#[test]
fn the_document_has_the_same_table() {
    let coded: BTreeSet<_> =
        TRANSITIONS.iter().map(|(from, by, to)| (from.to_string(), by.to_string(), to.to_string())).collect();
    assert_eq!(coded.len(), TRANSITIONS.len(), "no row twice");
    assert_eq!(documented().into_iter().collect::<BTreeSet<_>>(), coded);
}

#[test]
fn torque_flows_while_running_and_fades_while_stopping_and_nowhere_else() {
    for state in State::ALL {
        let expected = match state {
            State::Running => TorquePermission::Granted(Authority::Full),
            State::Stopping => TorquePermission::Granted(Authority::Fading),
            _ => TorquePermission::Withheld,
        };
        assert_eq!(state.torque(), expected, "{state}");
    }
}

/// All 54 pairs of a state and an event.
#[test]
fn every_state_faults_and_from_a_fault_only_re_arming_leads_away() {
    for state in State::ALL {
        assert_eq!(state.after(Event::Fault), Some(State::Faulted), "{state}");
        for event in Event::ALL {
            let next = state.after(event);
            assert!(event == Event::Fault || next != Some(State::Faulted), "{state}: {event}");
            if state == State::Faulted && event != Event::Fault {
                assert_eq!(next, (event == Event::Rearm).then_some(State::Disarmed), "{event}");
            }
            if next == Some(State::Running) {
                assert_eq!((state, event), (State::Armed, Event::Enabled), "the only way to torque");
            }
            if state == State::Stopping {
                assert_ne!(next, Some(State::Running), "{event}: a stop is not taken back");
            }
        }
    }
}

#[test]
fn the_first_cause_is_kept_and_later_ones_are_counted() {
    let mut supervisor = Supervisor::default();
    assert_eq!(supervisor.rearm(), None);
    for cause in ["an encoder", "a drive", "another drive"] {
        supervisor.fault(cause);
    }
    assert_eq!((supervisor.first_cause(), supervisor.later_faults()), (Some(&"an encoder"), 2));
    assert_eq!(supervisor.rearm(), Some("an encoder"));
    assert_eq!((supervisor.state(), supervisor.first_cause(), supervisor.later_faults()), (State::Disarmed, None, 0));
}

#[test]
fn the_first_cause_is_what_a_run_ends_with() {
    let mut supervisor = Supervisor::default();
    supervisor.fault("an encoder");
    supervisor.fault("a drive");
    assert_eq!(supervisor.into_first_cause(), Some("an encoder"));
    assert_eq!(Supervisor::<&str>::default().into_first_cause(), None);
}

/// What may happen to a supervisor.
#[derive(Clone, Copy, Debug)]
enum Step {
    Take(Ordinary),
    Fault,
    Rearm,
}

fn any_step() -> impl Strategy<Value = Step> {
    prop_oneof![
        8 => prop::sample::select(ORDINARY.as_slice()).prop_map(Step::Take),
        1 => Just(Step::Fault),
        1 => Just(Step::Rearm),
    ]
}

proptest! {
    #[test]
    fn no_path_leads_from_a_fault_to_torque_without_re_arming(steps in prop::collection::vec(any_step(), 0..60)) {
        let mut supervisor = Supervisor::default();
        let (mut latched, mut enabled_since_disarmed) = (None, false);
        for (number, step) in steps.into_iter().enumerate() {
            match step {
                Step::Take(event) => {
                    let before = supervisor.state();
                    supervisor.take(event);
                    enabled_since_disarmed |= before == State::Armed && event == Ordinary::Enabled;
                }
                Step::Fault => {
                    supervisor.fault(number);
                    latched = latched.or(Some(number));
                }
                Step::Rearm => {
                    supervisor.rearm();
                    latched = None;
                }
            }
            enabled_since_disarmed &= supervisor.state() != State::Disarmed;
            prop_assert_eq!(supervisor.first_cause().copied(), latched);
            if latched.is_some() {
                prop_assert_eq!(supervisor.state(), State::Faulted);
                prop_assert_eq!(supervisor.torque(), TorquePermission::Withheld);
            }
            if supervisor.torque() != TorquePermission::Withheld {
                prop_assert!(enabled_since_disarmed);
            }
        }
    }
}
