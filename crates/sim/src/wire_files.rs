//! The files that describe the wire to others: to be attached to logs, and loaded into bus analysers.

/// Electronic data sheet (CiA 306) of the emulated drive, `docs/wire/uarm-drive.eds`.
pub const DRIVE_EDS: &str = include_str!("../../../docs/wire/uarm-drive.eds");

/// The frames as a Vector CAN database, `docs/wire/uarm.dbc`.
pub const WIRE_DBC: &str = include_str!("../../../docs/wire/uarm.dbc");
