//! What happens on the loop's thread: the link is opened, the thread becomes a real-time one, the run is made.

use anyhow::{Context, bail};
use hinf_control::Disturbance;
use uarm_io::drive::network::{Confirmation, DriveStop, LastDefence, StopReport};
use uarm_io::link::ObservedLink;
use uarm_io::probe::{CanWish, Machine};
use uarm_io::realtime::RealtimeThread;
use uarm_io::socketcan_link::{Reception, SocketCanLink};
use uarm_loop::control_loop::LoopEnd;
use uarm_loop::record::Recorder;
use uarm_loop::recording::FrameRecorder;
use uarm_loop::run::Observer;
use uarm_loop::settings::Settings;
use uarm_loop::torque::DisturbanceSite;
use uarm_sim::{InProcessLink, Pacing, VirtualClock};

use super::learned;
use super::place::Place;
use super::recording::{LogHandle, LoopSide};
use super::way::{AnyClock, AnyLink};
use crate::bought::Bought;
use crate::console;
use crate::dimensions::{LoopRobot, Outcome};
use crate::drives::{Failure, ToDrives, receive_identifiers, run_on};
use crate::realtime::Realtime;
use crate::robot::Robot;
use crate::simulated_plant::{PlantChoice, SimulatedPlant};
use crate::simulated_robot::{SimulatedRobot, simulated_with};

/// All that a run needs on its own thread.
pub struct LoopThread<'a, const J: usize, const N: usize> {
    /// The robot.
    pub robot: &'a Robot<J, N>,
    /// What the run does.
    pub settings: &'a Settings,
    /// Where it takes place.
    pub place: &'a Place,
    /// What is known of the simulated robot's drives.
    pub bought: &'a Bought<J>,
    /// How the thread is scheduled, but for virtual time.
    pub realtime: Option<Realtime>,
    /// What the run is recorded in.
    pub loop_side: Option<&'a mut LoopSide<J, N>>,
    /// What lines of text are added to.
    pub log: Option<LogHandle<J, N>>,
    /// How others look at the run, and end it.
    pub observer: Observer<'a, N>,
    /// What is about to move, told when nothing can be wrong any more with interface, options and files.
    pub announcement: &'a [String],
}

/// How a run ended, and what came of it until then.
#[derive(Debug)]
pub struct Finished<const N: usize> {
    /// The end, or the first cause of an early one.
    pub end: Result<LoopEnd, Failure>,
    /// What came of the run.
    pub outcome: Outcome<N>,
    /// How many faults came after the first, and what braking at the end met, in words.
    pub stop: String,
}

impl<const J: usize, const N: usize> LoopThread<'_, J, N> {
    /// Makes the run; call it on the loop's thread.
    ///
    /// # Errors
    /// If it cannot be begun.
    pub fn run(mut self) -> anyhow::Result<Finished<N>> {
        let mut clock = match self.place {
            Place::SimulatedVirtualTime(_) => AnyClock::Virtual(VirtualClock::default()),
            Place::SimulatedRealTime(_) | Place::Interface(_) => AnyClock::Monotonic,
        };
        let link = match self.place {
            Place::SimulatedVirtualTime(plant) | Place::SimulatedRealTime(plant) => {
                AnyLink::Simulated(self.simulated_link(self.plant(*plant)?, clock.clone())?)
            }
            Place::Interface(interface) => AnyLink::Can(can_link(&self.robot.description, interface)?),
        };
        let _thread = match (self.place, &link) {
            (Place::SimulatedVirtualTime(_), _) => None,
            (_, AnyLink::Simulated(_)) => self.real_time(None)?,
            (_, AnyLink::Can(link)) => {
                let bit_rate = Some(self.robot.description.bus.bit_rate.bits_per_second());
                let wish = CanWish { interface: Some(link.interface()), bit_rate };
                // Whatever is asked for of the machine.
                if let Some(finding) = Machine::this().wrong_bit_rate(&wish) {
                    bail!("{finding}");
                }
                self.real_time(Some(&wish))?
            }
        };
        match self.loop_side.take() {
            Some(LoopSide { cycles, frames }) => self.on(link, &mut clock, Some(cycles), Some(frames)),
            None => self.on(link, &mut clock, None, None),
        }
    }

    /// Makes this thread a real-time one, if the machine is ready.
    fn real_time(&self, can: Option<&CanWish>) -> anyhow::Result<Option<RealtimeThread>> {
        let Some(realtime) = self.realtime else { return Ok(None) };
        realtime.examine(&Machine::this(), can, self.log.as_ref())?;
        realtime.enter(self.log.as_ref()).map(Some)
    }

    /// Makes the run on `plant` in virtual time, wherever its place is, and gives each cycle to `recorder`.
    ///
    /// # Errors
    /// If it cannot be begun.
    pub fn on_plant(
        self,
        plant: SimulatedPlant<N>,
        recorder: Option<&mut dyn Recorder<J, N>>,
    ) -> anyhow::Result<Finished<N>> {
        let mut clock = AnyClock::Virtual(VirtualClock::default());
        let link = AnyLink::Simulated(self.simulated_link(plant, clock.clone())?);
        self.on(link, &mut clock, recorder, None)
    }

    /// The simulated plant with what disturbs it there.
    fn plant(&self, choice: PlantChoice) -> anyhow::Result<SimulatedPlant<N>> {
        let disturbance = match self.settings.disturbance_site {
            DisturbanceSite::Plant => self.settings.disturbance,
            DisturbanceSite::Command => Disturbance::None,
        };
        SimulatedPlant::new(self.robot, choice, disturbance)
    }

    /// A link to a simulated robot in this process. Its plant follows `clock`; in virtual time that is one period a cycle,
    /// to the nanosecond.
    fn simulated_link(
        &self,
        plant: SimulatedPlant<N>,
        clock: AnyClock,
    ) -> anyhow::Result<InProcessLink<SimulatedRobot<SimulatedPlant<N>, J>, AnyClock>> {
        Ok(InProcessLink::new(simulated_with(self.robot, plant, Pacing::WallClock, self.bought)?, clock))
    }

    fn on(
        self,
        link: AnyLink<J, N>,
        clock: &mut AnyClock,
        cycles: Option<&mut dyn Recorder<J, N>>,
        mut frames: Option<&mut FrameRecorder>,
    ) -> anyhow::Result<Finished<N>> {
        let Self { robot, settings, place, bought, observer, announcement, .. } = self;
        let link = ObservedLink::new(link, |direction, frame: &_, at| {
            if let Some(frames) = &mut frames {
                frames.record(direction, frame, at);
            }
        });
        let mut controller = robot.controller(settings.law, settings.guard)?;
        announcement.iter().for_each(console::tell);
        let way = to_drives(place, bought, link);
        let ended = run_on(&robot.description, settings, controller.as_mut(), way, clock, cycles, observer)?;
        let stop = match ended.later_faults {
            0 => describe(&ended.stop),
            later => format!("later faults: {later}; {}", describe(&ended.stop)),
        };
        Ok(Finished { end: ended.end, outcome: ended.outcome, stop })
    }
}

/// The way to the drives. What is learned of real ones is printed, and of those that stand for them.
fn to_drives<L, const J: usize>(place: &Place, bought: &Bought<J>, link: L) -> ToDrives<L> {
    match place {
        Place::SimulatedRealTime(_) | Place::SimulatedVirtualTime(_) if bought.is_none() => ToDrives::over(link),
        Place::Interface(_) | Place::SimulatedRealTime(_) | Place::SimulatedVirtualTime(_) => {
            ToDrives { link, learned: learned::print, identified: learned::print_identity }
        }
    }
}

/// A link to the drives of `robot` on `interface`. The kernel passes on only frames that they send, and those that only
/// their master may send, which are another's then.
fn can_link<const J: usize, const N: usize>(robot: &LoopRobot<J, N>, interface: &str) -> anyhow::Result<SocketCanLink> {
    let name = interface.parse().with_context(|| format!("--can {interface}"))?;
    let identifiers = receive_identifiers(robot)?;
    Ok(SocketCanLink::open(name, Reception::Exactly(&identifiers))?)
}

fn describe<const J: usize>(stop: &StopReport<J>) -> String {
    if stop.drives.iter().all(|drive| drive.power_off == Confirmation::Withheld) {
        return "nothing was sent to the drives".to_owned();
    }
    let doubtful: Vec<_> = stop.drives.iter().filter(|drive| drive.power_off != Confirmation::Confirmed).collect();
    if doubtful.is_empty() {
        return "all drives confirmed power off, brakes closed".to_owned();
    }
    let drives: Vec<_> = doubtful.iter().map(|drive| format!("node {} ({})", drive.node, defence(drive))).collect();
    format!("NOT CONFIRMED by {}: power off and brakes", drives.join(", "))
}

/// What brakes a drive that nobody reaches, as far as it was read back from it.
const fn defence(drive: &DriveStop) -> &'static str {
    match drive.last_defence {
        LastDefence::Heartbeat => "its own heartbeat watchdog brakes it",
        LastDefence::RpdoTimeout => "its own command timeout brakes it",
        LastDefence::None => "NOTHING is known that brakes it by itself",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_that_a_drive_did_not_confirm_is_told() {
        let drive = |node, power_off| DriveStop { node, power_off, ..DriveStop::default() };
        let told = |second, third| {
            let drives = [drive(1, Confirmation::Confirmed), drive(12, second), drive(3, third)];
            describe(&StopReport { drives })
        };
        let (confirmed, silent, unsent) = (Confirmation::Confirmed, Confirmation::Unconfirmed, Confirmation::NotSent);
        assert_eq!(told(confirmed, confirmed), "all drives confirmed power off, brakes closed");
        let nothing = "NOTHING is known that brakes it by itself";
        assert_eq!(told(silent, confirmed), format!("NOT CONFIRMED by node 12 ({nothing}): power off and brakes"));
        assert!(told(confirmed, unsent).starts_with("NOT CONFIRMED by node 3 ("));
        assert!(told(silent, unsent).starts_with(&format!("NOT CONFIRMED by node 12 ({nothing}), node 3 (")));
    }

    /// Only what was read back from a drive is said of it.
    #[test]
    fn a_drives_own_watchdog_is_told_of_a_drive_that_has_one() {
        let told = |last_defence| {
            let drive = DriveStop { node: 2, power_off: Confirmation::NotSent, last_defence, ..DriveStop::default() };
            describe(&StopReport { drives: [drive; 3] })
        };
        assert!(told(LastDefence::Heartbeat).contains("its own heartbeat watchdog brakes it"));
        assert!(told(LastDefence::RpdoTimeout).contains("its own command timeout brakes it"));
        assert!(!told(LastDefence::None).contains("brakes it,"));
        let withheld = DriveStop { power_off: Confirmation::Withheld, ..DriveStop::default() };
        assert_eq!(describe(&StopReport { drives: [withheld; 3] }), "nothing was sent to the drives");
    }
}
