//! The EDS says of each object what the drive's dictionary says, and knows no other object.

mod support;

use canopen_rs::object_dictionary::AccessType;
use std::collections::BTreeSet;
use support::drives;
use uarm_eds::{Access, Address, Dictionary, Kind};
use uarm_io::drive::wire::DRIVE_EDS;
use uarm_sim::drive::{Mappable, OBJECTS};

/// Objects whose value differs from drive to drive: the EDS gives no default.
const DEVICE_SPECIFIC: [(u16, u8); 4] = [(0x6072, 0), (0x6075, 0), (0x6076, 0), (0x608F, 1)];

fn eds() -> Dictionary {
    Dictionary::parse("uarm-drive.eds", DRIVE_EDS.as_bytes()).unwrap()
}

/// The value of `key` in a section, as it stands.
fn key<'a>(section: &str, key: &str) -> Option<&'a str> {
    let (_, rest) = DRIVE_EDS.split_once(&format!("[{section}]\n"))?;
    let own = rest.split("\n[").next()?;
    own.lines().find_map(|line| line.strip_prefix(&format!("{key}=")))
}

fn number(text: &str) -> i64 {
    match text.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16).unwrap(),
        None => text.parse().unwrap(),
    }
}

#[test]
fn both_know_the_same_objects() {
    let eds = eds();
    assert_eq!(eds.problems(), []);
    let described: BTreeSet<_> = eds.objects().map(|object| object.address).collect();
    let built: BTreeSet<_> = OBJECTS.iter().map(|object| object.address).collect();
    assert_eq!(described, built);
}

#[test]
fn types_access_and_mapping_agree() {
    for described in eds().objects() {
        let address: Address = described.address;
        let object = OBJECTS.iter().find(|object| object.address == address).unwrap();
        let value = (object.default)(&drives()[0]);
        assert_eq!(described.kind, Kind::Basic(value.data_type()), "{address:?}");
        let access = match (object.access, object.mappable) {
            (AccessType::Const, _) => Access::Constant,
            (AccessType::Ro, _) => Access::ReadOnly,
            (AccessType::Rw, Mappable::Receive) => Access::ReadWriteOutput,
            (AccessType::Rw, _) => Access::ReadWrite,
            (AccessType::Wo, _) => Access::WriteOnly,
        };
        assert_eq!(described.access, access, "{address:?}");
        assert_eq!(described.mappable, object.mappable != Mappable::No, "{address:?}");
    }
}

#[test]
fn defaults_agree_for_each_node() {
    for drive in drives() {
        for described in eds().objects() {
            let address = described.address;
            let object = OBJECTS.iter().find(|object| object.address == address).unwrap();
            let Some(value) = described.value(drive.node().raw()) else {
                assert!(DEVICE_SPECIFIC.contains(&(address.index, address.subindex)), "{address:?}");
                continue;
            };
            assert_eq!(value.to_wire(described.kind), Some((object.default)(&drive)), "{address:?}");
        }
    }
}

#[test]
fn lists_and_counts_are_right() {
    let mut listed = BTreeSet::new();
    for list in ["MandatoryObjects", "OptionalObjects", "ManufacturerObjects"] {
        let count = number(key(list, "SupportedObjects").unwrap());
        assert_eq!(key(list, &(count + 1).to_string()), None, "{list}");
        listed.extend((1..=count).map(|entry| number(key(list, &entry.to_string()).unwrap())));
    }
    let indices: BTreeSet<_> = OBJECTS.iter().map(|object| i64::from(object.address.index)).collect();
    assert_eq!(listed, indices);
    for index in indices {
        let entries = OBJECTS.iter().filter(|object| i64::from(object.address.index) == index).count() as i64;
        let subs = key(&format!("{index:04X}"), "SubNumber").map_or(1, number);
        assert_eq!(subs, entries, "{index:04X}");
    }
}
