//! A signal path whose law says what it was told.

use uarm_loop::barrier::Stopping;
use uarm_loop::estimation::Estimation;
use uarm_loop::fade::{Fade, StopRamp};
use uarm_loop::guard::{Guard, JointLimits};
use uarm_loop::hinf_control::{
    AdaptationStatus, Command, Controller, Disturbance, FrozenState, LimitedJoints, Measurement, PerformanceIndices,
    QuinticReference, Reference, ThawError, TorqueLimiter, TorqueLimits,
};
use uarm_loop::motion::Motion;
use uarm_loop::nalgebra::Vector2;
use uarm_loop::period::Period;
use uarm_loop::saturation::{SaturationLimit, SaturationWatch};
use uarm_loop::schedule::Tick;
use uarm_loop::signal_path::SignalPath;
use uarm_loop::task_clock::{PeriodSource, TaskClock};
use uarm_loop::torque::{DisturbanceSite, TorqueStage};
use uarm_loop::uarm_io::encoder::{CounterWidth, CountsPerRevolution, Direction, EncoderConfiguration, JumpLimit};
use uarm_loop::uarm_io::estimator::EstimatorConfiguration;
use uarm_loop::uarm_io::time::{Duration, Instant};
use uarm_loop::uarm_io::torque::{RatedTorque, TorqueCeiling, TorqueScale};

/// What a law was told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Told {
    /// To make a torque, after so many seconds.
    Update(f64),
    /// Which torques were cut.
    Limited([bool; 2]),
    /// To hold Φ.
    Hold,
}

/// Asks for `torque` plus the sum over its cycles of `gain` times the position error.
#[derive(Clone, Debug)]
pub struct FakeLaw {
    pub torque: Vector2<f64>,
    pub gain: f64,
    pub sum: Vector2<f64>,
    pub told: Vec<Told>,
}

/// Φ of the fake law.
pub const PARAMETERS: [f64; 3] = [1.5, -2.5, 0.25];

impl FakeLaw {
    pub fn constant(joint_2: f64, joint_3: f64) -> Self {
        Self { torque: Vector2::new(joint_2, joint_3), gain: 0.0, sum: Vector2::zeros(), told: Vec::new() }
    }
}

impl Controller<f64, 2> for FakeLaw {
    fn update(&mut self, measurement: &Measurement<f64>, reference: &Reference<f64>, period: f64) -> Command<f64> {
        self.told.push(Told::Update(period));
        self.sum += (measurement.position - reference.position) * self.gain;
        Command {
            torque: self.torque + self.sum,
            control_input: Vector2::new(8.0, 9.0),
            adaptation: AdaptationStatus { projected: true, ..AdaptationStatus::default() },
        }
    }

    fn limited(&mut self, joints: LimitedJoints) {
        self.told.push(Told::Limited(joints));
    }

    fn hold_adaptation(&mut self) {
        self.told.push(Told::Hold);
    }

    fn parameters(&self) -> &[f64] {
        &PARAMETERS
    }

    fn reset(&mut self) {
        self.sum = Vector2::zeros();
    }

    fn freeze(&self) -> FrozenState<f64> {
        FrozenState::new(&[self.sum.x, self.sum.y]).unwrap()
    }

    fn thaw(&mut self, state: &FrozenState<f64>) -> Result<(), ThawError> {
        self.sum = Vector2::new(state.values()[0], state.values()[1]);
        Ok(())
    }
}

/// 3 ms.
pub fn period() -> Period {
    Period::new(Duration::from_millis(3)).unwrap()
}

/// A tick of that period.
pub fn tick(index: u64, elapsed: u64) -> Tick {
    let scheduled = Instant::from_nanoseconds(index * 3_000_000);
    Tick { index, elapsed, scheduled, woke: scheduled }
}

/// Rest at `position` for `duration` seconds, held for another `hold`.
pub fn rest(position: [f64; 2], duration: f64, hold: f64) -> Motion<2> {
    let position = Vector2::from(position);
    Motion::task(QuinticReference::new(position, position, duration).unwrap(), hold)
}

/// Encoders of 36000 counts per revolution (0.01 degrees each), limits that nothing passes, 200 mN·m at 1000 per mille.
pub fn path(controller: &mut dyn Controller<f64, 2>, motion: Motion<2>) -> SignalPath<'_, 3, 2> {
    let start = motion.start();
    let encoder = EncoderConfiguration {
        counts_per_revolution: CountsPerRevolution::new(36_000).unwrap(),
        counter_width: CounterWidth::FULL,
        direction: Direction::Positive,
        zero: 0,
        jump_limit: JumpLimit::new(10.0, 100).unwrap(),
    };
    let estimator = EstimatorConfiguration::Tracking { bandwidth: 50.0 }.build().unwrap();
    let limits = TorqueLimits::new(Vector2::new(0.1, 0.2)).unwrap();
    SignalPath {
        estimation: Estimation::new([(encoder, estimator); 3]),
        motion,
        controller,
        torque: TorqueStage {
            limiter: TorqueLimiter::new(limits.with_rate(Vector2::new(1_000.0, 1_000.0)).unwrap()),
            output_limiter: TorqueLimiter::new(limits.with_rate(Vector2::new(1_000.0, 1_000.0)).unwrap()),
            fade: Fade::new(StopRamp::default()),
            scales: [scale(200); 3],
            disturbance: Disturbance::None,
            site: DisturbanceSite::Plant,
        },
        saturation: SaturationWatch::new(SaturationLimit::new(SaturationLimit::LONGEST).unwrap()),
        supervision: None,
        guard: Guard {
            joints: [JointLimits { position: [-100.0, 100.0], velocity: 100.0 }; 3],
            stopping: [Stopping::default(); 3],
            tracking_error: 100.0,
            start_tolerance: 100.0,
        },
        task_clock: TaskClock::new(PeriodSource::Scheduled, start),
        indices: PerformanceIndices::new(),
    }
}

/// A drive of so many mN·m.
pub fn scale(millinewton_metres: u32) -> TorqueScale {
    TorqueScale {
        rated_torque: RatedTorque::from_millinewton_metres(millinewton_metres).unwrap(),
        direction: Direction::Positive,
        ceiling: TorqueCeiling::RATED,
        transmission: Default::default(),
    }
}
