//! Faults by schedule and on command.

use std::str::FromStr;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use uarm_io::drive::NodeId;
use uarm_sim::DriveFault;

use crate::console;
use crate::options::duration;
use crate::options::node_id;

/// What is done to a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// A fault is brought about, and lasts.
    Break(DriveFault),
    /// All its faults are taken away.
    Repair,
}

/// What is done to which drive, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order {
    /// The drive.
    pub node: NodeId,
    /// Plant time; at once without it.
    pub at: Option<Duration>,
    /// What is done.
    pub action: Action,
}

/// Where orders come from, as `--fault` says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OrderSource {
    /// The command line.
    Planned(Order),
    /// Lines of standard input.
    StandardInput,
}

impl FromStr for OrderSource {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "-" { Ok(Self::StandardInput) } else { text.parse().map(Self::Planned) }
    }
}

/// What an order may say behind the colon.
pub const ACTIONS: &str = "power-lost, bus-disconnected, encoder-jump=COUNTS, encoder-stuck, over-temperature, \
    encoder-reversed, encoder-drift=COUNTS, encoder-glitch=COUNTS, torque-reversed, feedback-lost=SYNCS, \
    feedback-late=TIME, feedback-replayed, target-ignored, supply-voltage=MILLIVOLTS, temperature=TENTHS, sdo-silent, brake-stuck-engaged, brake-stuck-released, motor-disconnected or repair";

impl FromStr for Order {
    type Err = String;

    /// `2@1.5s:over-temperature`, `2:repair`.
    fn from_str(text: &str) -> Result<Self, String> {
        let form = || format!("{text:?}: expected NODE@TIME:FAULT or NODE:FAULT, such as 2@1.5s:over-temperature");
        let (place, action) = text.trim().split_once(':').ok_or_else(form)?;
        let (node, at) = match place.split_once('@') {
            Some((node, time)) => (node, Some(duration(time)?)),
            None => (place, None),
        };
        Ok(Self { node: node_id(node)?, at, action: action_of(action)? })
    }
}

fn action_of(text: &str) -> Result<Action, String> {
    let fault = match text {
        "repair" => return Ok(Action::Repair),
        "power-lost" => DriveFault::PowerLost,
        "bus-disconnected" => DriveFault::BusDisconnected,
        "encoder-stuck" => DriveFault::EncoderStuck,
        "encoder-reversed" => DriveFault::EncoderReversed,
        "torque-reversed" => DriveFault::TorqueReversed,
        "feedback-replayed" => DriveFault::FeedbackReplayed,
        "target-ignored" => DriveFault::TargetIgnored,
        "over-temperature" => DriveFault::OverTemperature,
        "sdo-silent" => DriveFault::SdoSilent,
        "brake-stuck-engaged" => DriveFault::BrakeStuckEngaged,
        "brake-stuck-released" => DriveFault::BrakeStuckReleased,
        "motor-disconnected" => DriveFault::MotorDisconnected,
        _ => sized_fault(text).ok_or(format!("{text:?}: expected {ACTIONS}"))?,
    };
    Ok(Action::Break(fault))
}

/// A fault with a size, as in `encoder-jump=-500`.
fn sized_fault(text: &str) -> Option<DriveFault> {
    let (name, size) = text.split_once('=')?;
    Some(match name {
        "encoder-jump" => DriveFault::EncoderJump { counts: size.parse().ok()? },
        "encoder-drift" => DriveFault::EncoderDrift { counts: size.parse().ok()? },
        "encoder-glitch" => DriveFault::EncoderGlitch { counts: size.parse().ok()? },
        "supply-voltage" => DriveFault::SupplyVoltage { millivolts: size.parse().ok()? },
        "temperature" => DriveFault::Temperature { tenths: size.parse().ok()? },
        "feedback-lost" => DriveFault::FeedbackLost { syncs: size.parse().ok()? },
        "feedback-late" => DriveFault::FeedbackLate { by: duration(size).ok()? },
        _ => return None,
    })
}

/// The orders to come: those of a schedule, in every run of the plant anew, and those that are told meanwhile.
#[derive(Debug, Default)]
pub struct Schedule {
    planned: Vec<(Order, Done)>,
    told: Option<Receiver<Order>>,
    last: Option<Duration>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Done {
    No,
    Yes,
}

impl Schedule {
    /// The orders from these sources.
    pub fn of(sources: &[OrderSource]) -> Self {
        let planned = sources.iter().filter_map(|source| match source {
            OrderSource::Planned(order) => Some(*order),
            OrderSource::StandardInput => None,
        });
        let schedule = Self::new(planned);
        if sources.contains(&OrderSource::StandardInput) { schedule.with_standard_input() } else { schedule }
    }

    /// A schedule.
    fn new(planned: impl IntoIterator<Item = Order>) -> Self {
        Self { planned: planned.into_iter().map(|order| (order, Done::No)).collect(), told: None, last: None }
    }

    /// The same, and what lines on standard input order. A line that is no order is said so.
    fn with_standard_input(self) -> Self {
        let (sender, told) = channel();
        std::thread::spawn(move || {
            for line in std::io::stdin().lines().map_while(Result::ok).filter(|line| !line.trim().is_empty()) {
                match line.parse() {
                    // The plant has ended: so does this thread.
                    Ok(order) if sender.send(order).is_err() => return,
                    Ok(_) => {}
                    Err(error) => console::tell(error),
                }
            }
        });
        Self { told: Some(told), ..self }
    }

    /// What is due at plant time `time`, which is `None` while the plant stands.
    pub fn due(&mut self, time: Option<Duration>) -> Vec<Order> {
        while let Some(order) = self.told.as_ref().and_then(|told| told.try_recv().ok()) {
            self.planned.push((order, Done::No));
        }
        let is_new_run = self.last.is_some() && time < self.last;
        self.last = time;
        let mut due = Vec::new();
        for (order, done) in &mut self.planned {
            if is_new_run && order.at.is_some() {
                *done = Done::No;
            }
            if *done == Done::No && order.at.is_none_or(|at| time.is_some_and(|time| time >= at)) {
                *done = Done::Yes;
                due.push(*order);
            }
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(text: &str) -> Order {
        text.parse().unwrap()
    }

    #[test]
    fn every_fault_has_a_name() {
        let break_ = |text: &str| match order(&format!("3:{text}")).action {
            Action::Break(fault) => fault,
            Action::Repair => panic!("{text}"),
        };
        assert_eq!(break_("power-lost"), DriveFault::PowerLost);
        assert_eq!(break_("bus-disconnected"), DriveFault::BusDisconnected);
        assert_eq!(break_("encoder-jump=-500"), DriveFault::EncoderJump { counts: -500 });
        assert_eq!(break_("encoder-stuck"), DriveFault::EncoderStuck);
        assert_eq!(break_("encoder-reversed"), DriveFault::EncoderReversed);
        assert_eq!(break_("encoder-drift=20"), DriveFault::EncoderDrift { counts: 20 });
        assert_eq!(break_("encoder-glitch=48"), DriveFault::EncoderGlitch { counts: 48 });
        assert_eq!(break_("torque-reversed"), DriveFault::TorqueReversed);
        assert_eq!(break_("feedback-lost=3"), DriveFault::FeedbackLost { syncs: 3 });
        assert_eq!(break_("feedback-late=4ms"), DriveFault::FeedbackLate { by: Duration::from_millis(4) });
        assert_eq!(break_("feedback-replayed"), DriveFault::FeedbackReplayed);
        assert_eq!(break_("target-ignored"), DriveFault::TargetIgnored);
        assert_eq!(break_("over-temperature"), DriveFault::OverTemperature);
        assert_eq!(break_("brake-stuck-engaged"), DriveFault::BrakeStuckEngaged);
        assert_eq!(break_("brake-stuck-released"), DriveFault::BrakeStuckReleased);
        assert_eq!(break_("motor-disconnected"), DriveFault::MotorDisconnected);
        assert_eq!(order("3:repair").action, Action::Repair);
    }

    #[test]
    fn what_is_no_order_says_what_is() {
        for (text, expected) in [
            ("2", "NODE@TIME:FAULT"),
            ("0:repair", "1 to 126"),
            ("2@3:repair", "3ms"),
            ("2:fire", "over-temperature"),
            ("2:encoder-jump=far", "encoder-jump=COUNTS"),
        ] {
            let error = text.parse::<Order>().unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }

    #[test]
    fn orders_are_due_at_plant_time_in_every_run() {
        let (first, second) = (order("2:repair"), order("2@1.5s:encoder-stuck"));
        let mut schedule = Schedule::new([first, second]);
        let seconds = |time: f64| Some(Duration::from_secs_f64(time));
        assert_eq!(schedule.due(None), [first]);
        assert_eq!(schedule.due(seconds(1.497)), []);
        assert_eq!(schedule.due(seconds(1.5)), [second]);
        assert_eq!(schedule.due(seconds(1.503)), []);
        assert_eq!(schedule.due(None), []);
        assert_eq!(schedule.due(seconds(2.0)), [second], "another run, which was not looked at before");
    }
}
