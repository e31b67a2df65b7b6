//! Drive profiles: what a robot file need not say of a drive whose maker's dictionary is known.
//!
//! A profile is a TOML file: one that is built in, by name, or one of the user's, by path. What the robot file says itself wins.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use uarm_io::torque::TorqueUnit;

use super::error::{Checker, RobotError};
use super::file::{
    Encoder, Identity, Joint, ObjectType, ObjectWrite, Pdo, ResolutionObject, RobotFile, TargetTorqueOf, Watchdog, When,
};
use super::reading::read;
use crate::text_file;

/// The version of the format.
const SCHEMA: u32 = 1;

/// The profiles that are built in: name and text.
pub const SHIPPED: [(&str, &str); 2] = [
    ("elmo-gold", include_str!("../../robots/profiles/elmo-gold.toml")),
    ("maxon-epos4", include_str!("../../robots/profiles/maxon-epos4.toml")),
];

/// What a profile says.
#[derive(Clone, Debug, Deserialize)]
pub struct Profile {
    schema: u32,
    /// The drives that it is for.
    pub drives: String,
    /// From what it is known, and whether it was tried.
    pub evidence: String,
    #[serde(default)]
    encoder: EncoderDefaults,
    #[serde(default)]
    drive: DriveDefaults,
}

#[derive(Clone, Debug, Default, Deserialize)]
struct EncoderDefaults {
    resolution_object: Option<ResolutionObject>,
    power_marker: Option<ObjectWrite>,
    referenced_bit: Option<u8>,
}

#[derive(Clone, Debug, Default, Deserialize)]
struct DriveDefaults {
    #[serde(default)]
    identity: Identity,
    rated_torque_unit: Option<TorqueUnit>,
    target_torque_of: Option<TargetTorqueOf>,
    torque_applies: Option<uarm_io::drive::wishes::TorqueApplies>,
    watchdog: Option<Watchdog>,
    rpdo_timeout_ms: Option<u16>,
    pdo: Option<Pdo>,
    #[serde(default)]
    writes: Vec<ProfileWrite>,
}

/// An entry of `writes` whose value may be a number of the joint that the drive moves.
#[derive(Clone, Debug, Deserialize)]
struct ProfileWrite {
    index: u16,
    subindex: u8,
    #[serde(rename = "type")]
    kind: ObjectType,
    value: ProfileValue,
    when: Option<When>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "a whole number, \"rated-torque\" or \"counts-per-revolution\"")]
enum ProfileValue {
    Number(i64),
    OfJoint(Quantity),
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Quantity {
    RatedTorque,
    CountsPerRevolution,
}

/// A profile that a joint uses, for those who must know of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UsedProfile {
    /// The joint's name.
    pub joint: String,
    /// As the robot file names it.
    pub profile: String,
    /// The drives that it is for.
    pub drives: String,
    /// From what it is known.
    pub evidence: String,
}

impl std::fmt::Display for UsedProfile {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { joint, profile, drives, evidence } = self;
        write!(formatter, "{joint}: profile {profile} ({drives}): {evidence}")
    }
}

/// Completes the joints of `file` from the profiles that they name; paths are relative to the folder of `name`.
///
/// # Errors
/// [`RobotError`] if a profile does not exist or is wrong.
pub(super) fn apply(name: &Path, file: &mut RobotFile, check: &Checker<'_>) -> Result<Vec<UsedProfile>, RobotError> {
    let mut used = Vec::new();
    for (index, joint) in file.joints.iter_mut().enumerate() {
        let Some(profile_name) = joint.drive.profile.clone() else { continue };
        let profile = find(&profile_name, name, || {
            let shipped = SHIPPED.map(|(shipped, _)| shipped).join(", ");
            let expected = format!("one of {shipped}, or the path of a profile, such as \"./my-drive.toml\"");
            check.refuse(format!("joints[{index}].drive.profile"), format!("{profile_name:?}"), expected)
        })?;
        profile.complete(joint);
        let Profile { drives, evidence, .. } = profile;
        used.push(UsedProfile { joint: joint.name.clone(), profile: profile_name, drives, evidence });
    }
    Ok(used)
}

/// The profile that is called `name` in the robot file `robot`: built in, or a file if the name is a path.
fn find(name: &str, robot: &Path, unknown: impl FnOnce() -> RobotError) -> Result<Profile, RobotError> {
    if let Some((_, text)) = SHIPPED.iter().find(|(shipped, _)| *shipped == name) {
        return Profile::parse(Path::new(name), text);
    }
    if !name.contains('/') && !name.ends_with(".toml") {
        return Err(unknown());
    }
    let path: PathBuf = robot.parent().unwrap_or(Path::new("")).join(name);
    let text = text_file::read(&path).map_err(|source| RobotError::Read { file: path.clone(), source })?;
    Profile::parse(&path, &text)
}

impl Profile {
    /// A profile from its text; `name` is what messages call it.
    ///
    /// # Errors
    /// [`RobotError`] names file, field, value and expectation.
    pub fn parse(name: &Path, text: &str) -> Result<Self, RobotError> {
        let check = Checker::new(name);
        let (profile, unknown): (Self, _) = read(name, text)?;
        if let Some(field) = unknown.first() {
            let expected = "a field of a drive profile, as docs/your-own-robot.md lists them";
            return Err(check.refuse(field, "unknown field", expected));
        }
        if profile.schema != SCHEMA {
            return Err(check.refuse("schema", profile.schema, format!("{SCHEMA}")));
        }
        Ok(profile)
    }

    /// Gives `joint` what it does not say itself.
    fn complete(&self, joint: &mut Joint) {
        let unit = &mut joint.drive.rated_torque_unit;
        *unit = unit.or(self.drive.rated_torque_unit);
        // Whether a number is written depends on what the joint says itself.
        let writes: Vec<ObjectWrite> = self.drive.writes.iter().filter_map(|write| write.of(joint)).collect();
        let Encoder { resolution_object, power_marker, referenced_bit, .. } = &mut joint.encoder;
        *resolution_object = resolution_object.or(self.encoder.resolution_object);
        if power_marker.is_none() && referenced_bit.is_none() {
            *power_marker = self.encoder.power_marker.clone();
            *referenced_bit = self.encoder.referenced_bit;
        }
        let (drive, defaults) = (&mut joint.drive, &self.drive);
        let Identity { vendor, product, serial } = &mut drive.identity;
        *vendor = vendor.or(defaults.identity.vendor);
        *product = product.or(defaults.identity.product);
        *serial = serial.or(defaults.identity.serial);
        drive.target_torque_of = drive.target_torque_of.or(defaults.target_torque_of);
        drive.torque_applies = drive.torque_applies.or(defaults.torque_applies);
        if drive.watchdog.is_none() {
            drive.watchdog = defaults.watchdog;
            drive.rpdo_timeout_ms = drive.rpdo_timeout_ms.or(defaults.rpdo_timeout_ms);
        }
        drive.pdo = match (drive.pdo.take(), &defaults.pdo) {
            (Some(own), Some(defaults)) => Some(completed(own, defaults)),
            (own, defaults) => own.or_else(|| defaults.clone()),
        };
        drive.writes.splice(0..0, writes);
    }
}

impl ProfileWrite {
    /// The entry for `joint`; none if the joint writes the object itself, or says itself that it is compared.
    fn of(&self, joint: &Joint) -> Option<ObjectWrite> {
        let (encoder, drive) = (&joint.encoder, &joint.drive);
        let is_same = |own: &ObjectWrite| (own.index, own.subindex) == (self.index, self.subindex);
        if drive.writes.iter().any(is_same) {
            return None;
        }
        let value = match self.value {
            ProfileValue::Number(number) => number,
            ProfileValue::OfJoint(Quantity::RatedTorque) if drive.target_torque_of.is_none() => {
                let unit = drive.rated_torque_unit.unwrap_or_default().newton_metres();
                // A torque that is no whole number of its unit is refused where the joint is checked.
                (drive.rated_torque_nm / unit).round() as i64
            }
            ProfileValue::OfJoint(Quantity::CountsPerRevolution) if encoder.resolution_object.is_none() => {
                i64::from(encoder.counts_per_revolution)
            }
            ProfileValue::OfJoint(_) => return None,
        };
        let Self { index, subindex, kind, when, .. } = *self;
        Some(ObjectWrite { index, subindex, kind, value, when })
    }
}

/// PDOs as a joint has them, and as its profile has them where the joint does not say.
fn completed(own: Pdo, defaults: &Pdo) -> Pdo {
    let list = |own: Vec<u16>, defaults: &Vec<u16>| if own.is_empty() { defaults.clone() } else { own };
    Pdo {
        rpdo: own.rpdo.or(defaults.rpdo),
        rpdo_id: own.rpdo_id.or(defaults.rpdo_id),
        rpdo_transmission: own.rpdo_transmission.or(defaults.rpdo_transmission),
        tpdo: own.tpdo.or(defaults.tpdo),
        tpdo_id: own.tpdo_id.or(defaults.tpdo_id),
        torque_tpdo: own.torque_tpdo.or(defaults.torque_tpdo),
        torque_tpdo_id: own.torque_tpdo_id.or(defaults.torque_tpdo_id),
        keep_rpdos: list(own.keep_rpdos, &defaults.keep_rpdos),
        keep_tpdos: list(own.keep_tpdos, &defaults.keep_tpdos),
    }
}

#[cfg(test)]
mod tests;
