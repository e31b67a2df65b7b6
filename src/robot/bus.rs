//! The bus: checked.

use uarm_io::bus_time::{BitRate, BusTime};
use uarm_io::time::Duration;
use uarm_loop::period::Period;
use uarm_loop::robot::Bus;

use super::error::{Checker, RobotError};
use super::file;
use crate::dimensions::JOINTS;

/// Bit rates of classic CAN, bit/s (CiA 301).
const BITRATES: [u32; 8] = [1_000_000, 800_000, 500_000, 250_000, 125_000, 50_000, 20_000, 10_000];

pub(super) fn check(bus: &file::Bus, period: Period, check: &Checker<'_>) -> Result<Bus, RobotError> {
    if !BITRATES.contains(&bus.bitrate_hz) {
        return Err(check.refuse("bus.bitrate_hz", bus.bitrate_hz, format!("one of {BITRATES:?}")));
    }
    let bit_rate = BitRate::new(bus.bitrate_hz)
        .map_err(|error| check.refuse("bus.bitrate_hz", bus.bitrate_hz, error.to_string()))?;
    let time = BusTime::of_cycle(JOINTS, bit_rate, period.duration())
        .map_err(|error| check.refuse("control.period_us", period.duration().as_micros(), error.to_string()))?;
    let milliseconds = |field: &str, value: u16, least: Duration, why: &str| {
        let duration = Duration::from_millis(value.into());
        if duration >= least {
            Ok(duration)
        } else {
            Err(check.refuse(format!("bus.{field}"), value, format!("at least {} ({why})", least.as_millis())))
        }
    };
    // The controller sends its heartbeat from within the loop, so never more often than once a cycle.
    let controller_heartbeat = milliseconds(
        "controller_heartbeat_ms",
        bus.controller_heartbeat_ms,
        period.duration(),
        "one period of the loop, rounded up",
    )?;
    let controller_timeout = milliseconds(
        "controller_timeout_ms",
        bus.controller_timeout_ms,
        controller_heartbeat * 2,
        "two heartbeats of the controller: one may be lost",
    )?;
    let drive_heartbeat = milliseconds(
        "drive_heartbeat_ms",
        bus.drive_heartbeat_ms,
        Duration::from_millis(1),
        "the unit of object 1017h",
    )?;
    let drive_timeout = milliseconds(
        "drive_timeout_ms",
        bus.drive_timeout_ms,
        drive_heartbeat * 2,
        "two heartbeats of the drive: one may be lost",
    )?;
    let sdo_timeout =
        milliseconds("sdo_timeout_ms", bus.sdo_timeout_ms, Duration::from_millis(1), "one frame each way")?;
    Ok(Bus { bit_rate, time, controller_heartbeat, controller_timeout, drive_heartbeat, drive_timeout, sdo_timeout })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::robot::overrides::Overrides;
    use crate::robot::{BUILT_IN, Robot};

    fn with(from: &str, to: &str) -> Result<Robot, String> {
        assert_eq!(BUILT_IN.matches(from).count(), 1, "{from}");
        let text = BUILT_IN.replace(from, to);
        Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).map_err(|error| error.to_string())
    }

    /// The controller sends a heartbeat every 10 ms, a drive every 50 ms.
    #[test]
    fn a_silence_of_two_heartbeats_must_be_borne() {
        let drive = |milliseconds| with("drive_timeout_ms = 200", &format!("drive_timeout_ms = {milliseconds}"));
        let controller =
            |milliseconds| with("controller_timeout_ms = 50", &format!("controller_timeout_ms = {milliseconds}"));
        assert_eq!(controller(20).unwrap().description.bus.controller_timeout.as_millis(), 20);
        assert_eq!(drive(100).unwrap().description.bus.drive_timeout.as_millis(), 100);
        for milliseconds in [10, 19] {
            let message = controller(milliseconds).unwrap_err();
            assert!(message.contains("bus.controller_timeout_ms") && message.contains("at least 20"), "{message}");
        }
        for milliseconds in [50, 99] {
            let message = drive(milliseconds).unwrap_err();
            assert!(message.contains("bus.drive_timeout_ms") && message.contains("at least 100"), "{message}");
        }
    }

    #[test]
    fn the_controller_sends_no_heartbeat_more_often_than_once_a_period() {
        let controller =
            |milliseconds| with("controller_heartbeat_ms = 10", &format!("controller_heartbeat_ms = {milliseconds}"));
        assert!(controller(3).is_ok());
        assert!(controller(2).unwrap_err().contains("bus.controller_heartbeat_ms"));
    }
}
