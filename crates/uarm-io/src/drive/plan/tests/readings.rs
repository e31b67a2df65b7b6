//! What is watched in a run, and the mark of an incremental encoder.

use super::*;
use crate::drive::readings::{Reading, ReadingLimits};
use canopen_rs::DataType;

/// 6079h in V and 2010h:01 in tenths of a degree.
fn watched() -> DriveConfiguration {
    let limits = ReadingLimits::new([0.0, 50.0], [0.0, 60.0]).unwrap();
    let reading =
        |index, subindex, data_type| Reading { object: Address::new(index, subindex), data_type, scale: 1e-3, limits };
    let voltage = reading(0x6079, 0, DataType::Unsigned32);
    let temperature = reading(0x2010, 1, DataType::Integer16);
    DriveConfiguration { readings: [Some(voltage), Some(temperature)], ..wishes() }
}

fn marked() -> DriveConfiguration {
    let marker = Setting::new(Address::new(0x6081, 0), Value::Unsigned16(300));
    DriveConfiguration { power_marker: Some(marker), ..wishes() }
}

impl Dictionary {
    fn typed(mut self, index: u16, subindex: u8, data_type: DataType) -> Self {
        self.0.get_mut(&(index, subindex)).unwrap().data_type = Some(data_type);
        self
    }
}

fn both() -> Dictionary {
    drive().ro(0x6079, 0, 24_000).ro(0x2010, 1, 305)
}

#[test]
fn what_is_watched_must_be_there_readable_and_of_its_type() {
    let works = planned(both().typed(0x2010, 1, DataType::Integer16), &watched());
    assert_eq!(works.verdict(), Verdict::Works, "{:#?}", works.notes().collect::<Vec<_>>());
    assert_eq!(planned(drive(), &wishes()).verdict(), Verdict::Works, "nobody asks for it");
    // Only the drive knows it.
    assert!(planned(both().unstated(0x2010, 1, Access::ReadOnly), &watched()).refusal().is_none());
    for (dictionary, object, found, key) in [
        (both().without(0x6079, 0), (0x6079, 0), "absent", "supply_voltage_v"),
        (both().without(0x2010, 1), (0x2010, 1), "absent", "temperature_c"),
        (both().typed(0x2010, 1, DataType::Unsigned32), (0x2010, 1), "of type u32", "temperature_c"),
        (both().with(0x2010, 1, Answer::Unstated, Access::WriteOnly), (0x2010, 1), "known only", "temperature_c"),
        // A drive's answer of another length.
        (both().with(0x2010, 1, Answer::NotANumber, Access::Unknown), (0x2010, 1), "no number", "temperature_c"),
        (both().with(0x6079, 0, Answer::Refused(0x0800_0000), Access::Unknown), (0x6079, 0), "refused", "supply"),
    ] {
        let refused = *planned(dictionary, &watched()).refusal().expect(found);
        assert_eq!((refused.question, refused.object), (Question::Readings, Address::new(object.0, object.1)));
        assert!(refused.found.to_string().starts_with(found), "{refused}");
        let (wanted, remedy) = (refused.wanted.to_string(), refused.remedy.to_string());
        assert!(wanted.starts_with("readable, of type "), "{wanted}");
        assert!(remedy.contains(&format!("leave drive.{key}")), "{remedy}");
    }
}

#[test]
fn the_mark_must_be_writable_with_its_value() {
    let holds = || drive().rw(0x6081, 0, 0).typed(0x6081, 0, DataType::Unsigned16);
    let works = planned(holds(), &marked());
    assert_eq!(works.verdict(), Verdict::Works, "{:#?}", works.notes().collect::<Vec<_>>());
    assert!(of_index(&written(&works), &["6081"]).is_empty(), "a start writes no mark");
    for (dictionary, found) in [
        (drive(), "absent"),
        (drive().ro(0x6081, 0, 0), "0"),
        (drive().with(0x6081, 0, Answer::Unstated, Access::WriteOnly), "known only"),
        (holds().limited(0x6081, 0, 0, 299), "0"),
        (holds().typed(0x6081, 0, DataType::Unsigned32), "of type u32"),
    ] {
        let refused = *planned(dictionary, &marked()).refusal().expect(found);
        assert_eq!((refused.question, refused.object), (Question::PowerMarker, Address::new(0x6081, 0)));
        assert!(refused.found.to_string().starts_with(found), "{refused}");
        assert!(refused.wanted.to_string().ends_with("of type u16"), "{refused}");
        assert!(refused.remedy.to_string().contains("encoder.power_marker"), "{refused}");
    }
}

/// A file says what a drive has after its power was lost; a drive on the bus may have been marked before.
#[test]
fn the_mark_is_another_value_than_at_power_up() {
    let reads_so = || drive().rw(0x6081, 0, 300);
    assert!(planned(reads_so(), &marked()).refusal().is_none());
    let refused = *planned_from_file(reads_so(), &marked()).refusal().unwrap();
    assert_eq!((refused.question, refused.object), (Question::PowerMarker, Address::new(0x6081, 0)));
    assert!(refused.to_string().contains("300 (12Ch), expected another value at power-up"), "{refused}");
    assert_eq!(refused.remedy.to_string(), "another encoder.power_marker.value");
    for dictionary in [drive().rw(0x6081, 0, 299), drive().unstated(0x6081, 0, Access::ReadWrite)] {
        assert!(planned_from_file(dictionary, &marked()).refusal().is_none());
    }
}

#[test]
fn the_mark_is_in_an_object_that_nobody_uses() {
    let marker = Setting::new(Address::new(0x6072, 0), Value::Unsigned16(300));
    let drive_wanted = DriveConfiguration { power_marker: Some(marker), ..wishes() };
    let refused = *planned(drive().rw(0x6072, 0, 1000), &drive_wanted).refusal().unwrap();
    assert_eq!((refused.question, refused.object), (Question::PowerMarker, Address::new(0x6072, 0)));
    assert!(refused.wanted.to_string().contains("the drive acts on it"), "{refused}");
}
