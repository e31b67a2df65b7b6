//! The master boots, configures and runs simulated drives whose frames are changed on the way, and ends without a panic or
//! in an endless wait.
//!
//! The input is a byte for each frame that the drives send, zero for one that passes. The others come with what they need.
#![no_main]

use dem_model::ThreeLinkDem;
use libfuzzer_sys::fuzz_target;
use std::time::Duration;
use uarm_io::drive::network::{DriveConfiguration, DriveNetwork, NetworkConfiguration};
use uarm_io::encoder::Direction;
use uarm_io::frame::Frame;
use uarm_io::link::{Link, Received};
use uarm_io::time::{Clock, Instant};
use uarm_io::torque::RatedTorque;
use uarm_sim::{
    DemPlant, DriveDescription, DriveParameters, EmulatedRobot, EncoderDescription, InProcessError, InProcessLink,
    Pacing, VirtualClock,
};

const PERIOD: Duration = Duration::from_millis(3);
const RATED_TORQUE: u32 = 200;
const COUNTS_PER_REVOLUTION: u32 = 33_739;
/// Cycles after the start.
const CYCLES: u32 = 8;

/// A link that changes what comes over it.
struct Changed<'a> {
    link: InProcessLink<EmulatedRobot<DemPlant>, VirtualClock>,
    changes: &'a [u8],
}

impl Changed<'_> {
    fn next(&mut self) -> Option<u8> {
        let (first, rest) = self.changes.split_first()?;
        self.changes = rest;
        Some(*first)
    }

    /// The frame as it arrives; `None` if it does not.
    fn change(&mut self, frame: Frame) -> Option<Frame> {
        let mut data = [0; 8];
        let length = frame.data().len();
        data[..length].copy_from_slice(frame.data());
        match self.next().unwrap_or(0) % 8 {
            1 => return None,
            2 => return Frame::new(frame.id(), &data[..length.min(self.next()?.into())]),
            3 => data.fill_with(|| self.next().unwrap_or(0)),
            4 => data[usize::from(self.next()?) % 8] ^= self.next()?,
            _ => return Some(frame),
        }
        Frame::new(frame.id(), &data[..length])
    }
}

impl Link for Changed<'_> {
    type Error = InProcessError;

    fn send(&mut self, frame: &Frame) -> Result<Instant, Self::Error> {
        self.link.send(frame)
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, Self::Error> {
        loop {
            let Some(received) = self.link.receive(deadline)? else { return Ok(None) };
            if let Some(frame) = self.change(received.frame) {
                return Ok(Some(Received { frame, ..received }));
            }
        }
    }
}

fn drive(node: u8) -> DriveParameters {
    DriveParameters::new(DriveDescription {
        node,
        rated_torque: RATED_TORQUE,
        rated_current: 1_500,
        maximum_torque: 1_000,
        direction: Direction::Positive,
        encoder: EncoderDescription { counts_per_revolution: COUNTS_PER_REVOLUTION, counter_bits: 32, zero_offset: 0 },
    })
    .expect("a drive")
}

fn network(changes: &[u8], clock: VirtualClock) -> DriveNetwork<Changed<'_>, 3> {
    let drives = [1, 2, 3].map(drive);
    let rated_torque = RatedTorque::from_millinewton_metres(RATED_TORQUE).expect("a torque");
    let configurations = drives.map(|drive| DriveConfiguration::new(drive.node(), COUNTS_PER_REVOLUTION, rated_torque));
    let plant = DemPlant::new(ThreeLinkDem::table_2());
    let robot = EmulatedRobot::new(plant, drives, Pacing::Lockstep { period: PERIOD }).expect("a robot");
    let link = Changed { link: InProcessLink::new(robot, clock), changes };
    DriveNetwork::new(link, NetworkConfiguration::new(configurations, PERIOD).expect("a network"))
}

fuzz_target!(|changes: &[u8]| {
    let mut clock = VirtualClock::new();
    let mut network = network(changes, clock.clone());
    if network.start(&clock).is_ok() {
        let start = clock.now();
        for cycle in 0..CYCLES {
            let tick = start + PERIOD * cycle;
            clock.sleep_until(tick);
            let run = network.sync().and_then(|_| network.collect(tick + PERIOD / 3));
            if run.and_then(|_| network.send_torques([0, 60, 30])).is_err() || network.housekeeping(tick).is_err() {
                break;
            }
        }
    }
    let _ = network.stop(&clock);
});
