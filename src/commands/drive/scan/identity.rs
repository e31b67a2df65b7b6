//! What a node says of itself.

use serde::Serialize;
use uarm_io::drive::cia402::Statusword;
use uarm_io::drive::objects::{self, Object};
use uarm_io::drive::sdo::{Bystander, SdoError};
use uarm_io::drive::{DataType, NodeId, Value};
use uarm_io::link::{Link, Received};
use uarm_io::time::Clock;

/// 1008h: the maker's name of the device. Longer ones than 32 characters are not read.
const DEVICE_NAME: Object = Object::new(0x1008, 0, DataType::VisibleString, "manufacturer device name");

/// What a node says of itself; what it does not have is absent.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Identity {
    /// 1000h.
    pub device_type: Option<u32>,
    /// 1018h:01.
    pub vendor: Option<u32>,
    /// 1018h:02.
    pub product: Option<u32>,
    /// 1018h:03.
    pub revision: Option<u32>,
    /// 1018h:04.
    pub serial: Option<u32>,
    /// 1008h.
    pub name: Option<String>,
    /// 1001h: the bits of present errors.
    pub error_register: Option<u8>,
    /// 6502h.
    pub supported_modes: Option<u32>,
    /// 6041h in words: the state of its power stage.
    pub power_state: Option<String>,
}

impl Identity {
    /// Asks `node`.
    ///
    /// # Errors
    /// [`SdoError::Link`]; [`SdoError::Timeout`] if it falls silent.
    pub fn ask<L: Link, C: Clock, O: FnMut(&Received)>(
        bus: &mut Bystander<'_, L, C, O>,
        node: NodeId,
    ) -> Result<Self, SdoError<L::Error>> {
        let mut number = |object: &Object| -> Result<Option<u32>, SdoError<L::Error>> {
            Ok(match bus.read_optional(node, object)? {
                Some(Value::Unsigned32(value)) => Some(value),
                _ => None,
            })
        };
        let mut identity = Self {
            device_type: number(&objects::DEVICE_TYPE)?,
            vendor: number(&objects::VENDOR_ID)?,
            product: number(&objects::PRODUCT_CODE)?,
            revision: number(&objects::REVISION_NUMBER)?,
            serial: number(&objects::SERIAL_NUMBER)?,
            ..Self::default()
        };
        if identity.is_drive() {
            identity.supported_modes = number(&objects::SUPPORTED_MODES)?;
            if let Some(Value::Unsigned16(bits)) = bus.read_optional(node, &objects::STATUSWORD)? {
                let state = Statusword::from_bits(bits).state();
                identity.power_state = Some(state.map_or_else(|| format!("{bits:04X}h"), |state| state.to_string()));
            }
        }
        if let Some(Value::Unsigned8(bits)) = bus.read_optional(node, &objects::ERROR_REGISTER)? {
            identity.error_register = Some(bits);
        }
        if let Some(Value::VisibleString(name)) = bus.read_optional(node, &DEVICE_NAME)? {
            identity.name = Some(String::from_utf8_lossy(name.as_bytes()).trim_end_matches('\0').to_owned());
        }
        Ok(identity)
    }

    /// True if its device profile is 402.
    pub fn is_drive(&self) -> bool {
        self.device_type.is_some_and(|device_type| device_type & 0xFFFF == u32::from(objects::DEVICE_PROFILE_CIA402))
    }
}
