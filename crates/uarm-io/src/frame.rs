//! Classic CAN data frames with 11-bit identifiers: all that the drives' protocols use.
//!
//! How many data bytes a frame holds is [`Frame::CAPACITY`] here and nowhere else: CAN FD would make it 64.

use embedded_can::{Id, StandardId};

/// A classic CAN data frame with an 11-bit identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    id: StandardId,
    len: u8,
    data: [u8; Self::CAPACITY],
}

impl Frame {
    /// The most data bytes: those of classic CAN.
    pub const CAPACITY: usize = 8;

    /// A frame with up to [`Frame::CAPACITY`] data bytes; `None` if there are more.
    pub fn new(id: StandardId, data: &[u8]) -> Option<Self> {
        let mut frame = Self { id, len: u8::try_from(data.len()).ok()?, data: [0; Self::CAPACITY] };
        frame.data.get_mut(..data.len())?.copy_from_slice(data);
        Some(frame)
    }

    /// A frame with exactly these data bytes; more than [`Frame::CAPACITY`] do not compile.
    #[allow(clippy::as_conversions)] // `LENGTH` is at most `CAPACITY`, far below 256
    pub const fn with<const LENGTH: usize>(id: StandardId, bytes: [u8; LENGTH]) -> Self {
        const { assert!(LENGTH <= Self::CAPACITY, "more data bytes than a frame has") };
        let mut data = [0; Self::CAPACITY];
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
