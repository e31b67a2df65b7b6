//! Which object can be the mark by which a drive's loss of power is seen: one that nobody else writes, and that does nothing when
//! it is written.

use super::readings::Quantity;
use super::wishes::{DriveConfiguration, Resolution};
use canopen_rs::Address;
use core::ops::RangeInclusive;

/// The objects that CiA 301 and CiA 402 leave to makers: nobody but the maker knows what they do.
const OF_MAKERS: RangeInclusive<u16> = 0x2000..=0x5FFF;

/// Profile velocity, end velocity and profile acceleration (CiA 402-2): used in *profile position* and *profile velocity*, which
/// this master never sets.
const OF_UNUSED_MODES: RangeInclusive<u16> = 0x6081..=0x6083;

/// What the standards' objects do, the narrower range first.
const USES: &[(RangeInclusive<u16>, &str)] = &[
    (0x1000..=0x1002, "another object: the drive writes it"),
    (0x1003..=0x1003, "another object: to write it clears the drive's list of errors"),
    (0x1010..=0x1010, "another object: to write it stores the drive's parameters"),
    (0x1011..=0x1011, "another object: to write it restores the drive's parameters"),
    (0x1400..=0x1BFF, "another object: it is a part of the drive's PDOs"),
    (0x1000..=0x1FFF, "another object: it says how the drive communicates"),
    (0x6040..=0x6040, "another object: the master writes it in each cycle"),
    (0x6060..=0x6060, "another object: the master sets the mode with it"),
    (0x6071..=0x6071, "another object: the master writes it in each cycle"),
    (0x6000..=0x67FF, "another object: the drive acts on it, or writes it itself"),
    (0x6800..=0x9FFF, "another object: another axis of the drive acts on it, or writes it"),
];

/// What holds of all objects that no standard and no maker gives a meaning.
const RESERVED: &str =
    "another object, a maker's (2000h to 5FFFh) or 6081h to 6083h: no standard says that it keeps a value";

/// Why the object of the mark of `drive` cannot be one, as what is expected in its place; `None` if it can, or there is no mark.
///
/// What a maker's object does is not known here: it is for whoever names it to know.
pub fn conflict(drive: &DriveConfiguration) -> Option<&'static str> {
    let object = drive.power_marker?.address;
    let mut written = drive.settings.iter().chain(&drive.later_settings);
    if written.any(|setting| setting.address == object) {
        return Some("another object: drive.writes writes it at each start");
    }
    let mut read =
        drive.readings.iter().zip(Quantity::ALL).filter_map(|(reading, quantity)| Some(((*reading)?, quantity)));
    if let Some((_, quantity)) = read.find(|(reading, _)| reading.object == object) {
        return Some(match quantity {
            Quantity::SupplyVoltage => "another object: drive.supply_voltage_v reads it",
            Quantity::Temperature => "another object: drive.temperature_c reads it",
        });
    }
    if matches!(drive.resolution, Resolution::Object { address, .. } if address == object) {
        return Some("another object: encoder.resolution_object is compared with it");
    }
    standard_use(object)
}

fn standard_use(object: Address) -> Option<&'static str> {
    if OF_MAKERS.contains(&object.index) || OF_UNUSED_MODES.contains(&object.index) {
        return None;
    }
    let known = USES.iter().find(|(indices, _)| indices.contains(&object.index));
    Some(known.map_or(RESERVED, |(_, reason)| reason))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::readings::{Reading, ReadingLimits};
    use crate::drive::wishes::Setting;
    use crate::torque::{RatedTorque, TorqueUnit};
    use canopen_rs::{DataType, NodeId, Value};

    fn marked(index: u16, subindex: u8) -> DriveConfiguration {
        let rated = RatedTorque::new(200, TorqueUnit::MillinewtonMetre).unwrap();
        let drive = DriveConfiguration::new(NodeId::new(2).unwrap(), 33_739, rated);
        let marker = Setting::new(Address::new(index, subindex), Value::Unsigned32(77));
        DriveConfiguration { power_marker: Some(marker), ..drive }
    }

    #[test]
    fn what_nobody_uses_can_be_a_mark() {
        let unmarked = DriveConfiguration { power_marker: None, ..marked(0x6071, 0) };
        assert_eq!(conflict(&unmarked), None);
        for index in [0x2000, 0x5FFF, 0x6081, 0x6082, 0x6083] {
            assert_eq!(conflict(&marked(index, 0)), None, "{index:X}h");
        }
    }

    #[test]
    fn what_a_standard_gives_a_meaning_cannot_and_it_is_said_why() {
        for (index, why) in [
            (0x1001, "the drive writes it"),
            (0x1003, "clears the drive's list of errors"),
            (0x1010, "stores the drive's parameters"),
            (0x1011, "restores the drive's parameters"),
            (0x1017, "how the drive communicates"),
            (0x1FFF, "how the drive communicates"),
            (0x1400, "drive's PDOs"),
            (0x1A00, "drive's PDOs"),
            (0x6040, "the master writes it in each cycle"),
            (0x6060, "the master sets the mode"),
            (0x6064, "the drive acts on it, or writes it itself"),
            (0x6071, "the master writes it in each cycle"),
            (0x6075, "the drive acts on it"),
            (0x6080, "the drive acts on it"),
            (0x6084, "the drive acts on it"),
            (0x60FE, "the drive acts on it"),
            (0x6881, "another axis"),
            (0x1FFF - 0x1000, "no standard says"),
            (0xA000, "no standard says"),
        ] {
            let found = conflict(&marked(index, 0)).unwrap_or_default();
            assert!(found.starts_with("another object") && found.contains(why), "{index:X}h: {found}");
        }
    }

    #[test]
    fn what_the_robot_file_uses_already_cannot() {
        let limits = ReadingLimits::new([0.0, 50.0], [0.0, 60.0]).unwrap();
        let object = Address::new(0x2010, 1);
        let reading = Some(Reading { object, data_type: DataType::Unsigned32, scale: 1.0, limits });
        let write = Setting::new(object, Value::Unsigned32(1));
        let marker = || marked(0x2010, 1);
        let (mut before, mut after) = (marker(), marker());
        before.settings.push(write).unwrap();
        after.later_settings.push(write).unwrap();
        for (drive, why) in [
            (before, "drive.writes"),
            (after, "drive.writes"),
            (DriveConfiguration { readings: [reading, None], ..marker() }, "drive.supply_voltage_v"),
            (DriveConfiguration { readings: [None, reading], ..marker() }, "drive.temperature_c"),
            (
                DriveConfiguration { resolution: Resolution::Object { address: object, equals: 1 }, ..marker() },
                "encoder.resolution_object",
            ),
        ] {
            assert!(conflict(&drive).unwrap_or_default().contains(why), "{why}");
            let other = DriveConfiguration { power_marker: marked(0x2010, 2).power_marker, ..drive };
            assert_eq!(conflict(&other), None, "{why}");
        }
    }
}
