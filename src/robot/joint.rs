//! Encoders, drives and limits of the joints: checked.

use uarm_io::drive::NodeId;
use uarm_io::encoder::{CounterWidth, CountsPerRevolution, Direction, EncoderConfiguration, JumpLimit};
use uarm_io::gear::{GearRatio, Transmission};
use uarm_io::time::Duration;
use uarm_io::torque::{RatedTorque, TorqueCeiling, TorqueScale, TorqueUnit};
use uarm_loop::dimensions;
use uarm_loop::guard::JointLimits;
use uarm_loop::robot::Joint;

use super::drive::{DriveCheck, check_identifiers};
use super::error::{Checker, RobotError};
use super::file::{self, ReferenceKind, RobotFile, Role};
use super::homing;

/// The highest node id of a drive: 127 is the controller's.
const LAST_DRIVE_NODE: u8 = 126;

pub(super) fn check<const J: usize, const N: usize>(
    file: &RobotFile<N>,
    check: &Checker<'_>,
) -> Result<[Joint; J], RobotError> {
    let joints = &file.joints;
    for (index, joint) in joints.iter().enumerate() {
        let wanted = if index < dimensions::passive::<J, N>() { Role::Passive } else { Role::Active };
        if joint.role != wanted {
            let expected = "\"passive\" for joints[0] if it is the base, and \"active\" for the others";
            return Err(check.refuse(format!("joints[{index}].role"), format!("{:?}", joint.role), expected));
        }
        if joints.iter().take(index).any(|earlier| earlier.node == joint.node) {
            return Err(check.refuse(format!("joints[{index}].node"), joint.node, "a node id that no other joint has"));
        }
    }
    let checked: Result<Vec<_>, _> =
        joints.iter().enumerate().map(|(index, joint)| one(index, joint, file, check)).collect();
    let checked: [Joint; J] = checked?.try_into().map_err(|checked: Vec<_>| {
        check.refuse("joints", format!("{} joints", checked.len()), format!("{J}, {N} of them active"))
    })?;
    check_identifiers(&checked.each_ref().map(|joint| &joint.drive), check)?;
    Ok(checked)
}

fn one<const N: usize>(
    index: usize,
    joint: &file::Joint,
    file: &RobotFile<N>,
    check: &Checker<'_>,
) -> Result<Joint, RobotError> {
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
    let transmission = transmission(index, joint, check)?;
    let encoder = encoder(index, joint, transmission.ratio(), velocity, period, check)?;
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
    let unit = joint.drive.rated_torque_unit.unwrap_or_default();
    let rated = rated_torque(&field("drive.rated_torque_nm"), joint.drive.rated_torque_nm, unit, check)?;
    let torque_scale = scale(rated, encoder.direction, transmission, torque_limit);
    if torque_limit > f64::from(i16::MAX) * torque_scale.per_mille() {
        return Err(check.refuse(
            field("limits.torque_nm"),
            limits.torque_nm,
            format!("at most {} times the rated torque at the joint: object 6071h holds no more", i16::MAX / 1000),
        ));
    }
    let drive = DriveCheck { index, joint, file, check }.configuration(node, rated, torque_scale.ceiling)?;
    Ok(Joint {
        name: joint.name.clone(),
        node,
        estimator: super::control::estimator(
            (&file.estimator, file.control.period_us),
            encoder.counts_per_revolution,
            check,
        )?,
        encoder,
        torque_scale,
        drive,
        torque_delay: torque_delay(&field("drive.torque_delay_us"), joint, &file.control, check)?,
        torque_limit,
        torque_rate_limit,
        limits: JointLimits { position: [minimum.to_radians(), maximum.to_radians()], velocity },
        brake: brake(&field("limits.brake_ms"), limits, check)?,
    })
}

/// The longest that a brake may take to close, ms: a joint that coasts longer needs another brake.
const SLOWEST_BRAKE_MS: u16 = 1000;

/// From the command to stop until the brake holds.
fn brake(field: &str, limits: &file::Limits, check: &Checker<'_>) -> Result<Duration, RobotError> {
    let milliseconds = limits.brake_ms.unwrap_or_default();
    if milliseconds > SLOWEST_BRAKE_MS {
        return Err(check.refuse(field, milliseconds, format!("at most {SLOWEST_BRAKE_MS}")));
    }
    Ok(Duration::from_millis(milliseconds.into()))
}

/// The gear between motor and joint.
fn transmission(index: usize, joint: &file::Joint, check: &Checker<'_>) -> Result<Transmission, RobotError> {
    let [motor, of_joint] = joint.gear_ratio.unwrap_or([1, 1]);
    let ratio = GearRatio::new(motor, of_joint).map_err(|error| {
        check.refuse_as(format!("joints[{index}].gear_ratio"), format!("[{motor}, {of_joint}]"), error)
    })?;
    let efficiency = joint.gear_efficiency.unwrap_or(1.0);
    Transmission::new(ratio, efficiency)
        .map_err(|error| check.refuse_as(format!("joints[{index}].gear_efficiency"), efficiency, error))
}

fn encoder(
    index: usize,
    joint: &file::Joint,
    gear: GearRatio,
    velocity: f64,
    period: f64,
    check: &Checker<'_>,
) -> Result<EncoderConfiguration, RobotError> {
    let field = |name: &str| format!("joints[{index}].encoder.{name}");
    let encoder = &joint.encoder;
    reference(encoder, &field, check)?;
    homing::check(index, joint, check)?;
    let counts = encoder.counts_per_revolution;
    let counts_per_revolution = CountsPerRevolution::behind(counts, gear)
        .map_err(|error| check.refuse_as(field("counts_per_revolution"), counts, error))?;
    let counter_width = CounterWidth::new(encoder.counter_bits)
        .map_err(|error| check.refuse_as(field("counter_bits"), encoder.counter_bits, error))?;
    // The base of the paper's robot turns further than its counter, if that is of one turn, can tell: only its motion counts.
    if gear != GearRatio::DIRECT || joint.role == Role::Active {
        let seen = 2.0_f64.powi(encoder.counter_bits.into()) * counts_per_revolution.resolution().to_degrees();
        let limits = &joint.limits;
        if seen <= limits.maximum_deg - limits.minimum_deg {
            let expected = format!(
                "so many that the counter, which repeats every {seen:.1} deg of the joint, tells all angles within limits apart"
            );
            return Err(check.refuse(field("counter_bits"), encoder.counter_bits, expected));
        }
    }
    // A wake-up may come up to a period late without a deadline missed, so one period's motion at full velocity is the
    // margin.
    let margin = (velocity * period / counts_per_revolution.resolution()).ceil() as u32 + 1;
    let jump_limit = JumpLimit::new(velocity, margin)
        .map_err(|error| check.refuse_as(format!("joints[{index}].limits.velocity_deg_per_s"), velocity, error))?;
    Ok(EncoderConfiguration {
        counts_per_revolution,
        counter_width,
        direction: encoder.direction,
        zero: encoder.zero_counts,
        jump_limit,
    })
}

/// Highest bit of the statusword.
const LAST_STATUSWORD_BIT: u8 = 15;

/// An incremental encoder needs something by which the loss of power is seen.
fn reference(encoder: &file::Encoder, field: &impl Fn(&str) -> String, check: &Checker<'_>) -> Result<(), RobotError> {
    if encoder.reference == ReferenceKind::Incremental
        && encoder.power_marker.is_none()
        && encoder.referenced_bit.is_none()
    {
        let expected = "power_marker or referenced_bit beside it, by which the loss of the drive's power is seen";
        return Err(check.refuse(field("reference"), "\"incremental\"", expected));
    }
    if let Some(bit) = encoder.referenced_bit.filter(|bit| *bit > LAST_STATUSWORD_BIT) {
        return Err(check.refuse(field("referenced_bit"), bit, "a bit of the statusword, 0 to 15"));
    }
    if let Some(marker) = encoder.power_marker.as_ref().filter(|marker| marker.as_value().is_none()) {
        let expected = format!("a value that fits type {:?}", marker.kind);
        return Err(check.refuse(field("power_marker.value"), marker.value, expected));
    }
    Ok(())
}

/// Object 6076h holds a whole number of its unit.
fn rated_torque(
    field: &str,
    newton_metres: f64,
    unit: TorqueUnit,
    check: &Checker<'_>,
) -> Result<RatedTorque, RobotError> {
    let (in_newton_metre, expected) = match unit {
        TorqueUnit::MillinewtonMetre => (1e3, "a whole number of mN m above 0, as object 6076h holds it"),
        TorqueUnit::MicronewtonMetre => (1e6, "a whole number of uN m above 0, as object 6076h holds it"),
    };
    let value = (newton_metres * in_newton_metre).round();
    if !(1.0..=f64::from(u32::MAX)).contains(&value) || (newton_metres * in_newton_metre - value).abs() > 1e-6 {
        return Err(check.refuse(field, newton_metres, expected));
    }
    RatedTorque::new(value as u32, unit).map_err(|_| check.refuse(field, newton_metres, expected))
}

/// The scale of a joint whose drive is never sent more than its limit, rounded up to a whole per mille.
fn scale(
    rated_torque: RatedTorque,
    direction: Direction,
    transmission: Transmission,
    torque_limit: f64,
) -> TorqueScale {
    let scale = TorqueScale { rated_torque, direction, ceiling: TorqueCeiling::RATED, transmission };
    // What is a whole number but for the rounding of the division is one.
    let per_mille = (torque_limit / scale.per_mille() * (1.0 - 1e-12)).ceil().clamp(1.0, f64::from(i16::MAX)) as i16;
    TorqueScale { ceiling: TorqueCeiling::new(per_mille).unwrap_or(TorqueCeiling::RATED), ..scale }
}

fn torque_delay(
    field: &str,
    joint: &file::Joint,
    control: &file::Control,
    check: &Checker<'_>,
) -> Result<Duration, RobotError> {
    let microseconds = joint.drive.torque_delay_us.unwrap_or_default();
    if microseconds < control.period_us {
        Ok(Duration::from_micros(microseconds.into()))
    } else {
        Err(check.refuse(field, microseconds, format!("less than control.period_us, {}", control.period_us)))
    }
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

    /// 0.001 N m of a motor of 0.001 N m are 1000 per mille, and in floating point a little more.
    #[test]
    fn a_limit_at_the_rated_torque_is_a_thousand_per_mille() {
        for millinewton_metres in 1..3000_u32 {
            let rated = super::RatedTorque::new(millinewton_metres, super::TorqueUnit::MillinewtonMetre).unwrap();
            let limit = f64::from(millinewton_metres) * 1e-3;
            let scale = super::scale(rated, super::Direction::Positive, super::Transmission::DIRECT, limit);
            assert_eq!(scale.ceiling.per_mille(), 1000, "{millinewton_metres}");
        }
    }

    fn first_joint(fields: &str, bits: u8) -> Result<uarm_loop::robot::Joint, String> {
        let text = BUILT_IN.replacen("node = 1  ", &format!("{fields}\nnode = 1  "), 1).replacen(
            "counter_bits = 32",
            &format!("counter_bits = {bits}"),
            1,
        );
        let [joint, ..] = Robot::parse(Path::new("test.toml"), &text, &Overrides::default())
            .map_err(|error| error.to_string())?
            .description
            .joints;
        Ok(joint)
    }

    /// Motor-side counts and torque: 33739 counts a revolution of the motor, which turns 50/3 times as fast.
    #[test]
    fn a_gear_makes_counts_and_torque_those_of_the_joint() {
        let joint = first_joint("gear_ratio = [50, 3]\ngear_efficiency = 0.75", 32).unwrap();
        assert_eq!(joint.encoder.counts_per_revolution.ratio(), (33_739 * 50, 3));
        // 0.2 mN m times 50/3 times 0.75.
        assert!((joint.torque_scale.per_mille() - 2.5e-3).abs() < 1e-15);
        assert_eq!(joint.drive.counts_per_revolution, 33_739, "the drive counts its motor");
        let direct = first_joint("", 32).unwrap();
        assert_eq!(direct.torque_scale.per_mille().to_bits(), (f64::from(200) * 1e-3 * 1e-3).to_bits());
    }

    #[test]
    fn what_no_gear_has_is_refused() {
        for (fields, parts) in [
            ("gear_ratio = [0, 1]", ["joints[0].gear_ratio = [0, 1]", "1 to 1000000"]),
            ("gear_efficiency = 0.0", ["joints[0].gear_efficiency = 0", "above 0 and at most 1"]),
            ("gear_efficiency = 1.5", ["joints[0].gear_efficiency = 1.5", "above 0 and at most 1"]),
        ] {
            let message = first_joint(fields, 32).unwrap_err();
            assert!(parts.iter().all(|part| message.contains(part)), "{message}");
        }
        // 2^20 counts of 33739 * 100 a revolution are 112 degrees, of limits 7200 degrees apart.
        let message = first_joint("gear_ratio = [100, 1]", 20).unwrap_err();
        assert!(message.contains("joints[0].encoder.counter_bits = 20") && message.contains("111.9 deg"), "{message}");
    }

    #[test]
    fn an_incremental_encoder_needs_a_sign_of_lost_power() {
        let with = |keys: &str| {
            let text =
                BUILT_IN.replacen("zero_counts = 0", &format!("zero_counts = 0, reference = \"incremental\"{keys}"), 1);
            Robot::parse(Path::new("test.toml"), &text, &Overrides::default())
                .map(drop)
                .map_err(|error| error.to_string())
        };
        let error = with("").unwrap_err();
        assert!(error.contains("joints[0].encoder.reference") && error.contains("power_marker"), "{error}");
        assert_eq!(with(", referenced_bit = 15"), Ok(()));
        let marker = |value| {
            with(&format!(", power_marker = {{ index = 0x6081, subindex = 0, type = \"u8\", value = {value} }}"))
        };
        assert_eq!(marker(7), Ok(()));
        assert!(marker(256).unwrap_err().contains("joints[0].encoder.power_marker.value"));
        assert!(with(", referenced_bit = 16").unwrap_err().contains("0 to 15"));
    }

    #[test]
    fn a_torque_is_later_than_its_command_by_less_than_a_period() {
        let with = |microseconds: u32| {
            let from = "rated_torque_nm = 0.2, ";
            let text = BUILT_IN.replace(from, &format!("{from}torque_delay_us = {microseconds}, "));
            Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).map_err(|error| error.to_string())
        };
        let delays = |robot: &Robot| robot.description.joints.each_ref().map(|joint| joint.torque_delay.as_micros());
        assert_eq!(delays(&Robot::load(None).unwrap()), [0; 3]);
        assert_eq!(delays(&with(2_999).unwrap()), [2_999; 3]);
        let message = with(3_000).unwrap_err();
        assert!(message.contains("joints[0].drive.torque_delay_us = 3000"), "{message}");
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
