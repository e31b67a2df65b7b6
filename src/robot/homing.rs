//! How a joint's drive finds its home position by itself: checked.

use uarm_io::drive::wishes;
use uarm_io::time::Duration;

use super::error::{Checker, RobotError};
use super::file::{self, ReferenceKind};

/// How a joint is homed, and how it is watched meanwhile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homing {
    /// What is written to the drive.
    pub wish: wishes::Homing,
    /// The joint's angle at the home position, rad.
    pub angle: f64,
    /// What 6064h reads there afterwards.
    pub counts_at_home: i32,
    /// The furthest that the joint may move from where it stands, rad.
    pub travel: f64,
    /// The longest that it may take.
    pub timeout: Duration,
}

/// Unless the file says otherwise.
const TIMEOUT_S: u16 = 60;
const LONGEST_TIMEOUT_S: u16 = 600;
/// Two revolutions of the joint: an index or a switch is nearer.
const LONGEST_TRAVEL_DEG: f64 = 720.0;

/// The homing of `joint`, if it has one.
pub(super) fn check(index: usize, joint: &file::Joint, check: &Checker<'_>) -> Result<Option<Homing>, RobotError> {
    let Some(homing) = joint.encoder.homing else { return Ok(None) };
    let field = |name: &str| format!("joints[{index}].encoder.homing{name}");
    if joint.encoder.reference != ReferenceKind::Incremental {
        return Err(check.refuse(field(""), "a table", "none, unless encoder.reference = \"incremental\""));
    }
    let method = i8::try_from(homing.method).ok().filter(|method| is_method(*method)).ok_or_else(|| {
        let expected = "a method of CiA 402, 1 to 14, 17 to 30 or 33 to 37, or a maker's, -128 to -1";
        check.refuse(field(".method"), homing.method, expected)
    })?;
    if homing.speeds.contains(&0) {
        let expected = "6099h:01 and :02 in the drive's own unit of velocity, above 0";
        return Err(check.refuse(field(".speeds"), format!("{:?}", homing.speeds), expected));
    }
    if homing.acceleration == Some(0) {
        return Err(check.refuse(field(".acceleration"), 0, "609Ah in the drive's own unit of acceleration, above 0"));
    }
    let limits = &joint.limits;
    let angle = check.within(&field(".angle_deg"), homing.angle_deg, limits.minimum_deg, limits.maximum_deg)?;
    let travel = homing.travel_deg;
    if !(travel > 0.0 && travel <= LONGEST_TRAVEL_DEG) {
        let expected = format!("a number above 0, at most {LONGEST_TRAVEL_DEG}");
        return Err(check.refuse(field(".travel_deg"), travel, expected));
    }
    let timeout = homing.timeout_s.unwrap_or(TIMEOUT_S);
    if !(1..=LONGEST_TIMEOUT_S).contains(&timeout) {
        return Err(check.refuse(field(".timeout_s"), timeout, format!("1 to {LONGEST_TIMEOUT_S}")));
    }
    Ok(Some(Homing {
        wish: wishes::Homing {
            method,
            switch_speed: homing.speeds[0],
            zero_speed: homing.speeds[1],
            acceleration: homing.acceleration,
            offset: homing.offset,
        },
        angle: angle.to_radians(),
        counts_at_home: counts_at_home(&homing, &field, check)?,
        travel: travel.to_radians(),
        timeout: Duration::from_secs(timeout.into()),
    }))
}

/// The standard has the home position at minus 607Ch, many makers at plus: with an offset the file says which.
fn counts_at_home(
    homing: &file::Homing,
    field: &impl Fn(&str) -> String,
    check: &Checker<'_>,
) -> Result<i32, RobotError> {
    let negated = homing.offset.checked_neg();
    match homing.counts_at_home {
        None if homing.offset == 0 => Ok(0),
        Some(counts) if counts == homing.offset || Some(counts) == negated => Ok(counts),
        found => {
            let found = found.map_or_else(|| "absent".to_owned(), |found| found.to_string());
            let offset = homing.offset;
            let either = match negated {
                Some(negated) if negated != offset => format!("{offset} or {negated}"),
                _ => offset.to_string(),
            };
            let expected = format!("{either}: what 6064h reads at home with offset = {offset}");
            Err(check.refuse(field(".counts_at_home"), found, expected))
        }
    }
}

const fn is_method(method: i8) -> bool {
    matches!(method, i8::MIN..=-1 | 1..=14 | 17..=30 | 33..=37)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::robot::on_bus::JointsOnBus;
    use crate::robot::overrides::Overrides;
    use crate::robot::{BUILT_IN, Robot};

    const PLAIN: &str = "node = 2\nencoder = { counts_per_revolution = 33739, counter_bits = 32, direction = \"positive\", zero_counts = 0";
    const WHOLE: &str = "method = 33, speeds = [2000, 200], angle_deg = -90.0, travel_deg = 180.0";

    fn parse(kind: &str, homing: &str) -> Result<Option<Homing>, String> {
        let keys = format!("{PLAIN}, reference = \"{kind}\", referenced_bit = 15, homing = {{ {homing} }}");
        let text = BUILT_IN.replace(PLAIN, &keys);
        let robot = Robot::parse(Path::new("test.toml"), &text, &Overrides::default());
        robot.map(|robot| JointsOnBus::of(&robot).homing(1).unwrap()).map_err(|error| error.to_string())
    }

    #[test]
    fn homing_is_what_the_file_says_in_the_units_of_the_program() {
        let homing = parse("incremental", WHOLE).unwrap().unwrap();
        let wish = wishes::Homing { method: 33, switch_speed: 2_000, zero_speed: 200, acceleration: None, offset: 0 };
        assert_eq!(homing.wish, wish);
        assert_eq!((homing.counts_at_home, homing.timeout), (0, Duration::from_secs(60)));
        assert!((homing.angle + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!((homing.travel - std::f64::consts::PI).abs() < 1e-12);
        let more = format!("{WHOLE}, acceleration = 50, offset = 7, counts_at_home = -7, timeout_s = 5");
        let homing = parse("incremental", &more).unwrap().unwrap();
        assert_eq!((homing.wish.acceleration, homing.wish.offset), (Some(50), 7));
        assert_eq!((homing.counts_at_home, homing.timeout), (-7, Duration::from_secs(5)));
        assert_eq!(JointsOnBus::of(&Robot::load(None).unwrap()).homing(1).unwrap(), None);
    }

    #[test]
    fn what_cannot_be_is_refused_with_field_value_and_expectation() {
        for (from, to, parts) in [
            ("method = 33", "method = 0", ["encoder.homing.method = 0", "17 to 30"]),
            ("method = 33", "method = 15", ["encoder.homing.method = 15", "33 to 37"]),
            ("method = 33", "method = 300", ["encoder.homing.method = 300", "-128 to -1"]),
            ("method = 33", "method = -129", ["encoder.homing.method = -129", "-128 to -1"]),
            ("[2000, 200]", "[2000, 0]", ["encoder.homing.speeds = [2000, 0]", "above 0"]),
            ("angle_deg = -90.0", "angle_deg = 171.0", ["encoder.homing.angle_deg = 171", "-170 to 170"]),
            ("travel_deg = 180.0", "travel_deg = 0.0", ["encoder.homing.travel_deg = 0", "above 0"]),
            ("travel_deg = 180.0", "travel_deg = 721.0", ["encoder.homing.travel_deg = 721", "above 0, at most 720"]),
            ("travel_deg", "timeout_s = 601, travel_deg", ["encoder.homing.timeout_s = 601", "1 to 600"]),
            ("travel_deg", "acceleration = 0, travel_deg", ["encoder.homing.acceleration = 0", "above 0"]),
            ("travel_deg", "offset = 7, travel_deg", ["encoder.homing.counts_at_home = absent", "7 or -7"]),
            (
                "travel_deg",
                "counts_at_home = 7, travel_deg",
                ["encoder.homing.counts_at_home = 7", "expected 0: what 6064h reads at home with offset = 0"],
            ),
            ("travel_deg", "speed = 7, travel_deg", ["encoder.homing.speed = unknown field", "counts_at_home"]),
        ] {
            let message = parse("incremental", &WHOLE.replace(from, to)).unwrap_err();
            for part in [parts[0], parts[1], "joints[1]"] {
                assert!(message.contains(part), "{message}: expected {part}");
            }
        }
        let message = parse("absolute", WHOLE).unwrap_err();
        assert!(message.contains("joints[1].encoder.homing") && message.contains("incremental"), "{message}");
    }
}
