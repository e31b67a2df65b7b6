//! Command specifiers of SDO responses (CiA 301).

/// The upper three bits of the first byte, which hold the specifier.
pub const SPECIFIER: u8 = 0xE0;
/// The answer to an upload.
pub const UPLOAD_RESPONSE: u8 = 0x40;
/// The answer to a download.
pub const DOWNLOAD_RESPONSE: u8 = 0x60;
/// An abort.
pub const ABORT: u8 = 0x80;
