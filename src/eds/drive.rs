//! A dictionary file becomes the dictionary of an emulated drive.

use uarm_eds::{Access, DataType, Dictionary, Kind, Object};
use uarm_io::drive::Value;
use uarm_sim::drive::{AccessType, DriveDictionary, DriveObject, DriveParameters, Mappable};

/// The objects of `dictionary`, as an emulated drive of these parameters has them at power-on.
pub fn maker_dictionary(dictionary: &Dictionary, drive: &DriveParameters) -> DriveDictionary {
    let node = drive.node().raw();
    let identity = |object: &Object| dictionary.identity(object.address).map(Value::Unsigned32);
    let objects = dictionary.objects().map(|object| {
        let described = drive_object(object, node);
        let is_known = object.value(node).and_then(|value| value.integer()).is_some_and(|number| number != 0);
        let value = if is_known { described.value } else { identity(object).or(described.value) };
        DriveObject { value, ..described }
    });
    DriveDictionary::of_maker(drive, objects)
}

fn drive_object(object: &Object, node: u8) -> DriveObject {
    let data_type = match object.kind {
        Kind::Basic(data_type) => data_type,
        // Numbers of other widths, times and structures: bytes that nobody asks for.
        Kind::Other(_) => DataType::OctetString,
    };
    let (low, high) = object.limits(node);
    DriveObject {
        address: object.address,
        data_type,
        access: access(object.access),
        mappable: mappable(object),
        value: value(object, node),
        low,
        high,
    }
}

/// What does not fit the protocol stack, such as a long text, is left to the emulation, which makes it empty.
fn value(object: &Object, node: u8) -> Option<Value> {
    object.value(node)?.to_wire(object.kind)
}

const fn access(access: Access) -> AccessType {
    match access {
        Access::Constant => AccessType::Const,
        Access::ReadOnly => AccessType::Ro,
        Access::WriteOnly => AccessType::Wo,
        Access::ReadWrite | Access::ReadWriteInput | Access::ReadWriteOutput => AccessType::Rw,
    }
}

/// CiA 306: `rww` may be received, `rwr` and `ro` may be sent; `rw` says nothing, and is taken for both.
const fn mappable(object: &Object) -> Mappable {
    match (object.mappable, object.access) {
        (false, _) => Mappable::No,
        (true, Access::ReadWrite | Access::ReadWriteOutput | Access::WriteOnly) => Mappable::Receive,
        (true, Access::Constant | Access::ReadOnly | Access::ReadWriteInput) => Mappable::Transmit,
    }
}
