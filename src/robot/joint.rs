//! Encoders, drives and limits of the joints: checked.

use uarm_io::drive::{Address, NodeId, Value};
use uarm_io::encoder::{CounterWidth, CountsPerRevolution, EncoderConfiguration, JumpLimit};
use uarm_io::torque::{RatedTorque, TorqueCeiling, TorqueScale};
use uarm_loop::guard::JointLimits;
use uarm_loop::robot::Joint;

use super::error::{Checker, RobotError};
use super::file::{self, RobotFile, Role};
use crate::dimensions::JOINTS;

/// The highest node id of a drive: 127 is the controller's.
const LAST_DRIVE_NODE: u8 = 126;

pub(super) fn check(file: &RobotFile, check: &Checker<'_>) -> Result<[Joint; JOINTS], RobotError> {
    let joints: &[file::Joint; JOINTS] = file.joints.as_slice().try_into().map_err(|_| {
        check.refuse("joints", format!("{} joints", file.joints.len()), "three joints: the passive base and two active")
    })?;
    for (index, joint) in joints.iter().enumerate() {
        let wanted = if index == 0 { Role::Passive } else { Role::Active };
        if joint.role != wanted {
            let expected = "\"passive\" for joints[0], the base, and \"active\" for the others";
            return Err(check.refuse(format!("joints[{index}].role"), format!("{:?}", joint.role), expected));
        }
        if joints.iter().take(index).any(|earlier| earlier.node == joint.node) {
            return Err(check.refuse(format!("joints[{index}].node"), joint.node, "a node id that no other joint has"));
        }
    }
    let [first, second, third] = joints;
    Ok([one(0, first, file, check)?, one(1, second, file, check)?, one(2, third, file, check)?])
}

fn one(index: usize, joint: &file::Joint, file: &RobotFile, check: &Checker<'_>) -> Result<Joint, RobotError> {
    let period = f64::from(file.control.period_us) * 1e-6;
    let field = |name: &str| format!("joints[{index}].{name}");
    if !(1..=LAST_DRIVE_NODE).contains(&joint.node) {
        return Err(check.refuse(field("node"), joint.node, format!("a node id, 1 to {LAST_DRIVE_NODE}")));
    }
    let node = NodeId::new(joint.node).map_err(|_| check.refuse(field("node"), joint.node, "a node id of CANopen"))?;
    let limits = &joint.limits;
    let minimum = check.within(&field("limits.minimum_deg"), limits.minimum_deg, -36_000.0, 36_000.0)?;
    let maximum = check.within(&field("limits.maximum_deg"), limits.maximum_deg, minimum, 36_000.0)?;
    let velocity =
        check.within(&field("limits.velocity_deg_per_s"), limits.velocity_deg_per_s, 1e-3, 36_000.0)?.to_radians();
    let encoder = encoder(index, &joint.encoder, velocity, period, check)?;
    let torque_limit = match joint.role {
        Role::Active => check.positive(&field("limits.torque_nm"), limits.torque_nm)?,
        Role::Passive if limits.torque_nm == 0.0 => 0.0,
        Role::Passive => {
            return Err(check.refuse(
                field("limits.torque_nm"),
                limits.torque_nm,
                "0: the passive joint has no torque",
            ));
        }
    };
    let rate_field = field("limits.torque_rate_nm_per_s");
    let torque_rate_limit = match joint.role {
        Role::Active => check.positive(&rate_field, limits.torque_rate_nm_per_s)?,
        Role::Passive => check.not_negative(&rate_field, limits.torque_rate_nm_per_s)?,
    };
    let rated = rated_torque(&field("drive.rated_torque_nm"), joint.drive.rated_torque_nm, check)?;
    let torque_scale =
        TorqueScale { rated_torque: rated, direction: encoder.direction, ceiling: ceiling(torque_limit, rated) };
    if torque_limit > f64::from(i16::MAX) * rated.per_mille() {
        return Err(check.refuse(
            field("limits.torque_nm"),
            limits.torque_nm,
            format!("at most {} times drive.rated_torque_nm: object 6071h holds no more", i16::MAX / 1000),
        ));
    }
    Ok(Joint {
        name: joint.name.clone(),
        node,
        estimator: super::control::estimator(file, encoder.counts_per_revolution, check)?,
        encoder,
        torque_scale,
        writes: writes(index, &joint.drive.writes, check)?,
        torque_limit,
        torque_rate_limit,
        limits: JointLimits { position: [minimum.to_radians(), maximum.to_radians()], velocity },
    })
}

fn encoder(
    index: usize,
    encoder: &file::Encoder,
    velocity: f64,
    period: f64,
    check: &Checker<'_>,
) -> Result<EncoderConfiguration, RobotError> {
    let field = |name: &str| format!("joints[{index}].encoder.{name}");
    let counts = encoder.counts_per_revolution;
    let counts_per_revolution = CountsPerRevolution::new(counts)
        .map_err(|error| check.refuse(field("counts_per_revolution"), counts, error.to_string()))?;
    let counter_width = CounterWidth::new(encoder.counter_bits)
        .map_err(|error| check.refuse(field("counter_bits"), encoder.counter_bits, error.to_string()))?;
    // A wake-up may come up to a period late without a deadline missed, so one period's motion at full velocity is the
    // margin.
    let margin = (velocity * period / counts_per_revolution.resolution()).ceil() as u32 + 1;
    let jump_limit = JumpLimit::new(velocity, margin).map_err(|error| {
        check.refuse(format!("joints[{index}].limits.velocity_deg_per_s"), velocity, error.to_string())
    })?;
    Ok(EncoderConfiguration {
        counts_per_revolution,
        counter_width,
        direction: encoder.direction,
        zero: encoder.zero_counts,
        jump_limit,
    })
}

/// Object 6076h holds whole mN·m.
fn rated_torque(field: &str, newton_metres: f64, check: &Checker<'_>) -> Result<RatedTorque, RobotError> {
    let expected = "a whole number of mN m above 0, as object 6076h holds it";
    let millinewton_metres = (newton_metres * 1e3).round();
    if !(1.0..=f64::from(u32::MAX)).contains(&millinewton_metres)
        || (newton_metres * 1e3 - millinewton_metres).abs() > 1e-6
    {
        return Err(check.refuse(field, newton_metres, expected));
    }
    RatedTorque::from_millinewton_metres(millinewton_metres as u32)
        .map_err(|_| check.refuse(field, newton_metres, expected))
}

/// What the drive is never sent more of: the joint's limit, rounded up to a whole per mille.
fn ceiling(torque_limit: f64, rated: RatedTorque) -> TorqueCeiling {
    let per_mille = (torque_limit / rated.per_mille()).ceil().clamp(1.0, f64::from(i16::MAX)) as i16;
    TorqueCeiling::new(per_mille).unwrap_or(TorqueCeiling::RATED)
}

fn writes(
    index: usize,
    writes: &[file::ObjectWrite],
    check: &Checker<'_>,
) -> Result<Vec<(Address, Value)>, RobotError> {
    writes
        .iter()
        .enumerate()
        .map(|(number, write)| {
            let value = match write.kind {
                file::ObjectType::U8 => u8::try_from(write.value).map(Value::Unsigned8),
                file::ObjectType::U16 => u16::try_from(write.value).map(Value::Unsigned16),
                file::ObjectType::U32 => u32::try_from(write.value).map(Value::Unsigned32),
                file::ObjectType::I8 => i8::try_from(write.value).map(Value::Integer8),
                file::ObjectType::I16 => i16::try_from(write.value).map(Value::Integer16),
                file::ObjectType::I32 => i32::try_from(write.value).map(Value::Integer32),
            }
            .map_err(|_| {
                let field = format!("joints[{index}].drive.writes[{number}].value");
                check.refuse(field, write.value, format!("a value that fits type {:?}", write.kind))
            })?;
            Ok((Address::new(write.index, write.subindex), value))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use uarm_io::encoder::JumpLimit;

    use crate::robot::overrides::Overrides;
    use crate::robot::{BUILT_IN, Robot};

    /// The limiter takes no rate of zero: such a file would be refused only when a run begins.
    #[test]
    fn an_active_joint_needs_a_torque_rate() {
        let text = BUILT_IN.replacen("torque_rate_nm_per_s = 100.0", "torque_rate_nm_per_s = 0.0", 1);
        let error = Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).unwrap_err().to_string();
        assert!(error.contains("joints[1].limits.torque_rate_nm_per_s"), "{error}");
    }

    /// In one period of 3 ms the base turns 2.16 degrees at 720 deg/s: 202.4 of 33739 counts, so 203, and one more. The other
    /// joints turn half as far: 101.2 counts, so 102, and one more.
    #[test]
    fn the_jump_margin_is_what_a_joint_turns_in_a_period_and_one_count() {
        let robot = Robot::load(None).unwrap();
        let limits = robot.description.joints.each_ref().map(|joint| joint.encoder.jump_limit);
        let expected = [(720.0_f64, 204), (360.0, 103), (360.0, 103)];
        assert_eq!(limits, expected.map(|(velocity, margin)| JumpLimit::new(velocity.to_radians(), margin).unwrap()));
    }
}
