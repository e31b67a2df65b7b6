//! Dictionaries with the traits of makers' files, each a few lines of our own.

use proptest::prelude::*;
use uarm_eds::{Access, Address, DataType, Dictionary, EdsError, Kind, Value};

fn parse(text: &str) -> Dictionary {
    Dictionary::parse("own.eds", text.as_bytes()).unwrap()
}

fn number(dictionary: &Dictionary, index: u16, subindex: u8) -> Option<i128> {
    dictionary.value(Address::new(index, subindex), 2)?.integer()
}

#[test]
fn sub_sections_are_found_in_any_spelling() {
    let dictionary = parse(
        "[1018]\nObjectType=0x9\nSubNumber=3\n\
         [1018sub0]\nObjectType=7\nDataType=0x0005\nAccessType=const\nDefaultValue=2\n\
         [1018Sub1]\nDataType=0x7\nAccessType=RO\nDefaultValue=0x9A\n\
         [1a00SUBA]\nDataType=0x07\nAccessType=rw\nDefaultValue=0x60410010\n",
    );
    assert_eq!(number(&dictionary, 0x1018, 0), Some(2));
    assert_eq!(number(&dictionary, 0x1018, 1), Some(0x9A));
    assert_eq!(number(&dictionary, 0x1A00, 10), Some(0x6041_0010));
    assert_eq!(dictionary.object(Address::new(0x1018, 0)).unwrap().access, Access::Constant);
    assert_eq!(dictionary.problems(), []);
    assert_eq!(dictionary.objects().count(), 3, "the record's head holds no value");
}

#[test]
fn a_dcfs_value_comes_before_the_default() {
    let dictionary = parse("[1017]\nDataType=6\nAccessType=rw\nDefaultValue=0\nParameterValue=100\n");
    assert_eq!(number(&dictionary, 0x1017, 0), Some(100));
    let dictionary = parse("[1017]\nDataType=6\nAccessType=rw\nDefaultValue=7\nParameterValue=\n");
    assert_eq!(number(&dictionary, 0x1017, 0), Some(7));
    let dictionary = parse("[1017]\nDataType=6\nAccessType=rw\n");
    assert_eq!(number(&dictionary, 0x1017, 0), None);
}

#[test]
fn compact_arrays_have_all_their_entries() {
    let dictionary = parse(
        "[1003]\nParameterName=Errors\nObjectType=8\nDataType=7\nAccessType=ro\nDefaultValue=5\nCompactSubObj=16\n\
         [1003Value]\nNrOfEntries=1\n3=0x10\n",
    );
    assert_eq!(number(&dictionary, 0x1003, 0), Some(16));
    assert_eq!(number(&dictionary, 0x1003, 16), Some(5));
    assert_eq!(number(&dictionary, 0x1003, 3), Some(16));
    assert!(dictionary.object(Address::new(0x1003, 17)).is_none());
    assert_eq!(dictionary.object(Address::new(0x1003, 16)).unwrap().name, "Errors16");
    assert_eq!(dictionary.problems(), []);
}

#[test]
fn compact_entries_have_names_of_their_own_and_none_are_none() {
    let dictionary = parse(
        "[2000]\nParameterName=Gain\nObjectType=8\nDataType=6\nAccessType=rw\nCompactSubObj=3\n\
         [2000Name]\nNrOfEntries=1\n2=Gain of velocity\n\
         [2001]\nObjectType=8\nSubNumber=2\nCompactSubObj=0\n\
         [2001sub0]\nDataType=5\nAccessType=ro\nDefaultValue=1\n[2001sub1]\nDataType=6\nAccessType=rw\nDefaultValue=9\n\
         [2002]\nObjectType=7\nDataType=6\nAccessType=rw\nDefaultValue=4\nCompactSubObj=0\n",
    );
    let name = |subindex| dictionary.object(Address::new(0x2000, subindex)).unwrap().name.clone();
    assert_eq!([name(1), name(2), name(3)], ["Gain1", "Gain of velocity", "Gain3"]);
    assert_eq!(number(&dictionary, 0x2001, 0), Some(1));
    assert_eq!(number(&dictionary, 0x2001, 1), Some(9));
    assert_eq!(number(&dictionary, 0x2002, 0), Some(4));
    assert_eq!(dictionary.problems(), []);
}

/// `CompactPDO=0x13`: identifier, transmission type and event timer of each PDO; RPDO 2 has sections of its own.
#[test]
fn compact_pdos_are_those_that_have_no_sections() {
    let dictionary = parse(
        "[DeviceInfo]\nCompactPDO=0x13\nNrOfRXPDO=6\nNrOfTXPDO=1\n\
         [1401]\nObjectType=9\nSubNumber=2\n[1401sub0]\nDataType=5\nAccessType=ro\nDefaultValue=1\n\
         [1401sub1]\nParameterName=own\nDataType=7\nAccessType=ro\nDefaultValue=0x333\n",
    );
    assert_eq!(dictionary.problems(), []);
    let there = |index, subindex| dictionary.object(Address::new(index, subindex)).is_some();
    // As node 2. The first four have the predefined identifiers; those behind are off.
    assert_eq!(number(&dictionary, 0x1400, 1), Some(0x202));
    assert_eq!(number(&dictionary, 0x1401, 1), Some(0x333), "as its own section has it");
    assert_eq!(number(&dictionary, 0x1402, 1), Some(0x402));
    assert_eq!(number(&dictionary, 0x1403, 1), Some(0x502));
    assert_eq!(number(&dictionary, 0x1404, 1), Some(0x8000_0000));
    assert_eq!(number(&dictionary, 0x1405, 1), Some(0x8000_0000));
    assert!(!there(0x1406, 1), "NrOfRXPDO counts the one with sections");
    assert_eq!(number(&dictionary, 0x1800, 1), Some(0x182));
    assert!(!there(0x1801, 1));
    // Bits 0, 1 and 4: sub-indices 1, 2 and 5.
    let subindices: Vec<u8> = (0..=7).filter(|subindex| there(0x1400, *subindex)).collect();
    assert_eq!(subindices, [0, 1, 2, 5]);
    assert_eq!(number(&dictionary, 0x1400, 0), Some(5), "the highest sub-index");
    let timer = dictionary.object(Address::new(0x1400, 5)).unwrap();
    assert_eq!((timer.kind, timer.access), (Kind::Basic(DataType::Unsigned16), Access::ReadWrite));
    assert!(!there(0x1401, 2), "nothing is added to a PDO's own sections");
    // Mappings of up to 64 objects that can be written; also that of the PDO whose own sections say nothing of it.
    for index in [0x1600, 0x1601, 0x1605, 0x1A00] {
        assert!(there(index, 0) && there(index, 64) && !there(index, 65), "{index:X}");
        let entry = dictionary.object(Address::new(index, 1)).unwrap();
        assert_eq!((entry.kind, entry.access), (Kind::Basic(DataType::Unsigned32), Access::ReadWrite));
        assert_eq!(number(&dictionary, index, 0), None, "what they carry is known only to the drive");
    }
    assert!(!there(0x1606, 0) && !there(0x1A01, 0));
}

#[test]
fn without_the_mask_there_are_no_compact_pdos_and_their_number_is_bounded() {
    let rest = "[1000]\nDataType=7\nAccessType=ro\n";
    let none = parse(&format!("[DeviceInfo]\nCompactPDO=0\nNrOfRXPDO=4\n{rest}"));
    assert_eq!(none.objects().count(), 1);
    let many = parse(&format!("[DeviceInfo]\nCompactPDO=1\nNrOfRXPDO=513\n{rest}"));
    assert_eq!(many.objects().count(), 1);
    let problems: Vec<String> = many.problems().iter().map(ToString::to_string).collect();
    assert_eq!(problems, ["own.eds, line 3, [DeviceInfo] nrofrxpdo: found \"513\", expected 0 to 512 PDOs"]);
}

#[test]
fn limits_and_access_are_as_stated() {
    let dictionary = parse(
        "[6060]\nDataType=2\nAccessType=rww\nPDOMapping=1\nLowLimit=-128\nHighLimit=10\n\
         [6071]\nDataType=3\nAccessType=rww\nLowLimit=0x8000\nHighLimit=0x7FFF\n\
         [6072]\nDataType=6\nAccessType=rw\nLowLimit=0\nHighLimit=0\n",
    );
    let mode = dictionary.object(Address::new(0x6060, 0)).unwrap();
    assert!(mode.mappable && mode.access.is_writable());
    assert!(mode.takes(10, 2) && !mode.takes(11, 2));
    let torque = dictionary.object(Address::new(0x6071, 0)).unwrap();
    assert_eq!(torque.limits(2), (Some(-32_768), Some(32_767)));
    assert_eq!(dictionary.object(Address::new(0x6072, 0)).unwrap().limits(2), (None, None));
}

#[test]
fn text_reals_and_domains_are_kept() {
    let dictionary = Dictionary::parse(
        "own.eds",
        b"[1008]\r\nParameterName=Ger\xE4tename\r\nDataType=0x0009\r\nAccessType=const\r\nDefaultValue=Servo 0x10\r\n\
          [2000]\r\nDataType=8\r\nAccessType=rwr\r\nDefaultValue=-2.5e-1\r\n[1F50]\r\nObjectType=2\r\n",
    )
    .unwrap();
    let name = dictionary.object(Address::new(0x1008, 0)).unwrap();
    assert_eq!(name.name, "Ger\u{e4}tename");
    assert_eq!(name.value(1), Some(Value::Text("Servo 0x10".into())));
    assert_eq!(dictionary.value(Address::new(0x2000, 0), 1), Some(Value::Real(-0.25)));
    assert_eq!(dictionary.object(Address::new(0x1F50, 0)).unwrap().kind, Kind::Basic(DataType::Domain));
}

#[test]
fn the_device_and_its_node_are_read() {
    let dictionary = parse(
        "[DeviceInfo]\nVendorName=Nobody\nVendorNumber=0x123\nProductName=Servo\n[DeviceComissioning]\nNodeID=0x05\n\
         [1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x192\n",
    );
    assert_eq!(dictionary.device().vendor_number, Some(0x123));
    assert_eq!(dictionary.device().product_name.as_deref(), Some("Servo"));
    assert_eq!(dictionary.node(), Some(5));
}

/// One bad value costs that value, not the file, and the message says all of it.
#[test]
fn what_cannot_be_read_is_named() {
    let dictionary = parse(
        "[6076]\nDataType=0x0007\nAccessType=rw\nDefaultValue=about 200\n[6077]\nDataType=3\nAccessType=readonly\n\
         [6078]\nAccessType=ro\n[6079]\nDataType=5\nAccessType=ro\nDefaultValue=300\n",
    );
    let problems: Vec<String> = dictionary.problems().iter().map(ToString::to_string).collect();
    assert_eq!(
        problems,
        [
            "own.eds, line 4, [6076] defaultvalue: found \"about 200\", expected a number: 10, 0xA or 012, with $NODEID+ before it \
             where it depends on the node",
            "own.eds, line 7, [6077] accesstype: found \"readonly\", expected ro, wo, rw, rwr, rww or const",
            "own.eds, line 8, [6078] datatype: found \"\", expected the index of a data type, such as 0x0007",
            "own.eds, line 13, [6079] defaultvalue: found \"300\", expected a number that the data type can hold",
        ]
    );
    assert!(dictionary.object(Address::new(0x6076, 0)).is_some());
    assert!(dictionary.object(Address::new(0x6077, 0)).is_none());
}

#[test]
fn another_file_is_refused() {
    let error = Dictionary::parse("robot.toml", b"[bus]\nperiod = 3\n").unwrap_err();
    assert!(matches!(error, EdsError::NoObjects { .. }));
    let error = Dictionary::parse("run.mcap", b"\x89MCAP0\r\n\0[1000]\nObjectType=7\n").unwrap_err();
    assert_eq!(error.to_string(), "run.mcap: not a text, expected an EDS or DCF file (CiA 306)");
    let error = Dictionary::parse("notes.txt", b"hello\n").unwrap_err();
    assert_eq!(
        error.to_string(),
        "notes.txt: found no object, expected an EDS or DCF file (CiA 306) with sections such as [1000]; \
         notes.txt, line 1, []: found \"hello\", expected key=value"
    );
    let compact: String =
        (0..=0xFFFF).map(|index| format!("[{index:04X}]\nDataType=5\nAccessType=ro\nCompactSubObj=254\n")).collect();
    assert!(matches!(Dictionary::parse("bomb.eds", compact.as_bytes()), Err(EdsError::TooManyObjects { .. })));
}

proptest! {
    #[test]
    fn any_bytes_are_read_without_a_panic(bytes in proptest::collection::vec(any::<u8>(), 0..2_000)) {
        let _ = Dictionary::parse("any", &bytes);
    }

    /// Lines that look like a dictionary's, with any values.
    #[test]
    fn any_values_are_read_without_a_panic(
        lines in proptest::collection::vec(
            prop_oneof!["\\[DeviceInfo\\]", "\\[[0-9A-F]{4}(sub|Sub|Value|Name)?[0-9A-F]{0,2}\\]", "(DataType|AccessType|DefaultValue|LowLimit|CompactSubObj|CompactPDO|NrOfRXPDO|ObjectType)=.{0,12}"],
            0..60,
        ),
        node in any::<u8>(),
    ) {
        if let Ok(dictionary) = Dictionary::parse("any", lines.join("\n").as_bytes()) {
            for object in dictionary.objects() {
                let _ = (object.value(node), object.limits(node), object.takes(0, node));
                let _ = object.value(node).and_then(|value| value.to_wire(object.kind));
            }
        }
    }
}
