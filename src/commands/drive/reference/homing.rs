//! References from a drive's own homing. The motor moves.

use std::io::IsTerminal;

use anyhow::Context;
use uarm_io::drive::network::NetworkConfiguration;
use uarm_io::drive::wishes::Operation;
use uarm_io::drive::{DriveNetwork, NodeId};
use uarm_io::link::Link;
use uarm_io::monotonic::MonotonicClock;
use uarm_io::realtime::RealtimePolicy;
use uarm_io::socketcan_link::{Reception, SocketCanLink};
use uarm_io::time::Clock;
use uarm_loop::robot::Protocol;
use uarm_loop::stop_request::StopRequest;

use super::arguments::Arguments;
use super::joint_reference::{Fix, joint_reference};
use super::procedure::{self, Motor, Watch};
use crate::commands::drive::confirmation::{Confirmation, confirm};
use crate::commands::drive::enabled::{Brakes, enabled};
use crate::reference::drive::{mark, show};
use crate::reference::store::References;
use crate::robot::homing::Homing;
use crate::robot::on_bus::JointsOnBus;
use crate::{console, signals};

/// One joint, and how its drive homes.
pub struct Plan {
    /// The joint, from 0.
    joint: usize,
    homing: Homing,
    watch: Watch,
}

/// Lets the drive of `node` home, and returns its reference with those of other joints that there are already.
///
/// # Errors
/// If the robot file does not say how, it is not confirmed, the drive cannot, or it does not find home.
pub fn home(arguments: &Arguments, robot: &JointsOnBus, node: NodeId) -> anyhow::Result<References> {
    let plan = Plan::new(robot, node)?;
    let realtime = arguments.realtime.settings(RealtimePolicy::Enforce)?;
    let earlier = References::read_beside(&arguments.robot)?;
    console::tell(format_args!("{}; THE MOTOR WILL MOVE", plan.text(robot, arguments)));
    let statement = format!("the arm is supported and node {} may move", node.raw());
    let terminal = std::io::stdin().is_terminal();
    match confirm(&statement, &node.raw().to_string(), arguments.yes, terminal, &mut std::io::stdin().lock())? {
        Confirmation::Given => {}
        Confirmation::Refused => anyhow::bail!("not confirmed: nothing was sent"),
    }
    let stop = signals::stop_request().context("signal handlers")?;
    let configuration = plan.network_configuration(robot)?;
    let identifiers: Vec<_> = configuration.receive_identifiers().collect();
    let link = SocketCanLink::open(arguments.can, Reception::Exactly(&identifiers))?;
    let mut network = DriveNetwork::new(link, configuration);
    let _thread = realtime.enter_unrecorded()?;
    plan.reference(robot, earlier, &mut network, &mut MonotonicClock, &stop)
}

impl Plan {
    /// # Errors
    /// If no joint has this node, or its `encoder.homing` is missing.
    pub fn new(robot: &JointsOnBus, node: NodeId) -> anyhow::Result<Self> {
        anyhow::ensure!(robot.bus.protocol == Protocol::Canopen, "--homing needs drives that speak CANopen");
        let joint = robot.joint_of(node)?;
        let description = &robot.joints[joint];
        let homing = robot.homing(joint)?.with_context(|| {
            format!(
                "joints[{joint}].encoder.homing ({}, node {}) is absent, expected {{ method, speeds, angle_deg, travel_deg }}",
                description.name,
                node.raw()
            )
        })?;
        let resolution = description.encoder.counts_per_revolution.resolution();
        let watch = Watch {
            node: node.raw(),
            period: robot.period,
            travel: homing.travel / resolution,
            speed: description.limits.velocity / resolution,
            timeout: homing.timeout,
            motor: Motor::of(homing.wish.method),
        };
        Ok(Self { joint, homing, watch })
    }

    /// What will happen, and within which limits.
    fn text(&self, robot: &JointsOnBus, arguments: &Arguments) -> String {
        let wish = &self.homing.wish;
        let (name, limits) = (&robot.joints[self.joint].name, &robot.written[self.joint].limits);
        let acceleration = wish.acceleration.map_or_else(|| "as it is".to_owned(), |found| found.to_string());
        format!(
            "{name}, node {} on {}: homing method {}, 6099h = {}, {}, 609Ah {acceleration}, 607Ch = {}; it ends after {} deg, above \
             {} deg/s or after {:?}; home is {} deg",
            self.watch.node,
            arguments.can,
            wish.method,
            wish.switch_speed,
            wish.zero_speed,
            wish.offset,
            self.homing.travel.to_degrees(),
            limits.velocity_deg_per_s,
            self.homing.timeout,
            self.homing.angle.to_degrees()
        )
    }

    /// The master's configuration for this drive alone, in homing mode.
    fn network_configuration(&self, robot: &JointsOnBus) -> anyhow::Result<NetworkConfiguration<1>> {
        let mut joint = robot.joints[self.joint].clone();
        joint.drive.operation = Operation::Homing(self.homing.wish);
        Ok(robot.network_configuration_of(&joint)?)
    }

    /// Lets the drive home, brakes, and reads where the joint then stands.
    ///
    /// # Errors
    /// See [`home`].
    pub fn reference<L: Link, C: Clock>(
        &self,
        robot: &JointsOnBus,
        earlier: Option<References>,
        network: &mut DriveNetwork<L, 1>,
        clock: &mut C,
        stop: &StopRequest,
    ) -> anyhow::Result<References>
    where
        L::Error: Send + Sync + 'static,
    {
        let ((), brakes) =
            enabled(network, clock, |drive| procedure::run(drive, &self.watch, stop).map_err(anyhow::Error::new))?;
        anyhow::ensure!(brakes == Brakes::Closed, "home was found, but: {brakes}; nothing was stored");
        let link = network.link_mut();
        let (file, description) = (&robot.written[self.joint], &robot.joints[self.joint]);
        let shown = show(link, clock, description.node, &file.encoder)?;
        let Homing { counts_at_home, angle, wish, .. } = self.homing;
        let fix = Fix {
            joint: self.joint,
            angle_deg: angle.to_degrees(),
            position_counts: counts_at_home,
            homing_method: Some(wish.method),
        };
        let reference = joint_reference(robot, &fix, &shown, earlier.as_ref())?;
        let from_home = f64::from(shown.position.wrapping_sub(counts_at_home));
        let resolution = description.encoder.counts_per_revolution.resolution();
        let now = (angle + description.encoder.direction.apply(from_home) * resolution).to_degrees();
        let (least, most) = (file.limits.minimum_deg, file.limits.maximum_deg);
        anyhow::ensure!(
            (least..=most).contains(&now),
            "{}: {} counts would be {now:.1} deg, expected {least} to {most} deg: is encoder.homing.angle_deg that of the home \
             position? nothing was stored",
            description.name,
            shown.position
        );
        console::tell(format_args!(
            "{}: home at {} deg, now at {now:.2} deg; {brakes}",
            description.name, fix.angle_deg
        ));
        mark(link, clock, description.node, &file.encoder)?;
        Ok(earlier.unwrap_or_else(|| References::new(Vec::new())).with(reference))
    }
}

#[cfg(test)]
mod tests;
