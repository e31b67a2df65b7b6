//! How a drive starts, as an option says it.

use std::str::FromStr;

use uarm_io::drive::NodeId;
use uarm_sim::PowerUp;

use crate::options::duration;
use crate::options::node_id;

/// How the drive of a node starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StartOf {
    /// The drive.
    pub node: NodeId,
    /// How it starts.
    pub power_up: PowerUp,
}

impl FromStr for StartOf {
    type Err = String;

    /// `2:boot-time=700ms,fault=3220`.
    fn from_str(text: &str) -> Result<Self, String> {
        let expected =
            || format!("{text:?}: expected NODE:KEY=VALUE, such as 2:boot-time=700ms,emergency=8140,fault=3220");
        let (node, settings) = text.split_once(':').ok_or_else(expected)?;
        let mut power_up = PowerUp::default();
        for setting in settings.split(',') {
            let (key, value) = setting.split_once('=').ok_or_else(expected)?;
            let code = || u16::from_str_radix(value, 16).ok().filter(|code| *code != 0).ok_or_else(expected);
            match key.trim() {
                "boot-time" => power_up.boot_time = duration(value)?,
                "emergency" => power_up.emergency = Some(code()?),
                "fault" => power_up.fault = Some(code()?),
                _ => return Err(expected()),
            }
        }
        Ok(Self { node: node_id(node)?, power_up })
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

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
        assert_eq!(start.power_up, expected);
        for text in ["3", "3:", "3:slow=1", "3:fault=0", "3:fault=xyz", "0:fault=3220", "3:boot-time=7"] {
            assert!(text.parse::<StartOf>().is_err(), "{text}");
        }
    }
}
