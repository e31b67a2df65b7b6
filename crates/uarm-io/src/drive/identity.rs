//! What a drive says of itself.

use core::fmt;

/// Maker, kind, version and number of a drive, as far as it says them: 1018h of a CANopen drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriveIdentity {
    /// 1018h:01, the maker by its CiA number.
    pub vendor: Option<u32>,
    /// 1018h:02.
    pub product: Option<u32>,
    /// 1018h:03.
    pub revision: Option<u32>,
    /// 1018h:04.
    pub serial: Option<u32>,
}

impl fmt::Display for DriveIdentity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let codes = [("vendor", self.vendor), ("product", self.product), ("revision", self.revision)];
        let mut separator = "";
        for (name, code) in codes.into_iter().filter_map(|(name, code)| Some((name, code?))) {
            write!(formatter, "{separator}{name} {code:08X}h")?;
            separator = ", ";
        }
        match self.serial {
            Some(serial) => write!(formatter, "{separator}serial number {serial}"),
            None if separator.is_empty() => formatter.write_str("it does not say which drive it is"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn what_a_drive_says_is_told_and_nothing_else() {
        let all =
            DriveIdentity { vendor: Some(0x9A), product: Some(0x30924), revision: Some(0x10420), serial: Some(1001) };
        assert_eq!(all.to_string(), "vendor 0000009Ah, product 00030924h, revision 00010420h, serial number 1001");
        let vendor = DriveIdentity { vendor: Some(1), ..DriveIdentity::default() };
        assert_eq!(vendor.to_string(), "vendor 00000001h");
        assert_eq!(DriveIdentity { serial: Some(7), ..DriveIdentity::default() }.to_string(), "serial number 7");
        assert_eq!(DriveIdentity::default().to_string(), "it does not say which drive it is");
    }
}
