//! Names of network interfaces.

use core::fmt;

/// The longest name that Linux gives an interface (`IFNAMSIZ` less the closing zero).
const LONGEST_NAME: usize = 15;

/// The name of a network interface, such as `can0` or `vcan0`: 1 to 15 visible ASCII characters without `/`.
///
/// It is held in place, so that an error on the real-time path can carry it without allocating.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InterfaceName {
    bytes: [u8; LONGEST_NAME],
    length: usize,
}

/// A text that cannot be the name of an interface.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error(
    "`{found}` is not the name of a network interface: expected 1 to {LONGEST_NAME} visible ASCII characters without `/`, such as `can0`"
)]
pub struct InterfaceNameError {
    found: String,
}

impl InterfaceName {
    /// The name as text.
    pub fn as_str(&self) -> &str {
        self.bytes.get(..self.length).and_then(|bytes| core::str::from_utf8(bytes).ok()).unwrap_or_default()
    }
}

impl core::str::FromStr for InterfaceName {
    type Err = InterfaceNameError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let refused = || InterfaceNameError { found: text.to_owned() };
        let allowed = |byte: u8| byte.is_ascii_graphic() && byte != b'/' && byte != b':';
        // The kernel refuses these two, since an interface is also a folder under /sys/class/net.
        if text.is_empty() || text == "." || text == ".." || !text.bytes().all(allowed) {
            return Err(refused());
        }
        let mut bytes = [0; LONGEST_NAME];
        bytes.get_mut(..text.len()).ok_or_else(refused)?.copy_from_slice(text.as_bytes());
        Ok(Self { bytes, length: text.len() })
    }
}

impl fmt::Display for InterfaceName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.as_str())
    }
}

impl fmt::Debug for InterfaceName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), formatter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back_as_given() {
        for name in ["can0", "v", "a-long_name.100"] {
            assert_eq!(name.parse::<InterfaceName>().unwrap().to_string(), name);
        }
    }

    #[test]
    fn what_linux_refuses_is_refused() {
        for name in ["", ".", "..", "a/b", "can 0", "sixteen-letters-", "kän0", "can0:1"] {
            let error = name.parse::<InterfaceName>().unwrap_err();
            assert!(error.to_string().starts_with(&format!("`{name}` is not")), "{error}");
        }
    }
}
