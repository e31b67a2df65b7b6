//! Drive profiles: what a robot file need not say of a drive whose maker's dictionary is known.
//!
//! A profile is a TOML file: one that is built in, by name, or one of the user's, by path. What the robot file says itself wins.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use uarm_io::torque::TorqueUnit;

use super::error::{Checker, RobotError};
use super::file::{
    Drive, Encoder, Identity, Joint, ObjectType, ObjectWrite, Pdo, ResolutionObject, TargetTorqueOf, Watchdog, When,
};
use super::reading::read;
use crate::text_file;
use origins::Origins;

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
    origins: Origins,
}

impl std::fmt::Display for UsedProfile {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { joint, profile, drives, evidence, .. } = self;
        write!(formatter, "{joint}: profile {profile} ({drives}): {evidence}")
    }
}

/// Completes the joints of `file` from the profiles that they name; paths are relative to the folder of `name`.
///
/// # Errors
/// [`RobotError`] if a profile does not exist or is wrong.
pub(super) fn apply(name: &Path, joints: &mut [Joint], check: &Checker<'_>) -> Result<Vec<UsedProfile>, RobotError> {
    let mut used = Vec::new();
    for (index, joint) in joints.iter_mut().enumerate() {
        let Some(profile_name) = joint.drive.profile.clone() else { continue };
        let profile = find(&profile_name, name, |why| {
            let shipped = SHIPPED.map(|(shipped, _)| shipped).join(", ");
            let expected = format!("one of {shipped}, or the path of a profile, such as \"./my-drive.toml\"{why}");
            check.refuse(format!("joints[{index}].drive.profile"), format!("{profile_name:?}"), expected)
        })?;
        let origins = profile.complete(index, joint);
        let Profile { drives, evidence, .. } = profile;
        used.push(UsedProfile { joint: joint.name.clone(), profile: profile_name, drives, evidence, origins });
    }
    Ok(used)
}

/// The same error, told where it was written: a field that a profile gave is in the profile.
pub(super) fn told_where_written(error: RobotError, used: &[UsedProfile]) -> RobotError {
    used.iter().fold(error, |error, used| used.origins.tell(error, &used.profile))
}

/// The profile that is called `name` in the robot file `robot`: built in, or a file if the name is a path.
///
/// # Errors
/// What `unknown` makes of the reason, if there is no such profile; else what is wrong in it.
fn find(name: &str, robot: &Path, unknown: impl FnOnce(&str) -> RobotError) -> Result<Profile, RobotError> {
    if let Some((_, text)) = SHIPPED.iter().find(|(shipped, _)| *shipped == name) {
        return Profile::parse(Path::new(name), text);
    }
    if !name.contains('/') && !name.ends_with(".toml") {
        return Err(unknown(""));
    }
    let path: PathBuf = robot.parent().unwrap_or(Path::new("")).join(name);
    let text = text_file::read(&path).map_err(|error| unknown(&format!("; {}: {error}", path.display())))?;
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

    /// Gives joint `index` what it does not say itself.
    fn complete(&self, index: usize, joint: &mut Joint) -> Origins {
        let mut origins = Origins::of_joint(index);
        let (encoder, defaults) = (&mut joint.encoder, &self.encoder);
        let (drive, of_drive) = (&mut joint.drive, &self.drive);
        origins.take(&mut drive.rated_torque_unit, of_drive.rated_torque_unit.as_ref(), "drive.rated_torque_unit");
        // Whether a number is written depends on what the joint says itself.
        let writes = of_drive.writes.iter().enumerate();
        let (numbers, writes): (Vec<usize>, Vec<ObjectWrite>) =
            writes.filter_map(|(number, write)| Some((number, write.of(encoder, drive)?))).unzip();
        origins.take(&mut encoder.resolution_object, defaults.resolution_object.as_ref(), "encoder.resolution_object");
        if encoder.power_marker.is_none() && encoder.referenced_bit.is_none() {
            origins.take(&mut encoder.power_marker, defaults.power_marker.as_ref(), "encoder.power_marker");
            origins.take(&mut encoder.referenced_bit, defaults.referenced_bit.as_ref(), "encoder.referenced_bit");
        }
        let (identity, of_identity) = (&mut drive.identity, &of_drive.identity);
        origins.take(&mut identity.vendor, of_identity.vendor.as_ref(), "drive.identity.vendor");
        origins.take(&mut identity.product, of_identity.product.as_ref(), "drive.identity.product");
        origins.take(&mut identity.serial, of_identity.serial.as_ref(), "drive.identity.serial");
        origins.take(&mut drive.target_torque_of, of_drive.target_torque_of.as_ref(), "drive.target_torque_of");
        origins.take(&mut drive.torque_applies, of_drive.torque_applies.as_ref(), "drive.torque_applies");
        if drive.watchdog.is_none() {
            origins.take(&mut drive.watchdog, of_drive.watchdog.as_ref(), "drive.watchdog");
            origins.take(&mut drive.rpdo_timeout_ms, of_drive.rpdo_timeout_ms.as_ref(), "drive.rpdo_timeout_ms");
        }
        if let Some(of_pdo) = &of_drive.pdo {
            complete_pdo(drive.pdo.get_or_insert_default(), of_pdo, &mut origins);
        }
        drive.writes.splice(0..0, writes);
        origins.with_writes(numbers)
    }
}

impl ProfileWrite {
    /// The entry for the joint of this encoder and drive; none if the joint writes the object itself, or says itself that it is compared.
    fn of(&self, encoder: &Encoder, drive: &Drive) -> Option<ObjectWrite> {
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

/// Gives a joint's PDOs what the joint does not say.
fn complete_pdo(own: &mut Pdo, defaults: &Pdo, origins: &mut Origins) {
    origins.take(&mut own.rpdo, defaults.rpdo.as_ref(), "drive.pdo.rpdo");
    origins.take(&mut own.rpdo_id, defaults.rpdo_id.as_ref(), "drive.pdo.rpdo_id");
    origins.take(&mut own.rpdo_transmission, defaults.rpdo_transmission.as_ref(), "drive.pdo.rpdo_transmission");
    origins.take(&mut own.tpdo, defaults.tpdo.as_ref(), "drive.pdo.tpdo");
    origins.take(&mut own.tpdo_id, defaults.tpdo_id.as_ref(), "drive.pdo.tpdo_id");
    origins.take(&mut own.torque_tpdo, defaults.torque_tpdo.as_ref(), "drive.pdo.torque_tpdo");
    origins.take(&mut own.torque_tpdo_id, defaults.torque_tpdo_id.as_ref(), "drive.pdo.torque_tpdo_id");
    origins.take_list(&mut own.keep_rpdos, &defaults.keep_rpdos, "drive.pdo.keep_rpdos");
    origins.take_list(&mut own.keep_tpdos, &defaults.keep_tpdos, "drive.pdo.keep_tpdos");
}

mod origins;
#[cfg(test)]
mod tests;
