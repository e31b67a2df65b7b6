//! Classic CAN data frames with 11-bit identifiers: all that the drives' protocol uses.

use embedded_can::{Id, StandardId};

/// A classic CAN data frame with an 11-bit identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    id: StandardId,
    len: u8,
    data: [u8; 8],
}

impl Frame {
    /// A frame with up to eight data bytes; `None` if there are more.
    pub fn new(id: StandardId, data: &[u8]) -> Option<Self> {
        let mut frame = Self { id, len: u8::try_from(data.len()).ok()?, data: [0; 8] };
        frame.data.get_mut(..data.len())?.copy_from_slice(data);
        Some(frame)
    }

    /// A frame with exactly these data bytes; more than eight do not compile.
    #[allow(clippy::as_conversions)] // `LENGTH` is at most 8, which the line above proves
    pub const fn with<const LENGTH: usize>(id: StandardId, bytes: [u8; LENGTH]) -> Self {
        const { assert!(LENGTH <= 8, "a classic CAN frame has at most eight data bytes") };
        let mut data = [0; 8];
        let (used, _) = data.split_at_mut(LENGTH);
        used.copy_from_slice(&bytes);
        Self { id, len: LENGTH as u8, data }
    }

    /// The identifier.
    pub const fn id(&self) -> StandardId {
        self.id
    }

    /// The data bytes.
    pub fn data(&self) -> &[u8] {
        self.data.get(..usize::from(self.len)).unwrap_or(&[])
    }
}

impl embedded_can::Frame for Frame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        match id.into() {
            Id::Standard(id) => Self::new(id, data),
            Id::Extended(_) => None,
        }
    }
    fn new_remote(_id: impl Into<Id>, _dlc: usize) -> Option<Self> {
        None
    }
    fn is_extended(&self) -> bool {
        false
    }
    fn is_remote_frame(&self) -> bool {
        false
    }
    fn id(&self) -> Id {
        Id::Standard(self.id)
    }
    fn dlc(&self) -> usize {
        usize::from(self.len)
    }
    fn data(&self) -> &[u8] {
        self.data()
    }
}
