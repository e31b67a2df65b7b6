//! References from a pose that somebody confirms; the drives get no command.

use std::io::IsTerminal;

use uarm_io::drive::cia402::PowerState;
use uarm_io::link::Link;
use uarm_io::monotonic::MonotonicClock;
use uarm_io::time::Clock;

use super::arguments::Arguments;
use super::joint_reference::{Fix, joint_reference, node};
use crate::commands::drive::confirmation::{Confirmation, confirm};
use crate::console;
use crate::reference::drive::{Shown, mark, show};
use crate::reference::store::References;
use crate::reference::{incremental_joints, link};
use crate::robot::on_bus::JointsOnBus;
use crate::usage::UsageError;

/// How far a joint may move between its reading and the confirmation, counts.
const STILL: u32 = 4;

/// The references of all incremental joints, in the pose that the command line tells.
///
/// # Errors
/// If the angles are none that the joints can have, a drive is on or does not answer, the pose is not confirmed or a joint
/// moved meanwhile.
pub fn confirmed(arguments: &Arguments, robot: &JointsOnBus) -> anyhow::Result<References> {
    let angles = &arguments.angles;
    check_angles(robot, angles)?;
    let joints = incremental_joints(&robot.written);
    anyhow::ensure!(
        !joints.is_empty(),
        "{}: no joint has encoder.reference = \"incremental\": there is nothing to reference",
        arguments.robot.display()
    );
    let mut link = link(&robot.bus, &robot.joints, arguments.can)?;
    let before = read(robot, &joints, &mut link, &MonotonicClock)?;
    for (joint, shown) in joints.iter().zip(&before) {
        let name = &robot.joints[*joint].name;
        console::tell(format_args!(
            "  {name} (node {}): {} counts are {} deg",
            node(robot, *joint).raw(),
            shown.position,
            angles[*joint]
        ));
    }
    let terminal = std::io::stdin().is_terminal();
    match confirm("the arm is in this pose", "yes", arguments.yes, terminal, &mut std::io::stdin().lock())? {
        Confirmation::Given => {}
        Confirmation::Refused => anyhow::bail!("not confirmed: nothing was stored"),
    }
    let earlier = References::read_beside(&arguments.robot)?;
    set(robot, &joints, angles, &before, earlier.as_ref(), &mut link, &MonotonicClock)
}

/// Checks that there are as many angles as joints, each within its limits.
fn check_angles(robot: &JointsOnBus, angles: &[f64]) -> Result<(), UsageError> {
    let (found, expected) = (angles.len(), robot.joints.len());
    if found != expected {
        let message = format!("--angles: {found} angles, expected {expected}, one for each joint of the robot file");
        return Err(UsageError::new(message));
    }
    for (angle, joint) in angles.iter().zip(&robot.written) {
        let (least, most) = (joint.limits.minimum_deg, joint.limits.maximum_deg);
        if !(least..=most).contains(angle) {
            return Err(UsageError::new(format!(
                "--angles: {angle} deg for {}, expected its limits, {least} to {most} deg",
                joint.name
            )));
        }
    }
    Ok(())
}

/// What the drives of `joints` show; each must be off.
fn read<L: Link, C: Clock>(robot: &JointsOnBus, joints: &[usize], link: &mut L, clock: &C) -> anyhow::Result<Vec<Shown>>
where
    L::Error: Send + Sync + 'static,
{
    let mut shown = Vec::new();
    for joint in joints {
        let node = node(robot, *joint);
        let found = show(link, clock, node, &robot.written[*joint].encoder)?;
        let is_on = matches!(
            found.statusword.state(),
            None | Some(PowerState::SwitchedOn | PowerState::OperationEnabled | PowerState::QuickStopActive)
        );
        anyhow::ensure!(!is_on, "node {} is in {}: expected it to be off", node.raw(), found.statusword);
        shown.push(found);
    }
    Ok(shown)
}

/// Marks the drives and makes their references, after a look whether anything moved since `before`.
fn set<L: Link, C: Clock>(
    robot: &JointsOnBus,
    joints: &[usize],
    angles: &[f64],
    before: &[Shown],
    earlier: Option<&References>,
    link: &mut L,
    clock: &C,
) -> anyhow::Result<References>
where
    L::Error: Send + Sync + 'static,
{
    let now = read(robot, joints, link, clock)?;
    let mut references = Vec::new();
    for ((joint, before), now) in joints.iter().zip(before).zip(&now) {
        let name = &robot.joints[*joint].name;
        let moved = now.position.wrapping_sub(before.position).unsigned_abs();
        anyhow::ensure!(moved <= STILL, "{name} moved by {moved} counts since it was shown: nothing was stored");
        let fix = Fix { joint: *joint, angle_deg: angles[*joint], position_counts: now.position, homing_method: None };
        references.push(joint_reference(robot, &fix, now, earlier)?);
    }
    // Only when all is right: a marker without its reference would hide a loss of power from an older reference.
    for joint in joints {
        mark(link, clock, node(robot, *joint), &robot.written[*joint].encoder)?;
    }
    Ok(References::new(references))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::emulated_bus::{Bus, bus_of};
    use crate::robot::overrides::Overrides;
    use crate::robot::{BUILT_IN, Robot};
    use uarm_io::drive::Value;
    use uarm_sim::drive::DriveFault;
    use uarm_sim::{Joint, VirtualClock};

    const ANGLES: [f64; 3] = [0.0, 20.0, 20.0];

    fn robot(encoder_2: &str) -> Robot {
        let plain = "node = 2\nencoder = { counts_per_revolution = 33739, counter_bits = 32, direction = \"positive\", zero_counts = 0";
        let text = BUILT_IN.replace(plain, &plain.replace("zero_counts = 0", encoder_2));
        Robot::parse(Path::new("robot.toml"), &text, &Overrides::default()).unwrap()
    }

    /// Joint 2's encoder is incremental; 6081h, the profile velocity, is 0 in the emulated drive.
    fn incremental(marker: u32) -> JointsOnBus {
        let marker = format!("power_marker = {{ index = 0x6081, subindex = 0, type = \"u32\", value = {marker} }}");
        JointsOnBus::of(&robot(&format!("zero_counts = 0, reference = \"incremental\", {marker}")))
    }

    /// Joint 2's counter happens to show 5000 at angle zero.
    fn bus() -> (Bus, VirtualClock) {
        bus_of(&robot("zero_counts = 5000"))
    }

    #[test]
    fn a_confirmed_pose_gives_the_counts_at_zero_and_leaves_a_marker() {
        let (robot, (mut link, clock)) = (incremental(77), bus());
        let before = read(&robot, &[1], &mut link, &clock).unwrap();
        let references = set(&robot, &[1], &ANGLES, &before, None, &mut link, &clock).unwrap();
        assert_eq!((references.joints.len(), references.joints[0].zero_counts), (1, 5_000));
        assert_eq!(references.joints[0].serial, Some(2));
        let encoder = &robot.written[1].encoder;
        let marker = |link: &mut _| show(link, &clock, node(&robot, 1), encoder).unwrap().marker;
        assert_eq!(marker(&mut link), Some(Value::Unsigned32(77)));
        // What the marker is for.
        link.inject(Joint::TWO, DriveFault::PowerLost);
        link.repair(Joint::TWO);
        assert_eq!(marker(&mut link), Some(Value::Unsigned32(0)));
    }

    #[test]
    fn a_joint_that_moved_after_it_was_shown_is_refused() {
        let (robot, (mut link, clock)) = (incremental(77), bus());
        let before = read(&robot, &[1], &mut link, &clock).unwrap();
        link.inject(Joint::TWO, DriveFault::EncoderJump { counts: 5 });
        let error = set(&robot, &[1], &ANGLES, &before, None, &mut link, &clock).unwrap_err().to_string();
        assert!(error.contains("joint 2 moved by 5 counts"), "{error}");
    }

    #[test]
    fn a_marker_that_the_drive_has_at_power_on_is_refused() {
        let (robot, (mut link, clock)) = (incremental(0), bus());
        let before = read(&robot, &[1], &mut link, &clock).unwrap();
        let error = set(&robot, &[1], &ANGLES, &before, None, &mut link, &clock).unwrap_err().to_string();
        assert!(error.contains("choose another value or object"), "{error}");
    }

    #[test]
    fn angles_are_one_for_each_joint_and_within_the_limits() {
        let robot = incremental(77);
        assert!(check_angles(&robot, &ANGLES).is_ok());
        assert!(check_angles(&robot, &[0.0, 20.0]).unwrap_err().to_string().contains("2 angles, expected 3"));
        assert!(check_angles(&robot, &[0.0, 171.0, 0.0]).unwrap_err().to_string().contains("-170 to 170 deg"));
        assert!(check_angles(&robot, &[0.0, f64::NAN, 0.0]).is_err());
    }
}
