//! What a drive remembers from one frame to the next.

use canopen_rs::{Address, ErrorRegister, MAX_STRING_LEN};
use heapless::Vec;
use uarm_io::frame::Frame;

/// PDOs each way.
pub const PDOS: usize = 4;
/// Entries of 1003h, the pre-defined error field.
pub const ERROR_HISTORY: u8 = 8;
const HISTORY_LENGTH: usize = 8;

/// Its errors.
#[derive(Clone, Debug, Default)]
pub struct Errors {
    /// 1001h.
    pub register: u8,
    /// The newest first.
    pub history: Vec<u16, HISTORY_LENGTH>,
}

impl Errors {
    /// Adds an error; the oldest of a full history goes.
    pub fn add(&mut self, code: u16, register: u8) {
        self.register |= register | ErrorRegister::GENERIC;
        if self.history.is_full() {
            self.history.pop();
        }
        // There is room.
        let _ = self.history.insert(0, code);
    }
}

/// What a TPDO was.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sent {
    /// SYNCs since it was last sent.
    pub syncs: i128,
    /// What it carried then.
    pub last: Option<Frame>,
}

/// A write in segments, not yet whole.
#[derive(Clone, Debug)]
pub struct Download {
    /// The object.
    pub address: Address,
    /// What has come of it.
    pub data: Vec<u8, MAX_STRING_LEN>,
    /// The toggle bit that the next segment must have.
    pub toggle: u8,
}
