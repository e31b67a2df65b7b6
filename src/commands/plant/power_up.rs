//! How a drive starts, as an option says it.

use std::str::FromStr;

use uarm_io::drive::{Address, NodeId};

use crate::bought::{Past, StoredObject};
use crate::options::duration;
use crate::options::node_id;

/// How the drive of a node starts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StartOf {
    /// The drive.
    pub node: NodeId,
    /// What it was before.
    pub past: Past,
}

impl FromStr for StartOf {
    type Err = String;

    /// `2:boot-time=700ms,fault=3220`, `2:1801.1=0x282`.
    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "{text:?}: expected NODE:KEY=VALUE, such as 2:boot-time=700ms,emergency=8140,fault=3220,1801.1=0x282"
            )
        };
        let (node, settings) = text.split_once(':').ok_or_else(expected)?;
        let Past { mut power_up, mut stored } = Past::default();
        for setting in settings.split(',') {
            let (key, value) = setting.split_once('=').ok_or_else(expected)?;
            let code = || u16::from_str_radix(value, 16).ok().filter(|code| *code != 0).ok_or_else(expected);
            match key.trim() {
                "boot-time" => power_up.boot_time = duration(value)?,
                "emergency" => power_up.emergency = Some(code()?),
                "fault" => power_up.fault = Some(code()?),
                object => stored.push(stored_object(object, value).ok_or_else(expected)?),
            }
        }
        Ok(Self { node: node_id(node)?, past: Past { power_up, stored } })
    }
}

/// An object, as `1801.1`: index in hexadecimal digits, sub-index in decimal ones; and its value.
fn stored_object(object: &str, value: &str) -> Option<StoredObject> {
    let (index, subindex) = object.split_once('.')?;
    let address = Address::new(u16::from_str_radix(index, 16).ok()?, subindex.parse().ok()?);
    let number = match value.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16),
        None => value.parse(),
    };
    Some(StoredObject { address, number: number.ok()? })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use uarm_sim::PowerUp;

    use super::*;

    #[test]
    fn a_start_has_time_and_codes() {
        let start: StartOf = "3:boot-time=0.7s,emergency=8140,fault=3220".parse().unwrap();
        assert_eq!(start.node.raw(), 3);
        let expected = PowerUp {
            boot_time: Duration::from_millis(700),
            emergency: Some(0x8140),
            fault: Some(0x3220),
            ..PowerUp::default()
        };
        assert_eq!(start.past, Past { power_up: expected, stored: Vec::new() });
        let stored: StartOf = "2:1801.1=0x282,boot-time=1s,6065.0=-5".parse().unwrap();
        let object = |index, subindex, number| StoredObject { address: Address::new(index, subindex), number };
        assert_eq!(stored.past.stored, [object(0x1801, 1, 642), object(0x6065, 0, -5)]);
        assert_eq!(stored.past.power_up.boot_time, Duration::from_secs(1));
        for text in [
            "3:1801=1",
            "3:18011.1=1",
            "3:1801.256=1",
            "3:1801.1=",
            "3:1801.1=x",
            "3",
            "3:",
            "3:slow=1",
            "3:fault=0",
            "3:fault=xyz",
            "0:fault=3220",
            "3:boot-time=7",
        ] {
            assert!(text.parse::<StartOf>().is_err(), "{text}");
        }
    }
}
