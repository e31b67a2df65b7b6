//! The bus: checked.

use uarm_io::bus_time::{BitRate, BusTime, BusTimeError};
use uarm_io::drive::network::{LISTEN, Timeouts};
use uarm_io::drive::pdo_objects::PdoKind;
use uarm_io::drive::plan::interpolation_times;
use uarm_io::time::Duration;
use uarm_loop::period::Period;
use uarm_loop::robot::{Bus, Joint, Protocol};

use super::error::{Checker, RobotError};
use super::file;

/// The longest that drives may wait for a controller that has died, with its last torque standing. At full torque a joint of the UARM turns
/// more than once in this time: 50 ms, as in the shipped files, is what a watchdog should have.
const LONGEST_CONTROLLER_TIMEOUT: Duration = Duration::from_millis(500);

/// Bit rates of classic CAN, bit/s (CiA 301).
const BITRATES: [u32; 8] = [1_000_000, 800_000, 500_000, 250_000, 125_000, 50_000, 20_000, 10_000];

pub(super) fn check(
    bus: &file::Bus,
    joints: &[Joint],
    protocol: Protocol,
    period: Period,
    check: &Checker<'_>,
) -> Result<Bus, RobotError> {
    if !BITRATES.contains(&bus.bitrate_hz) {
        return Err(check.refuse("bus.bitrate_hz", bus.bitrate_hz, format!("one of {BITRATES:?}")));
    }
    let bit_rate = BitRate::new(bus.bitrate_hz)
        .map_err(|error| check.refuse("bus.bitrate_hz", bus.bitrate_hz, error.to_string()))?;
    let others = other_frames(joints);
    let time_in = |period| match protocol {
        Protocol::Canopen => BusTime::of_cycle_with(joints.len(), &others, bit_rate, period),
        Protocol::Odrive(positions) => BusTime::of_odrive_cycle(joints.len(), positions, bit_rate, period),
    };
    let time = time_in(period.duration()).map_err(|error| {
        let can_be_told = |period| protocol != Protocol::Canopen || interpolation_times(period).next().is_some();
        let expected = match shortest_from(period.duration(), time_in, can_be_told) {
            Some(shortest) => format!("at least {}: {error}", shortest.as_micros()),
            None => format!("a faster bus, since no period is long enough: {error}"),
        };
        check.refuse("control.period_us", period.duration().as_micros(), expected)
    })?;
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
    if controller_timeout > LONGEST_CONTROLLER_TIMEOUT {
        return Err(check.refuse(
            "bus.controller_timeout_ms",
            bus.controller_timeout_ms,
            format!(
                "at most {} (for so long the last torque may stand when the controller has died)",
                LONGEST_CONTROLLER_TIMEOUT.as_millis()
            ),
        ));
    }
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
    let listen = listen(bus, period, check)?;
    let otherwise = Timeouts::default();
    let longer = |field: &str, value: Option<u16>, otherwise: Duration, why: &str| {
        value.map_or(Ok(otherwise), |value| milliseconds(field, value, Duration::from_millis(1), why))
    };
    let timeouts = Timeouts {
        boot: longer("boot_timeout_ms", bus.boot_timeout_ms, otherwise.boot, "a drive needs time to boot")?,
        sdo: sdo_timeout,
        sdo_attempts: attempts(bus, check)?.unwrap_or(otherwise.sdo_attempts),
        nmt: longer("nmt_timeout_ms", bus.nmt_timeout_ms, otherwise.nmt, "one heartbeat of the drive")?,
        power: longer("power_timeout_ms", bus.power_timeout_ms, otherwise.power, "power stage and brake take time")?,
        ..otherwise
    };
    if timeouts.nmt <= drive_heartbeat {
        let expected = format!(
            "above bus.drive_heartbeat_ms = {}: a drive's heartbeat tells that it does what NMT commands",
            bus.drive_heartbeat_ms
        );
        return Err(check.refuse("bus.nmt_timeout_ms", timeouts.nmt.as_millis(), expected));
    }
    Ok(Bus {
        protocol,
        bit_rate,
        time,
        controller_heartbeat,
        controller_timeout,
        drive_heartbeat,
        drive_timeout,
        listen,
        timeouts,
        sync_counter: bus.sync_counter.unwrap_or_default(),
        emergency_reaction: bus.emergency.unwrap_or_default(),
        ignored_target_reaction: bus.target_ignored.unwrap_or_default(),
    })
}

/// The shortest period from `period` on, in whole microseconds, whose frames fit into it by `time_in`, and that drives `can_be_told`;
/// `None` if there is none. Some drives send the more frames the longer it is.
fn shortest_from(
    mut period: Duration,
    time_in: impl Fn(Duration) -> Result<BusTime, BusTimeError>,
    can_be_told: impl Fn(Duration) -> bool,
) -> Option<Duration> {
    const STEP: Duration = Duration::from_micros(1);
    while period <= Period::LONGEST {
        match time_in(period) {
            Ok(_) if can_be_told(period) => return Some(period),
            Ok(_) => period += STEP,
            Err(BusTimeError::DoesNotFit { needed, .. }) => {
                period = Duration::from_micros(u64::try_from(needed.as_nanos().div_ceil(STEP.as_nanos())).ok()?);
            }
            Err(_) => return None,
        }
    }
    None
}

fn attempts(bus: &file::Bus, check: &Checker<'_>) -> Result<Option<u8>, RobotError> {
    const RANGE: std::ops::RangeInclusive<u8> = 1..=20;
    match bus.sdo_attempts {
        Some(attempts) if !RANGE.contains(&attempts) => {
            Err(check.refuse("bus.sdo_attempts", attempts, format!("{} to {}", RANGE.start(), RANGE.end())))
        }
        attempts => Ok(attempts),
    }
}

/// Data bytes of the frames beyond those that every robot has: torque feedback, and TPDOs that are kept, of which no more
/// is known than that a frame has eight bytes at most.
fn other_frames(joints: &[Joint]) -> Vec<usize> {
    const TORQUE_FEEDBACK: usize = 2;
    const MOST: usize = 8;
    let of_joint = |joint: &Joint| {
        let torque = joint.drive.pdos.torque_feedback.map(|_| TORQUE_FEEDBACK);
        let kept = joint.drive.pdos.kept.iter().filter(|(kind, _)| *kind == PdoKind::Transmit).count();
        torque.into_iter().chain(std::iter::repeat_n(MOST, kept)).collect::<Vec<_>>()
    };
    joints.iter().flat_map(of_joint).collect()
}

/// Two heartbeats and two SYNCs of another controller with this robot file are heard at least.
fn listen(bus: &file::Bus, period: Period, check: &Checker<'_>) -> Result<Duration, RobotError> {
    let least = Duration::from_millis(bus.controller_heartbeat_ms.into()).max(period.duration()) * 2;
    let Some(milliseconds) = bus.listen_ms else { return Ok(LISTEN.max(least)) };
    let duration = Duration::from_millis(milliseconds.into());
    if duration < least {
        let expected = format!("at least {} (two heartbeats of a controller, and two periods)", least.as_millis());
        return Err(check.refuse("bus.listen_ms", milliseconds, expected));
    }
    Ok(duration)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use uarm_io::drive::network::{EmergencyReaction, IgnoredTargetReaction, Timeouts};
    use uarm_io::drive::wishes::SyncCounterChoice;
    use uarm_io::time::Duration;

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

    /// Two heartbeats of 10 ms, or two periods of 3 ms.
    #[test]
    fn another_controller_has_time_to_be_heard() {
        let listen = |milliseconds: u16, more: &str| {
            let text = format!("sdo_timeout_ms = 500\nlisten_ms = {milliseconds}{more}");
            with("sdo_timeout_ms = 500", &text).map(|robot| robot.description.bus.listen.as_millis())
        };
        assert_eq!(Robot::load(None).unwrap().description.bus.listen.as_millis(), 200);
        assert_eq!(listen(20, ""), Ok(20));
        let message = listen(19, "").unwrap_err();
        assert!(message.contains("bus.listen_ms") && message.contains("at least 20"), "{message}");
        // A controller that is heard less often is listened for longer.
        let slow = BUILT_IN
            .replace("controller_heartbeat_ms = 10", "controller_heartbeat_ms = 150")
            .replace("controller_timeout_ms = 50", "controller_timeout_ms = 400");
        let slow = Robot::parse(Path::new("test.toml"), &slow, &Overrides::default()).unwrap();
        assert_eq!(slow.description.bus.listen.as_millis(), 300);
    }

    #[test]
    fn timeouts_attempts_counter_and_reaction_have_defaults_and_ranges() {
        let bus = |fields: &str| with("sdo_timeout_ms = 500 ", &format!("sdo_timeout_ms = 500\n{fields}\n"));
        let plain = bus("").unwrap().description.bus;
        let expected = Timeouts { sdo: Duration::from_millis(500), ..Timeouts::default() };
        assert_eq!((plain.timeouts, plain.sync_counter), (expected, SyncCounterChoice::Auto));
        assert_eq!(plain.emergency_reaction, EmergencyReaction::Stop);
        let told = bus("boot_timeout_ms = 9000\nnmt_timeout_ms = 700\npower_timeout_ms = 4000\nsdo_attempts = 5\n\
                        sync_counter = \"off\"\nemergency = \"record\"\ntarget_ignored = \"record\"")
        .unwrap()
        .description
        .bus;
        let milliseconds = Duration::from_millis;
        assert_eq!(
            told.timeouts,
            Timeouts {
                boot: milliseconds(9000),
                nmt: milliseconds(700),
                power: milliseconds(4000),
                sdo_attempts: 5,
                ..expected
            }
        );
        assert_eq!(told.sync_counter, SyncCounterChoice::Off);
        assert_eq!(told.emergency_reaction, EmergencyReaction::Record);
        assert_eq!(plain.ignored_target_reaction, IgnoredTargetReaction::Stop);
        assert_eq!(told.ignored_target_reaction, IgnoredTargetReaction::Record);
        for (field, part) in [
            ("boot_timeout_ms = 0", "bus.boot_timeout_ms = 0: expected at least 1"),
            ("nmt_timeout_ms = 0", "bus.nmt_timeout_ms = 0"),
            ("nmt_timeout_ms = 50", "bus.nmt_timeout_ms = 50: expected above bus.drive_heartbeat_ms = 50"),
            ("power_timeout_ms = 0", "bus.power_timeout_ms = 0"),
            ("sdo_attempts = 0", "bus.sdo_attempts = 0: expected 1 to 20"),
            ("sync_counter = \"maybe\"", "expected one of `auto`, `on`, `off`"),
            ("emergency = \"ignore\"", "expected `stop` or `record`"),
            ("target_ignored = \"no\"", "expected `stop` or `record`"),
        ] {
            let message = bus(field).unwrap_err();
            assert!(message.contains(part), "{message}");
        }
    }

    /// 75 bits for the torque of one joint, 135 for each TPDO that is kept: at 1 Mbit/s as many microseconds.
    #[test]
    fn other_frames_take_bus_time() {
        let plain = with("name = \"UARM\"", "name = \"UARM\"").unwrap().description.bus.time.cyclic;
        let writes = "drive = { rated_torque_nm = 0.2, writes";
        let text = BUILT_IN.replacen(
            writes,
            "drive = { rated_torque_nm = 0.2, pdo = { torque_tpdo = 2, keep_tpdos = [3, 4] }, writes",
            1,
        );
        let robot = Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).unwrap();
        assert_eq!((robot.description.bus.time.cyclic - plain).as_micros(), 75 + 2 * 135);
    }

    #[test]
    fn the_controller_sends_no_heartbeat_more_often_than_once_a_period() {
        let controller =
            |milliseconds| with("controller_heartbeat_ms = 10", &format!("controller_heartbeat_ms = {milliseconds}"));
        assert!(controller(3).is_ok());
        assert!(controller(2).unwrap_err().contains("bus.controller_heartbeat_ms"));
    }
}
