//! What a drive's object dictionary says, asked before anything is written.
//!
//! The same questions go to a drive, over SDO, and to a dictionary file; [`ObjectSource`] is either of them. What the
//! answers mean for a robot is [`crate::drive::plan`]'s business.

use super::identity::DriveIdentity;
use super::objects::{self, Object};
use super::pdo_objects::{PdoKind, PdoNumber};
use super::words::type_name;
use canopen_rs::{Address, DataType, Value};
use core::fmt;

/// What came of asking for an object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Answer {
    /// A whole number.
    Number(i64),
    /// The object is there and holds no whole number: a text, a domain, a floating-point number, or more than 63 bits.
    NotANumber,
    /// The object is there, and not of the type that is wanted, but of this one.
    OtherType(DataType),
    /// The object is there; its value is known only to the drive. Dictionary files answer so.
    Unstated,
    /// There is no such object (SDO aborts 0602 0000h and 0609 0011h).
    #[default]
    Absent,
    /// The drive refused for another reason: the SDO abort code.
    Refused(u32),
}

impl Answer {
    /// The answer that a value is.
    pub fn of(value: Value) -> Self {
        match value {
            Value::Boolean(value) => Self::Number(value.into()),
            Value::Integer8(value) => Self::Number(value.into()),
            Value::Integer16(value) => Self::Number(value.into()),
            Value::Integer32(value) => Self::Number(value.into()),
            Value::Integer64(value) => Self::Number(value),
            Value::Unsigned8(value) => Self::Number(value.into()),
            Value::Unsigned16(value) => Self::Number(value.into()),
            Value::Unsigned32(value) => Self::Number(value.into()),
            Value::Unsigned64(value) => i64::try_from(value).map_or(Self::NotANumber, Self::Number),
            _ => Self::NotANumber,
        }
    }

    /// The number, if it is one.
    pub const fn number(self) -> Option<i64> {
        match self {
            Self::Number(value) => Some(value),
            _ => None,
        }
    }

    /// True unless the object is absent.
    pub const fn is_there(self) -> bool {
        !matches!(self, Self::Absent)
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // Identifiers and bit fields are looked up in hexadecimal, small numbers are not.
            Self::Number(value) if *value > 9 => write!(formatter, "{value} ({value:X}h)"),
            Self::Number(value) => value.fmt(formatter),
            Self::NotANumber => formatter.write_str("no number"),
            Self::OtherType(data_type) => write!(formatter, "of type {}", type_name(*data_type)),
            Self::Unstated => formatter.write_str("known only to the drive"),
            Self::Absent => formatter.write_str("absent"),
            Self::Refused(code) => {
                write!(formatter, "refused: {} ({code:08X}h)", super::words::abort_code(*code))
            }
        }
    }
}

/// What may be done with an object, as far as it is known beforehand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Access {
    /// Not known: a drive tells only when it is written to.
    #[default]
    Unknown,
    /// It can be read.
    ReadOnly,
    /// It can be written.
    WriteOnly,
    /// Both.
    ReadWrite,
}

impl Access {
    /// False if it is known that the object cannot be written.
    pub const fn may_write(self) -> bool {
        !matches!(self, Self::ReadOnly)
    }

    /// False if it is known that the object cannot be read.
    pub const fn may_read(self) -> bool {
        !matches!(self, Self::WriteOnly)
    }
}

/// What is known of one object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Answered {
    /// Its value.
    pub answer: Answer,
    /// What may be done with it.
    pub access: Access,
    /// Its least value, where that is stated.
    pub least: Option<i64>,
    /// Its greatest value, where that is stated.
    pub most: Option<i64>,
    /// Its type, where that is stated: a dictionary file does, a drive does not.
    pub data_type: Option<DataType>,
}

impl Answered {
    /// An answer of which nothing else is known: that of a drive.
    pub const fn by_drive(answer: Answer) -> Self {
        Self { answer, access: Access::Unknown, least: None, most: None, data_type: None }
    }

    /// False if it is known that `value` cannot be written.
    pub fn may_become(&self, value: i64) -> bool {
        self.answer.is_there()
            && self.access.may_write()
            && self.least.is_none_or(|least| least <= value)
            && self.most.is_none_or(|most| value <= most)
    }
}

/// What answers for the objects of one drive: the drive, or its dictionary file.
pub trait ObjectSource {
    /// Why there is no answer at all, such as a link that failed; an object that is absent or refused is an answer.
    type Error;

    /// What is known of `object`.
    ///
    /// # Errors
    /// If nothing can be said, not even that the object is absent.
    fn ask(&mut self, object: &Object) -> Result<Answered, Self::Error>;

    /// Which of the two it is.
    fn kind(&self) -> SourceKind {
        SourceKind::Drive
    }
}

/// What answers for a drive's objects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SourceKind {
    /// The drive, over SDO: values are those of now. PDOs are looked for until [`LONGEST_GAP`] numbers in a row are absent, and
    /// those that the robot file names: all 512 of both directions would take a slow drive a minute.
    #[default]
    Drive,
    /// A dictionary file: values are those at power-up. It answers at once, and is asked for all 512 PDOs.
    DictionaryFile,
}

/// Objects of a mapping that are looked at; no mapping of this master is longer.
pub const MAPPING_ENTRIES: usize = 4;

/// One PDO of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PdoRecord {
    /// Its number, from 1 on.
    pub number: PdoNumber,
    /// Sub-index 1: its identifier and whether it is on.
    pub identifier: Answered,
    /// Sub-index 2: its transmission type.
    pub transmission: Answered,
    /// Sub-index 5: of an RPDO, after how many ms its absence is noticed.
    pub event_timer: Answered,
    /// How many objects it carries.
    pub count: Answered,
    /// The first of them.
    pub entries: [Answer; MAPPING_ENTRIES],
    /// What may be done with them.
    pub entry_access: Access,
    /// Whether the drive itself would be asked for it.
    pub reach: Reach,
}

/// Whether a PDO is found when the drive is asked for its PDOs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// It is.
    Asked,
    /// It stands behind [`LONGEST_GAP`] numbers without a PDO, and the robot file does not name it: only a dictionary file tells of
    /// it.
    BehindGap,
}

/// Bit 31 of a PDO's identifier: it is off.
pub const PDO_OFF: i64 = 1 << 31;
/// Bit 30 of a TPDO's identifier: no remote frames. Drives set it by themselves.
pub const PDO_NO_REMOTE_FRAME: i64 = 1 << 30;
/// Bit 29 of an identifier: it has 29 bits.
pub const PDO_EXTENDED: i64 = 1 << 29;
/// The 11 bits of an identifier.
pub const PDO_IDENTIFIER: i64 = 0x7FF;

impl PdoRecord {
    /// True if it is known to be off.
    pub fn is_off(&self) -> bool {
        self.identifier.answer.number().is_some_and(|identifier| identifier & PDO_OFF != 0)
    }

    /// True if it carries exactly `mapping`, in this order.
    pub fn carries(&self, mapping: &[u32]) -> bool {
        let as_many = self.count.answer.number() == i64::try_from(mapping.len()).ok();
        as_many && mapping.iter().zip(&self.entries).all(|(wanted, found)| *found == Answer::Number((*wanted).into()))
    }
}

/// PDOs of each direction that a survey can hold; drives have four to eight.
pub const MOST_PDOS: usize = 32;
/// PDOs up to this number are kept whether they are on or off, those beyond only if they are on.
const ALWAYS_KEPT: u16 = 16;
/// Behind so many numbers without a PDO a drive is asked for no more.
pub const LONGEST_GAP: u32 = 8;

/// The objects that are asked for, beside those of PDOs and of the robot file.
const ASKED: &[&Object] = &[
    &objects::DEVICE_TYPE,
    &objects::VENDOR_ID,
    &objects::PRODUCT_CODE,
    &objects::REVISION_NUMBER,
    &objects::SERIAL_NUMBER,
    &objects::SUPPORTED_MODES,
    &objects::MODE_OF_OPERATION,
    &objects::MODE_OF_OPERATION_DISPLAY,
    &objects::CONTROLWORD,
    &objects::STATUSWORD,
    &objects::TARGET_TORQUE,
    &objects::MAXIMUM_TORQUE,
    &objects::MAXIMUM_CURRENT,
    &objects::RATED_CURRENT,
    &objects::RATED_TORQUE,
    &objects::TORQUE_ACTUAL,
    &objects::POSITION_ACTUAL,
    &objects::POLARITY,
    &objects::ENCODER_INCREMENTS,
    &objects::ENCODER_REVOLUTIONS,
    &objects::GEAR_MOTOR_REVOLUTIONS,
    &objects::GEAR_SHAFT_REVOLUTIONS,
    &objects::FEED,
    &objects::FEED_SHAFT_REVOLUTIONS,
    &objects::INTERPOLATION_TIME_VALUE,
    &objects::INTERPOLATION_TIME_EXPONENT,
    &objects::SYNC_IDENTIFIER,
    &objects::SYNC_COUNTER_OVERFLOW,
    &objects::EMERGENCY_IDENTIFIER,
    &objects::CONSUMER_HEARTBEAT_TIME,
    &objects::PRODUCER_HEARTBEAT_TIME,
    &objects::ABORT_CONNECTION_OPTION,
    &objects::QUICK_STOP_OPTION,
    &objects::HOMING_METHOD,
    &objects::DC_LINK_VOLTAGE,
];

/// What a whole number can be, in the order in which a drive is asked.
const WHOLE_NUMBERS: &[DataType] = &[DataType::Unsigned32, DataType::Unsigned16, DataType::Unsigned8];

/// Objects that a survey can hold: those above, and as many of a robot file.
const MOST_OBJECTS: usize = 112;

/// What was learned of one drive.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Survey {
    objects: heapless::Vec<(Address, Answered), MOST_OBJECTS>,
    rpdos: Pdos,
    tpdos: Pdos,
    room: Room,
    source: SourceKind,
}

type Pdos = heapless::Vec<PdoRecord, MOST_PDOS>;

/// Whether a survey could hold all PDOs that are on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Room {
    /// It could.
    #[default]
    Enough,
    /// This one, and those behind it, were not looked at.
    Exceeded(PdoKind, PdoNumber),
}

impl Survey {
    /// Asks for everything that a plan looks at, and for `others` and `is_named`: objects and PDOs that a robot file names. An object
    /// without a type is a whole number of a length that only the drive knows.
    ///
    /// # Errors
    /// That of the source.
    pub fn of<S: ObjectSource>(
        source: &mut S,
        others: impl IntoIterator<Item = (Address, Option<DataType>)>,
        is_named: impl Fn(PdoKind, PdoNumber) -> bool,
    ) -> Result<Self, S::Error> {
        let mut survey = Self { source: source.kind(), ..Self::default() };
        for object in ASKED {
            survey.ask(source, object.address(), &[object.data_type])?;
        }
        for (address, data_type) in others {
            survey.ask(source, address, data_type.as_ref().map_or(WHOLE_NUMBERS, core::slice::from_ref))?;
        }
        let (rpdos, room) = pdos(source, PdoKind::Receive, &is_named)?;
        let (tpdos, room_of_tpdos) = pdos(source, PdoKind::Transmit, &is_named)?;
        let room = if room == Room::Enough { room_of_tpdos } else { room };
        Ok(Self { rpdos, tpdos, room, ..survey })
    }

    /// Asks for an object of one of these types.
    fn ask<S: ObjectSource>(&mut self, source: &mut S, address: Address, types: &[DataType]) -> Result<(), S::Error> {
        if self.objects.iter().any(|(known, _)| *known == address) {
            return Ok(());
        }
        let mut answered = Answered::default();
        for data_type in types {
            answered = source.ask(&Object::new(address.index, address.subindex, *data_type, ""))?;
            if answered.answer != Answer::NotANumber {
                break;
            }
        }
        // What does not fit is looked at as absent; there is room for all that a robot file can name.
        let _ = self.objects.push((address, answered));
        Ok(())
    }

    /// What is known of the object at `address`; absent if it was not asked for.
    pub fn at(&self, address: Address) -> Answered {
        self.objects.iter().find(|(other, _)| *other == address).map(|(_, answered)| *answered).unwrap_or_default()
    }

    /// The same, where the object at `address` is known to be read-only.
    #[must_use]
    pub fn with_read_only(mut self, address: Address) -> Self {
        if let Some((_, answered)) = self.objects.iter_mut().find(|(other, _)| *other == address) {
            answered.access = Access::ReadOnly;
        }
        for (kind, pdos) in [(PdoKind::Receive, &mut self.rpdos), (PdoKind::Transmit, &mut self.tpdos)] {
            for pdo in pdos.iter_mut() {
                let known = [
                    (kind.identifier(pdo.number), &mut pdo.identifier.access),
                    (kind.transmission(pdo.number), &mut pdo.transmission.access),
                    (kind.event_timer(pdo.number), &mut pdo.event_timer.access),
                    (kind.mapped_objects(pdo.number), &mut pdo.count.access),
                ];
                for (object, access) in known {
                    if object.address() == address {
                        *access = Access::ReadOnly;
                    }
                }
                if (1..)
                    .take(MAPPING_ENTRIES)
                    .any(|subindex| kind.mapped_object(pdo.number, subindex).address() == address)
                {
                    pdo.entry_access = Access::ReadOnly;
                }
            }
        }
        self
    }

    /// What is known of `object`.
    pub fn get(&self, object: &Object) -> Answered {
        self.at(object.address())
    }

    /// What the drive says of itself.
    pub fn identity(&self) -> DriveIdentity {
        let number = |object: &Object| self.number(object).and_then(|number| u32::try_from(number).ok());
        DriveIdentity {
            vendor: number(&objects::VENDOR_ID),
            product: number(&objects::PRODUCT_CODE),
            revision: number(&objects::REVISION_NUMBER),
            serial: number(&objects::SERIAL_NUMBER),
        }
    }

    /// The number that `object` holds.
    pub fn number(&self, object: &Object) -> Option<i64> {
        self.get(object).answer.number()
    }

    /// What answered.
    pub const fn source(&self) -> SourceKind {
        self.source
    }

    /// Whether all PDOs that are on were looked at.
    pub const fn room(&self) -> Room {
        self.room
    }

    /// The PDOs of one kind that the drive has; of those beyond the sixteenth, the ones that are on.
    pub fn pdos(&self, kind: PdoKind) -> &[PdoRecord] {
        match kind {
            PdoKind::Receive => &self.rpdos,
            PdoKind::Transmit => &self.tpdos,
        }
    }

    /// One PDO.
    pub fn pdo(&self, kind: PdoKind, number: PdoNumber) -> Option<&PdoRecord> {
        self.pdos(kind).iter().find(|pdo| pdo.number == number)
    }
}

/// All PDOs of one kind, and whether there was room for them. Those that the robot file names are asked for wherever they are.
fn pdos<S: ObjectSource>(
    source: &mut S,
    kind: PdoKind,
    is_named: &impl Fn(PdoKind, PdoNumber) -> bool,
) -> Result<(Pdos, Room), S::Error> {
    let (mut found, mut gap, mut reach) = (Pdos::new(), 0, Reach::Asked);
    for number in PdoNumber::all() {
        let is_named = is_named(kind, number);
        if reach == Reach::BehindGap && !is_named && source.kind() == SourceKind::Drive {
            continue;
        }
        let identifier = source.ask(&kind.identifier(number))?;
        if !identifier.answer.is_there() {
            gap += 1;
            if gap == LONGEST_GAP {
                reach = Reach::BehindGap;
            }
            continue;
        }
        gap = 0;
        let is_off = identifier.answer.number().is_some_and(|identifier| identifier & PDO_OFF != 0);
        if is_off && !is_named && number.get() > ALWAYS_KEPT {
            continue;
        }
        if found.is_full() {
            return Ok((found, Room::Exceeded(kind, number)));
        }
        let reach = if is_named { Reach::Asked } else { reach };
        let _ = found.push(PdoRecord { reach, ..pdo(source, kind, number, identifier)? });
    }
    Ok((found, Room::Enough))
}

fn pdo<S: ObjectSource>(
    source: &mut S,
    kind: PdoKind,
    number: PdoNumber,
    identifier: Answered,
) -> Result<PdoRecord, S::Error> {
    let transmission = source.ask(&kind.transmission(number))?;
    let event_timer = source.ask(&kind.event_timer(number))?;
    let count = source.ask(&kind.mapped_objects(number))?;
    let carried = count.answer.number().and_then(|count| usize::try_from(count).ok()).unwrap_or(MAPPING_ENTRIES);
    let mut entries = [Answer::Absent; MAPPING_ENTRIES];
    let mut entry_access = Access::Unknown;
    for (entry, subindex) in entries.iter_mut().zip(1_u8..).take(carried.max(1)) {
        let answered = source.ask(&kind.mapped_object(number, subindex))?;
        (*entry, entry_access) = (answered.answer, answered.access);
    }
    let reach = Reach::Asked;
    Ok(PdoRecord { number, identifier, transmission, event_timer, count, entries, entry_access, reach })
}
