//! A whole run of the loop: emulated drives on the ideal plant, in virtual time, with a law of `hinf-control`.

use hinf_control::{BuildContext, ControllerSettings, Law, QuinticReference};
use uarm_io::bus_time::{BitRate, BusTime};
use uarm_io::drive::wishes::DriveConfiguration;
use uarm_io::drive::{DriveNetwork, NodeId};
use uarm_io::encoder::{CounterWidth, CountsPerRevolution, Direction, EncoderConfiguration, JumpLimit};
use uarm_io::estimator::EstimatorConfiguration;
use uarm_io::time::Duration;
use uarm_io::torque::{RatedTorque, TorqueCeiling, TorqueScale};
use uarm_loop::guard::JointLimits;
use uarm_loop::period::Period;
use uarm_loop::progress::Progress;
use uarm_loop::record::NoRecorder;
use uarm_loop::robot::{Bus, Joint, Protocol, Robot, Task};
use uarm_loop::run::{Observer, run};
use uarm_loop::settings::Settings;
use uarm_loop::stop_request::StopRequest;
use uarm_sim::dem_model::ThreeLinkDem;
use uarm_sim::{
    DemPlant, DriveDescription, DriveParameters, EmulatedRobot, EncoderDescription, InProcessLink, InitialState,
    Pacing, VirtualClock,
};

type Failure = Box<dyn std::error::Error>;

/// Joints with drives, and how many of them are active.
const JOINTS: usize = 3;
const ACTIVE: usize = 2;

const PERIOD: Duration = Duration::from_millis(3);
const COUNTS_PER_REVOLUTION: u32 = 33_739;
const COUNTER_BITS: u8 = 32;
/// mN·m.
const RATED_TORQUE: u32 = 200;
/// rad/s.
const FASTEST: f64 = 6.0;

fn joint(name: &str, node: u8, torque_limit: f64) -> Result<Joint, Failure> {
    let node = NodeId::new(node).map_err(|_| "a node id, 1 to 127")?;
    let rated_torque = RatedTorque::from_millinewton_metres(RATED_TORQUE)?;
    Ok(Joint {
        name: name.to_owned(),
        node,
        encoder: EncoderConfiguration {
            counts_per_revolution: CountsPerRevolution::new(COUNTS_PER_REVOLUTION)?,
            counter_width: CounterWidth::new(COUNTER_BITS)?,
            direction: Direction::Positive,
            zero: 0,
            jump_limit: JumpLimit::new(FASTEST, 100)?,
        },
        estimator: EstimatorConfiguration::LowPass { cutoff: 27.8 }.build()?,
        torque_scale: TorqueScale {
            rated_torque,
            direction: Direction::Positive,
            ceiling: TorqueCeiling::RATED,
            transmission: Default::default(),
        },
        drive: DriveConfiguration::new(node, COUNTS_PER_REVOLUTION, rated_torque),
        torque_delay: Duration::ZERO,
        torque_limit,
        torque_rate_limit: 100.0,
        limits: JointLimits { position: [-60.0, 60.0], velocity: FASTEST },
        brake: Default::default(),
    })
}

fn robot() -> Result<Robot<JOINTS, ACTIVE>, Failure> {
    let bit_rate = BitRate::new(1_000_000)?;
    Ok(Robot {
        feedback_timeout: Duration::from_micros(2_250),
        acceleration_bounds: None,
        name: "three joints".to_owned(),
        joints: [joint("base", 1, 0.0)?, joint("joint 2", 2, 0.2)?, joint("joint 3", 3, 0.2)?],
        task: Task { reference: QuinticReference::paper().into(), hold: 0.5, start_tolerance: 0.03 },
        period: Period::new(PERIOD).ok_or("a period of 0.1 to 100 ms")?,
        tracking_error_limit: 0.5,
        overruns_in_a_row: Default::default(),
        saturation_limit: Default::default(),
        rest_velocity: Default::default(),
        supervision: None,
        stop_ramp: Default::default(),
        bus: Bus {
            protocol: Protocol::Canopen,
            bit_rate,
            time: BusTime::of_cycle(JOINTS, bit_rate, PERIOD)?,
            controller_heartbeat: Duration::from_millis(10),
            controller_timeout: Duration::from_millis(50),
            drive_heartbeat: Duration::from_millis(50),
            drive_timeout: Duration::from_millis(200),
            listen: Duration::from_millis(200),
            timeouts: Default::default(),
            sync_counter: Default::default(),
            emergency_reaction: Default::default(),
            ignored_target_reaction: Default::default(),
        },
    })
}

/// The other end of the bus. On a robot this is a `uarm_io::socketcan_link::SocketCanLink`.
fn link(
    robot: &Robot<JOINTS, ACTIVE>,
    clock: VirtualClock,
) -> Result<InProcessLink<EmulatedRobot<DemPlant>, VirtualClock>, Failure> {
    let drive = |joint: &Joint| {
        DriveParameters::new(DriveDescription {
            node: joint.node.raw(),
            rated_torque: RATED_TORQUE,
            rated_current: 1_000,
            maximum_torque: 1_000,
            direction: Direction::Positive,
            encoder: EncoderDescription {
                counts_per_revolution: COUNTS_PER_REVOLUTION,
                counter_bits: COUNTER_BITS,
                zero_offset: 0,
            },
        })
    };
    let [first, second, third] = &robot.joints;
    let start = robot.task.reference.start();
    let plant = DemPlant::new(ThreeLinkDem::table_2())
        .with_initial_state(InitialState { position: [0.0, start.x, start.y].into(), velocity: Default::default() });
    let drives = [drive(first)?, drive(second)?, drive(third)?];
    Ok(InProcessLink::new(EmulatedRobot::new(plant, drives, Pacing::Lockstep { period: PERIOD })?, clock))
}

fn main() -> Result<(), Failure> {
    let robot = robot()?;
    let context = BuildContext::new(ThreeLinkDem::<f64>::table_2());
    let mut controller = ControllerSettings::default().build(Law::Adaptive, &context)?;
    let mut clock = VirtualClock::new();
    let drives = DriveNetwork::new(link(&robot, clock.clone())?, robot.network_configuration()?);
    let settings = Settings::paper(Law::Adaptive);

    let (progress, stop) = (Progress::default(), StopRequest::default());
    let observer = Observer { progress: &progress, stop: &stop };
    // Starts the drives, runs the loop, and brakes whatever happened.
    let finished = run(&robot, &settings, &mut controller, drives, &mut clock, NoRecorder, observer)?;

    let outcome = &finished.outcome;
    println!("{:?} after {} cycles", finished.end?, outcome.timing.cycles);
    println!("L2 {:.4}, E {:.4} N m s", outcome.indices.l2, outcome.indices.e);
    assert!(finished.stop.all_off(), "every drive confirms that its brake is closed");
    Ok(())
}
