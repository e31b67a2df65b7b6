//! Choices and times on command lines.

use std::str::FromStr;
use std::time::Duration;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use uarm_io::drive::NodeId;
use uarm_io::drive::wire::MASTER_NODE;
use uarm_loop::choice::Choice;
use uarm_loop::period::Period;

/// A parser for a choice, which lists each value with its description in the help text.
pub fn choice<C: Choice>() -> impl TypedValueParser<Value = C> {
    let values = C::ALL.iter().map(|choice| PossibleValue::new(choice.name()).help(choice.description()));
    PossibleValuesParser::new(values).try_map(|name| C::from_name(&name).ok_or("not one of the possible values"))
}

/// The longest approach and the longest hold: as long as a robot file's.
const LONGEST_APPROACH: Duration = Duration::from_secs(3600);
const LONGEST_HOLD: Duration = Duration::from_secs(24 * 3600);

/// The period of a loop.
///
/// # Errors
/// What was expected, if it is none.
pub fn period(text: &str) -> Result<Duration, String> {
    let expected = format!(
        "expected a whole number of microseconds from {:?} to {:?}, such as 3ms",
        Period::SHORTEST,
        Period::LONGEST
    );
    let period = humantime::parse_duration(text)
        .ok()
        .filter(|period| Period::new(*period).is_some() && period.as_nanos().is_multiple_of(1_000));
    period.ok_or(expected)
}

/// How long the end of a motion is held.
///
/// # Errors
/// What was expected, if it is no such time.
pub fn hold(text: &str) -> Result<Duration, String> {
    let hold = humantime::parse_duration(text).ok().filter(|hold| *hold <= LONGEST_HOLD);
    hold.ok_or_else(|| "expected a time up to 24h, such as 500ms or 60s".to_owned())
}

/// How long the way to the start of a motion takes.
///
/// # Errors
/// What was expected, if it is no such time.
pub fn approach(text: &str) -> Result<Duration, String> {
    let approach = humantime::parse_duration(text).ok();
    let approach = approach.filter(|approach| !approach.is_zero() && *approach <= LONGEST_APPROACH);
    approach.ok_or_else(|| "expected a time above 0 up to 1h, such as 5s".to_owned())
}

/// A number of things, one at least, as one of the types that hold no zero.
///
/// # Errors
/// What was expected, if it is none.
pub fn positive<N: FromStr>(text: &str) -> Result<N, String> {
    text.parse().map_err(|_| "expected a whole number above 0".to_owned())
}

/// A point in time, s.
///
/// # Errors
/// What was expected, if it is no finite number.
pub fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds: &f64| seconds.is_finite());
    seconds.ok_or_else(|| "expected a finite number of seconds".to_owned())
}

/// The length of a step.
///
/// # Errors
/// What was expected, if it is no finite number above 0.
pub fn step(text: &str) -> Result<f64, String> {
    let step = text.parse().ok().filter(|step: &f64| step.is_finite() && *step > 0.0);
    step.ok_or_else(|| "expected a finite number above 0".to_owned())
}

/// A size such as `500MB` or `2GiB`, bytes.
///
/// # Errors
/// What was expected, if it is none.
pub fn size(text: &str) -> Result<u64, String> {
    const UNITS: [(&str, u64); 6] =
        [("kB", 1000), ("MB", 1_000_000), ("GB", 1_000_000_000), ("KiB", 1 << 10), ("MiB", 1 << 20), ("GiB", 1 << 30)];
    let sizes = UNITS.iter().find_map(|(unit, bytes)| Some((decimal(text.strip_suffix(unit)?.trim())?, *bytes)));
    let Some(((digits, divisor), unit)) = sizes else {
        return Err(
            "expected a number with a unit (kB, MB, GB, KiB, MiB, GiB), such as 500MB, 1.5GB or 2GiB".to_owned()
        );
    };
    let bytes = digits.checked_mul(unit.into()).and_then(|product| u64::try_from(product / divisor).ok());
    match bytes {
        None => Err(format!("too large, expected at most {} bytes", u64::MAX)),
        Some(0) => Err("expected more than 0 bytes, such as 500MB or 2GiB".to_owned()),
        Some(bytes) => Ok(bytes),
    }
}

/// A decimal number as digits and the power of ten that they are divided by. Digits that are too many count as the largest number.
fn decimal(text: &str) -> Option<(u128, u128)> {
    const MOST_PLACES: usize = 9;
    let (whole, places) = text.split_once('.').map_or((text, None), |(whole, places)| (whole, Some(places)));
    let is_number = |digits: &str| !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_digit());
    if !is_number(whole) || places.is_some_and(|places| !is_number(places) || places.len() > MOST_PLACES) {
        return None;
    }
    let places = places.unwrap_or_default();
    let divisor = places.bytes().fold(1, |power, _| power * 10);
    Some((format!("{whole}{places}").parse().unwrap_or(u128::MAX), divisor))
}

/// Reads a time such as `3ms`, `1.5s` or `2m 30s`.
///
/// # Errors
/// What was expected.
pub fn duration(text: &str) -> Result<Duration, String> {
    let expected = || format!("{text:?}: expected a time such as 3ms, 1.5s or 2m 30s");
    if let Ok(duration) = humantime::parse_duration(text) {
        return Ok(duration);
    }
    let units = [("us", 1e-6), ("ms", 1e-3), ("s", 1.0)];
    let (number, unit) = units
        .iter()
        .find_map(|(unit, seconds)| Some((text.strip_suffix(unit)?.trim(), seconds)))
        .ok_or_else(expected)?;
    let seconds = number.parse::<f64>().map_err(|_| expected())? * unit;
    let duration = Duration::try_from_secs_f64(seconds).map_err(|_| expected())?;
    Ok(duration)
}

/// Reads the node id of a drive.
///
/// # Errors
/// Unless it is 1 to 126: 127 is the master's.
pub fn node_id(text: &str) -> Result<NodeId, String> {
    let expected = || format!("expected a node id, 1 to {}", MASTER_NODE - 1);
    let raw: u8 = text.parse().map_err(|_| expected())?;
    NodeId::new(raw).ok().filter(|node| (1..MASTER_NODE).contains(&node.raw())).ok_or_else(expected)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hinf_control::Law;

    #[test]
    fn times_have_units_and_may_have_fractions() {
        for (text, microseconds) in [("3ms", 3_000), ("1.5s", 1_500_000), ("250us", 250), ("2m 30s", 150_000_000)] {
            assert_eq!(duration(text), Ok(Duration::from_micros(microseconds)), "{text}");
        }
        for text in ["3", "", "s", "-1s", "fast", "1e300s", "NaNs"] {
            assert!(duration(text).unwrap_err().contains("3ms"), "{text}");
        }
    }

    #[test]
    fn drives_have_1_to_126() {
        assert_eq!(node_id("126").map(NodeId::raw), Ok(126));
        for text in ["0", "127", "-1", "two", "300"] {
            assert!(node_id(text).unwrap_err().contains("1 to 126"), "{text}");
        }
    }

    #[test]
    fn a_choice_is_read_by_its_name() {
        let command = clap::Command::new("test").arg(clap::Arg::new("law").value_parser(choice::<Law>()));
        let law = |text: &str| {
            command.clone().try_get_matches_from(["test", text]).map(|found| found.get_one("law").copied())
        };
        assert_eq!(law("fuzzy-model").unwrap(), Some(Law::FuzzyModel));
        let error = law("pid").unwrap_err().to_string();
        assert!(error.contains("possible values: nonlinear, adaptive"), "{error}");
    }

    #[test]
    fn times_and_numbers_out_of_range_are_refused() {
        assert_eq!(period("3ms"), Ok(Duration::from_millis(3)));
        assert_eq!(hold("0s"), Ok(Duration::ZERO));
        assert_eq!(approach("1m"), Ok(Duration::from_secs(60)));
        assert_eq!((seconds("-1.5"), step("0.5")), (Ok(-1.5), Ok(0.5)));
        for wrong in ["0ms", "1s", "-3ms", "1500ns", "fast", ""] {
            assert!(period(wrong).is_err(), "{wrong}");
        }
        for wrong in ["-1s", "25h", "nan"] {
            assert!(hold(wrong).is_err() && approach(wrong).is_err(), "{wrong}");
        }
        assert_eq!(hold("24h"), Ok(Duration::from_secs(86_400)));
        assert!(approach("0s").is_err() && approach("2h").is_err());
        assert_eq!((size("500MB"), size("2 GiB")), (Ok(500_000_000), Ok(2_147_483_648)));
        assert_eq!((size("18.1MB"), size("1.5GiB"), size("0.001kB")), (Ok(18_100_000), Ok(1_610_612_736), Ok(1)));
        for wrong in ["500", "", "MB", "-1MB", "0MB", "1TB", "1.MB", ".5MB", "1.2.3MB", "1e3MB"] {
            assert!(size(wrong).unwrap_err().contains("500MB"), "{wrong}");
        }
        for wrong in ["99999999999GiB", "99999999999999999999999999999999999999999999GB"] {
            assert_eq!(size(wrong).unwrap_err(), "too large, expected at most 18446744073709551615 bytes", "{wrong}");
        }
        for wrong in ["nan", "inf", "-inf", "x"] {
            assert!(seconds(wrong).is_err() && step(wrong).is_err(), "{wrong}");
        }
        assert!(step("-1").is_err() && step("0").is_err());
        assert_eq!(positive("7"), Ok(core::num::NonZeroU32::new(7).unwrap()));
        for wrong in ["0", "-1", "x", "4294967296"] {
            assert_eq!(positive::<core::num::NonZeroU32>(wrong).unwrap_err(), "expected a whole number above 0");
        }
    }
}
