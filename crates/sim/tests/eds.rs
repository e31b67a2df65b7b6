//! The EDS says of each object what the drive's dictionary says, and knows no other object.

mod support;

use canopen_rs::object_dictionary::AccessType;
use canopen_rs::{Address, Value};
use ini::{Ini, Properties};
use std::collections::BTreeSet;
use support::drives;
use uarm_io::drive::wire::DRIVE_EDS;
use uarm_sim::drive::{Mappable, OBJECTS};

/// Objects whose value differs from drive to drive: the EDS gives no default.
const DEVICE_SPECIFIC: [(u16, u8); 4] = [(0x6072, 0), (0x6075, 0), (0x6076, 0), (0x608F, 1)];

fn eds() -> Ini {
    Ini::load_from_str(DRIVE_EDS).unwrap()
}

fn number(text: &str) -> i64 {
    match text.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16).unwrap(),
        None => text.parse().unwrap(),
    }
}

/// Index and sub-index of a section, if it describes an object that holds a value.
fn address(section: &str, properties: &Properties) -> Option<Address> {
    let (index, subindex) = section.split_once("sub").unwrap_or((section, "0"));
    let index = u16::from_str_radix(index, 16).ok().filter(|_| index.len() == 4)?;
    let holds_value = properties.get("ObjectType") == Some("0x7");
    holds_value.then(|| Address::new(index, u8::from_str_radix(subindex, 16).unwrap()))
}

/// Every section of the EDS that describes an object with a value.
fn described(eds: &Ini) -> Vec<(Address, &Properties)> {
    let sections = eds.iter().filter_map(|(name, properties)| Some((address(name?, properties)?, properties)));
    sections.collect()
}

fn as_number(value: &Value) -> i64 {
    match *value {
        Value::Integer8(value) => value.into(),
        Value::Integer16(value) => value.into(),
        Value::Integer32(value) => value.into(),
        Value::Unsigned8(value) => value.into(),
        Value::Unsigned16(value) => value.into(),
        Value::Unsigned32(value) => value.into(),
        _ => panic!("{value:?} is no number"),
    }
}

#[test]
fn both_know_the_same_objects() {
    let eds = eds();
    let described: BTreeSet<_> = described(&eds).into_iter().map(|(address, _)| address).collect();
    let built: BTreeSet<_> = OBJECTS.iter().map(|object| object.address).collect();
    assert_eq!(described, built);
}

#[test]
fn types_access_and_mapping_agree() {
    let eds = eds();
    for (address, properties) in described(&eds) {
        let object = OBJECTS.iter().find(|object| object.address == address).unwrap();
        let value = (object.default)(&drives()[0]);
        let kind = number(properties.get("DataType").unwrap());
        assert_eq!(kind, i64::from(value.data_type().index()), "{address:?}");
        // CiA 306: rww is "read and write, and the process may write it", that is, an RPDO.
        let access = match (object.access, object.mappable) {
            (AccessType::Const, _) => "const",
            (AccessType::Ro, _) => "ro",
            (AccessType::Rw, Mappable::Receive) => "rww",
            (AccessType::Rw, _) => "rw",
            (AccessType::Wo, _) => "wo",
        };
        assert_eq!(properties.get("AccessType"), Some(access), "{address:?}");
        let mappable = if object.mappable == Mappable::No { "0" } else { "1" };
        assert_eq!(properties.get("PDOMapping"), Some(mappable), "{address:?}");
    }
}

#[test]
fn defaults_agree_for_each_node() {
    let eds = eds();
    for drive in drives() {
        for (address, properties) in described(&eds) {
            let object = OBJECTS.iter().find(|object| object.address == address).unwrap();
            let value = (object.default)(&drive);
            let Some(default) = properties.get("DefaultValue") else {
                assert!(DEVICE_SPECIFIC.contains(&(address.index, address.subindex)), "{address:?}");
                continue;
            };
            match value {
                Value::VisibleString(text) => assert_eq!(text.as_str(), Some(default)),
                _ => {
                    let (node, rest) = match default.strip_prefix("$NODEID+") {
                        Some(rest) => (i64::from(drive.node().raw()), rest),
                        None => (0, default),
                    };
                    assert_eq!(as_number(&value), node + number(rest), "{address:?}");
                }
            }
        }
    }
}

#[test]
fn lists_and_counts_are_right() {
    let eds = eds();
    let mut listed = BTreeSet::new();
    for list in ["MandatoryObjects", "OptionalObjects", "ManufacturerObjects"] {
        let section = eds.section(Some(list)).unwrap();
        let count = number(section.get("SupportedObjects").unwrap());
        assert_eq!(section.iter().count() as i64, count + 1, "{list}");
        listed.extend((1..=count).map(|entry| number(section.get(entry.to_string()).unwrap())));
    }
    let indices: BTreeSet<_> = OBJECTS.iter().map(|object| i64::from(object.address.index)).collect();
    assert_eq!(listed, indices);
    for index in indices {
        let section = eds.section(Some(format!("{index:04X}"))).unwrap();
        let entries = OBJECTS.iter().filter(|object| i64::from(object.address.index) == index).count() as i64;
        let subs = section.get("SubNumber").map_or(1, number);
        assert_eq!(subs, entries, "{index:04X}");
    }
}
