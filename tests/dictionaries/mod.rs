//! Small dictionaries with the traits of makers' files: the emulated drive's own EDS, changed.
#![allow(dead_code, reason = "each test uses a part of it")]

use uarm_io::drive::wire::DRIVE_EDS;

/// A dictionary in the making.
#[derive(Clone, Debug)]
pub struct Dictionary(String);

impl Dictionary {
    /// The emulated drive's own.
    pub fn own() -> Self {
        Self(DRIVE_EDS.to_owned())
    }

    /// Its text.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Without an object and all its entries, such as `1019`, or without one entry, such as `1400sub5`.
    pub fn without(self, object: &str) -> Self {
        let belongs = |section: &str| {
            let name = section.split(']').next().unwrap_or_default();
            name == object || name.strip_prefix(object).is_some_and(|rest| rest.starts_with("sub"))
        };
        let (head, sections) = self.0.split_once("\n[").unwrap();
        let kept: Vec<&str> = sections.split("\n[").filter(|section| !belongs(section)).collect();
        assert!(kept.len() < sections.split("\n[").count(), "there is no {object}");
        Self(format!("{head}\n[{}", kept.join("\n[")))
    }

    /// With sections more.
    pub fn and(self, sections: &str) -> Self {
        Self(format!("{}{sections}", self.0))
    }

    /// With another value of a key in a section.
    pub fn with(self, section: &str, key: &str, value: &str) -> Self {
        let begin = self.0.find(&format!("[{section}]\n")).unwrap_or_else(|| panic!("there is no [{section}]"));
        let (before, rest) = self.0.split_at(begin);
        let end = rest.find("\n\n").unwrap_or(rest.len());
        let (own, after) = rest.split_at(end);
        let lines = own.lines().filter(|line| !line.starts_with(&format!("{key}=")));
        let own: Vec<&str> = lines.collect();
        Self(format!("{before}{}\n{key}={value}{after}", own.join("\n")))
    }

    /// A servo drive as one maker has it: no SYNC counter, ratings and resolution to be set, other PDOs on, limits that leave an
    /// entry of 1016h no room for a node, whole milliseconds only, modes that only the drive knows.
    pub fn servo() -> Self {
        Self::own()
            .without("1019")
            .with("1016sub1", "HighLimit", "65535")
            .with("1801sub1", "DefaultValue", "$NODEID+0x280")
            .with("1801sub2", "DefaultValue", "255")
            .with("1802sub1", "DefaultValue", "0x40000380+$NODEID")
            .with("1800sub1", "DefaultValue", "$NODEID+0x40000180")
            .with("1800sub2", "DefaultValue", "255")
            .with("1A00sub0", "DefaultValue", "1")
            .with("6060", "HighLimit", "10")
            .with("6502", "DefaultValue", "")
            .with("6076", "DefaultValue", "0")
            .with("608Fsub1", "AccessType", "rw")
            .with("608Fsub1", "DefaultValue", "1")
            .with("60C2sub1", "DefaultValue", "10")
            .with("60C2sub2", "LowLimit", "-3")
            .with("60C2sub2", "HighLimit", "-3")
            .with("605A", "DefaultValue", "2")
    }

    /// A drive as another maker has it: rated torque and resolution stand nowhere, no SYNC counter.
    pub fn bare() -> Self {
        Self::own().without("1019").without("608F").without("6076").without("6072").without("6075").without("60C2")
    }

    /// The traits of Elmo's Gold line: [`Dictionary::servo`], and no timeout of commands.
    pub fn gold() -> Self {
        Self::servo()
            .with("1018sub1", "DefaultValue", "0x9A")
            .without("1400sub5")
            .with("608Fsub2", "AccessType", "rw")
            .with("6007", "DefaultValue", "1")
    }

    /// The traits of maxon's EPOS4: no SYNC counter, resolution and polarity in no standard object, rated torque to be set, what the
    /// drive is known only to itself, one object in each PDO, no limit per mille.
    pub fn epos4() -> Self {
        Self::own()
            .without("1019")
            .without("608F")
            .without("6072")
            .without("6075")
            .without("1400sub5")
            .with("1000", "DefaultValue", "")
            .with("1018sub1", "DefaultValue", "")
            .with("DeviceInfo", "VendorNumber", "0xFB")
            .with("1600sub0", "DefaultValue", "1")
            .with("1800sub1", "DefaultValue", "$NODEID+0x40000180")
            .with("1800sub2", "DefaultValue", "255")
            .with("1A00sub0", "DefaultValue", "1")
            .with("605A", "DefaultValue", "6")
            .with("6007", "DefaultValue", "3")
            .with("6076", "DefaultValue", "0")
            .with("60C2sub1", "DefaultValue", "0")
            .with("6502", "DefaultValue", "")
    }

    /// The traits of the drives that a built-in profile is for.
    pub fn of_profile(name: &str) -> Self {
        match name {
            "elmo-gold" => Self::gold(),
            "maxon-epos4" => Self::epos4(),
            _ => panic!("{name} has no dictionary to be tried with"),
        }
    }
}
