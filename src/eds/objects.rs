//! A dictionary file answers for the drive that it describes.

use std::convert::Infallible;

use uarm_eds::{Address, Dictionary, Kind, Object as Described, Value};
use uarm_io::drive::objects::Object;
use uarm_io::drive::survey::{Access, Answer, Answered, ObjectSource, SourceKind};

/// The objects of a dictionary, at one node.
#[derive(Clone, Copy, Debug)]
pub struct DictionaryObjects<'a> {
    dictionary: &'a Dictionary,
    node: u8,
}

impl<'a> DictionaryObjects<'a> {
    /// Those of `dictionary` at `node`.
    pub const fn new(dictionary: &'a Dictionary, node: u8) -> Self {
        Self { dictionary, node }
    }
}

impl ObjectSource for DictionaryObjects<'_> {
    type Error = Infallible;

    fn ask(&mut self, object: &Object) -> Result<Answered, Infallible> {
        let described = self.dictionary.object(object.address());
        let answered = described.map(|described| answered(described, self.node));
        let identity = self.dictionary.identity(object.address()).map(|number| Answer::Number(number.into()));
        if let (Some(Answered { answer: Answer::Unstated, .. }), Some(answer)) = (answered, identity) {
            return Ok(Answered::by_drive(answer));
        }
        Ok(answered.unwrap_or_else(|| Answered::by_drive(Answer::Absent)))
    }

    fn kind(&self) -> SourceKind {
        SourceKind::DictionaryFile
    }
}

fn answered(object: &Described, node: u8) -> Answered {
    let (least, most) = if is_packed(object.address) { (None, None) } else { object.limits(node) };
    let whole = |number: Option<i128>| number.and_then(|number| i64::try_from(number).ok());
    let access = match (object.access.is_readable(), object.access.is_writable()) {
        (true, true) => Access::ReadWrite,
        (true, false) => Access::ReadOnly,
        (false, _) => Access::WriteOnly,
    };
    let data_type = match object.kind {
        Kind::Basic(data_type) => Some(data_type),
        Kind::Other(_) => None,
    };
    Answered { answer: answer(object, node), access, least: whole(least), most: whole(most), data_type }
}

fn answer(object: &Described, node: u8) -> Answer {
    match object.value(node) {
        Some(Value::Integer(0)) if is_placeholder(object) => Answer::Unstated,
        Some(Value::Integer(number)) => i64::try_from(number).map_or(Answer::NotANumber, Answer::Number),
        Some(Value::Real(_) | Value::Text(_)) => Answer::NotANumber,
        None => Answer::Unstated,
    }
}

/// An identity, a rating or a list of modes that cannot be written is never 0: where a dictionary says so, it does not know.
fn is_placeholder(object: &Described) -> bool {
    const NEVER_ZERO: [u16; 6] = [0x1000, 0x1018, 0x6075, 0x6076, 0x608F, 0x6502];
    NEVER_ZERO.contains(&object.address.index) && !object.access.is_writable()
}

/// Words of several fields have no order, whatever limits a dictionary sets: an entry of 1016h with a node in it is no larger
/// than one without, nor is an identifier that is switched off.
fn is_packed(address: Address) -> bool {
    match (address.index, address.subindex) {
        (0x1005 | 0x1014, 0) | (0x1400..=0x15FF | 0x1800..=0x19FF, 1) => true,
        (0x1016 | 0x1600..=0x17FF | 0x1A00..=0x1BFF, subindex) => subindex > 0,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use uarm_eds::DataType;
    use uarm_io::drive::objects;

    use super::*;

    fn ask(text: &str, object: &Object) -> Answered {
        let dictionary = Dictionary::parse("own.eds", text.as_bytes()).unwrap();
        let Ok(answered) = DictionaryObjects::new(&dictionary, 3).ask(object);
        answered
    }

    #[test]
    fn a_dictionary_answers_with_value_access_and_limits() {
        let text = "[6076]\nDataType=7\nAccessType=rww\nDefaultValue=1000\nLowLimit=1\nHighLimit=5000\n";
        let answered = ask(text, &objects::RATED_TORQUE);
        let expected = Answered {
            answer: Answer::Number(1000),
            access: Access::ReadWrite,
            least: Some(1),
            most: Some(5000),
            data_type: Some(DataType::Unsigned32),
        };
        assert_eq!(answered, expected);
        assert_eq!(ask(text, &objects::TARGET_TORQUE).answer, Answer::Absent);
    }

    #[test]
    fn what_only_the_drive_knows_is_unstated() {
        assert_eq!(ask("[6502]\nDataType=7\nAccessType=ro\n", &objects::SUPPORTED_MODES).answer, Answer::Unstated);
        let zero = "[6502]\nDataType=7\nAccessType=ro\nDefaultValue=0\n";
        assert_eq!(ask(zero, &objects::SUPPORTED_MODES).answer, Answer::Unstated);
        let writable = "[6076]\nDataType=7\nAccessType=rw\nDefaultValue=0\n";
        assert_eq!(ask(writable, &objects::RATED_TORQUE).answer, Answer::Number(0));
    }

    #[test]
    fn the_device_tells_the_maker_where_its_object_does_not() {
        let text = "[DeviceInfo]\nVendorNumber=0xFB\nProductNumber=0\n[1018sub1]\nDataType=7\nAccessType=ro\n\
                    [1018sub2]\nDataType=7\nAccessType=ro\nDefaultValue=0\n";
        assert_eq!(ask(text, &objects::VENDOR_ID).answer, Answer::Number(0xFB));
        assert_eq!(ask(text, &objects::PRODUCT_CODE).answer, Answer::Unstated);
        let own = "[DeviceInfo]\nVendorNumber=0xFB\n[1018sub1]\nDataType=7\nAccessType=ro\nDefaultValue=0x9A\n";
        assert_eq!(ask(own, &objects::VENDOR_ID).answer, Answer::Number(0x9A));
        assert_eq!(
            ask("[DeviceInfo]\nVendorNumber=1\n[1000]\nDataType=7\nAccessType=ro\n", &objects::VENDOR_ID).answer,
            Answer::Absent
        );
    }

    #[test]
    fn packed_words_have_no_limits() {
        let text = "[1016sub1]\nDataType=7\nAccessType=rw\nDefaultValue=0\nLowLimit=0\nHighLimit=65535\n";
        assert_eq!(ask(text, &objects::CONSUMER_HEARTBEAT_TIME).most, None);
    }
}
