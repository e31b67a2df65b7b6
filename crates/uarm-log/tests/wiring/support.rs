//! A run that is short enough to be worked out by hand.

use uarm_log::replay::bus_cycles::{BusCycle, Continuity};
use uarm_log::replay::source::{Behind, Source};
use uarm_log::uarm_loop::guard::JointLimits;
use uarm_log::uarm_loop::hinf_control::{
    AdaptationStatus, Command, Controller, Disturbance, FrozenState, Law, Measurement, QuinticReference, Reference,
    ThawError,
};
use uarm_log::uarm_loop::keyframe::Keyframe;
use uarm_log::uarm_loop::nalgebra::Vector2;
use uarm_log::uarm_loop::period::Period;
use uarm_log::uarm_loop::record::CycleRecord;
use uarm_log::uarm_loop::robot::{Bus, Joint, Protocol, Robot, Task};
use uarm_log::uarm_loop::run::signal_path;
use uarm_log::uarm_loop::schedule::Tick;
use uarm_log::uarm_loop::settings::Settings;
use uarm_log::uarm_loop::supervisor::Authority;
use uarm_log::uarm_loop::timing::CycleInstants;
use uarm_log::uarm_loop::uarm_io::bus_time::{BitRate, BusTime};
use uarm_log::uarm_loop::uarm_io::drive::NodeId;
use uarm_log::uarm_loop::uarm_io::drive::wishes::DriveConfiguration;
use uarm_log::uarm_loop::uarm_io::encoder::{
    CounterWidth, CountsPerRevolution, Direction, EncoderConfiguration, JumpLimit,
};
use uarm_log::uarm_loop::uarm_io::estimator::EstimatorConfiguration;
use uarm_log::uarm_loop::uarm_io::time::{Duration, Instant};
use uarm_log::uarm_loop::uarm_io::torque::{RatedTorque, TorqueCeiling, TorqueScale};

/// Asks for (0.05 + 0.001 k, −0.04) N·m in its cycle k.
#[derive(Clone, Debug, Default)]
pub struct RampLaw {
    cycles: f64,
}

impl Controller<f64, 2> for RampLaw {
    fn update(&mut self, _: &Measurement<f64>, _: &Reference<f64>, _: f64) -> Command<f64> {
        let torque = Vector2::new(0.05 + 0.001 * self.cycles, -0.04);
        self.cycles += 1.0;
        Command { torque, control_input: Vector2::zeros(), adaptation: AdaptationStatus::default() }
    }
    fn reset(&mut self) {
        self.cycles = 0.0;
    }
    fn freeze(&self) -> FrozenState<f64> {
        FrozenState::new(&[self.cycles]).unwrap()
    }
    fn thaw(&mut self, state: &FrozenState<f64>) -> Result<(), ThawError> {
        self.cycles = state.values()[0];
        Ok(())
    }
}

/// Asks joint 2 for 7 per mille of 200 mN·m, always.
#[derive(Default)]
pub struct FaintLaw;

impl Controller<f64, 2> for FaintLaw {
    fn update(&mut self, _: &Measurement<f64>, _: &Reference<f64>, _: f64) -> Command<f64> {
        let torque = Vector2::new(0.0014, 0.0);
        Command { torque, control_input: Vector2::zeros(), adaptation: AdaptationStatus::default() }
    }
    fn reset(&mut self) {}
    fn freeze(&self) -> FrozenState<f64> {
        FrozenState::new(&[]).unwrap()
    }
    fn thaw(&mut self, _: &FrozenState<f64>) -> Result<(), ThawError> {
        Ok(())
    }
}

/// Joints of 36000 counts per revolution within ±1 rad, drives of 200 mN·m, 3 ms, at rest at 0 for 3 s.
pub fn robot() -> Robot<3, 2> {
    let joint = |node: u8| Joint {
        name: format!("joint {node}"),
        node: NodeId::new(node).unwrap(),
        encoder: EncoderConfiguration {
            counts_per_revolution: CountsPerRevolution::new(36_000).unwrap(),
            counter_width: CounterWidth::FULL,
            direction: Direction::Positive,
            zero: 0,
            jump_limit: JumpLimit::new(1_000.0, 100_000).unwrap(),
        },
        estimator: EstimatorConfiguration::LowPass { cutoff: 30.0 }.build().unwrap(),
        torque_scale: TorqueScale {
            rated_torque: RatedTorque::from_millinewton_metres(200).unwrap(),
            direction: Direction::Positive,
            ceiling: TorqueCeiling::RATED,
            transmission: Default::default(),
        },
        drive: DriveConfiguration::new(
            NodeId::new(node).unwrap(),
            36_000,
            RatedTorque::from_millinewton_metres(200).unwrap(),
        ),
        torque_delay: Duration::ZERO,
        torque_limit: 0.2,
        torque_rate_limit: 1_000.0,
        limits: JointLimits { position: [-1.0, 1.0], velocity: 1_000.0 },
        brake: Default::default(),
    };
    let period = Period::new(Duration::from_millis(3)).unwrap();
    let milliseconds = Duration::from_millis;
    Robot {
        feedback_timeout: Duration::from_micros(2_250),
        acceleration_bounds: None,
        name: "test".to_owned(),
        joints: [joint(1), joint(2), joint(3)],
        task: Task {
            reference: QuinticReference::new(Vector2::zeros(), Vector2::zeros(), 3.0).unwrap().into(),
            hold: 0.0,
            start_tolerance: 1.0,
        },
        period,
        tracking_error_limit: 1.0,
        overruns_in_a_row: Default::default(),
        saturation_limit: Default::default(),
        rest_velocity: Default::default(),
        supervision: None,
        stop_ramp: Default::default(),
        bus: Bus {
            protocol: Protocol::Canopen,
            bit_rate: BitRate::FASTEST,
            time: BusTime::of_cycle(3, BitRate::FASTEST, period.duration()).unwrap(),
            controller_heartbeat: milliseconds(20),
            controller_timeout: milliseconds(100),
            drive_heartbeat: milliseconds(50),
            drive_timeout: milliseconds(200),
            listen: milliseconds(200),
            timeouts: Default::default(),
            sync_counter: Default::default(),
            emergency_reaction: Default::default(),
            ignored_target_reaction: Default::default(),
        },
    }
}

pub fn settings() -> Settings {
    Settings { disturbance: Disturbance::None, ..Settings::paper(Law::Nonlinear) }
}

/// A run and all that was recorded of it.
pub struct Run {
    pub robot: Robot<3, 2>,
    pub settings: Settings,
    pub bus: Vec<BusCycle<3>>,
    pub records: Vec<CycleRecord<3, 2>>,
    pub keyframes: Vec<(Option<u64>, Keyframe<3, 2>)>,
    pub fault: Option<&'static str>,
}

impl Run {
    pub fn source(&self) -> Source<'_, 3, 2> {
        let Self { robot, settings, bus, records, keyframes, fault } = self;
        Source { robot, settings, bus, records, keyframes, fault: *fault, behind: Behind::Nothing }
    }

    /// The same run of which only the bus was recorded.
    pub fn bus_only(self) -> Self {
        Self { records: Vec::new(), keyframes: Vec::new(), ..self }
    }
}

/// SYNC of a tick: a millisecond after the run began, and each 3 ms after that.
pub fn sync(tick: u64) -> Instant {
    Instant::from_nanoseconds(1_000_000 + 3_000_000 * tick)
}

/// A cycle on the bus in which the ramp law's torque was sent: 5 per mille of 200 mN·m are 0.001 N·m.
pub fn bus_cycle(tick: u64, counts: [i32; 3]) -> BusCycle<3> {
    let ramp = 250 + 5 * i16::try_from(tick).unwrap();
    BusCycle {
        stopped: false,
        commanded: true,
        sync_at: sync(tick),
        counter: None,
        counts: counts.map(Some),
        statuswords: [0x27; 3],
        sent: [Some(0), Some(ramp), Some(-200)],
        continuity: Continuity::Whole,
    }
}

/// A run of so many cycles, with keyframes before the first and after every fifth.
pub fn run(cycles: u64) -> Run {
    let (robot, settings, mut law) = (robot(), settings(), RampLaw::default());
    let mut path = signal_path(&robot, &settings, &mut law).unwrap();
    let (mut bus, mut records, mut keyframes) = (Vec::new(), Vec::new(), vec![(None, path.freeze())]);
    for index in 0..cycles {
        let due = sync(index);
        let tick = Tick { index, elapsed: u64::from(index > 0), scheduled: due, woke: due };
        let k = i32::try_from(index).unwrap();
        let counts = [-k, 3 * k, 2 * k];
        let signals = path.step(&tick, due, &counts.map(Some), robot.period, Authority::Full).unwrap();
        let instants = CycleInstants {
            scheduled: due,
            woke: due,
            sync_sent: due,
            counts_in: due,
            torque_out: due,
            done: due + Duration::from_millis(1),
        };
        records.push(CycleRecord::new(&tick, &instants, &[0x27; 3], &signals));
        bus.push(bus_cycle(index, counts));
        if index % 5 == 4 {
            keyframes.push((Some(index), path.freeze()));
        }
    }
    Run { robot, settings, bus, records, keyframes, fault: None }
}
