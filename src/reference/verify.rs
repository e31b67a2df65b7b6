//! Does a stored reference still tell the joint's angle?

use uarm_io::drive::words::Shown as ShownValue;
use uarm_loop::robot::Joint;

use super::drive::Shown;
use super::store::JointReference;
use crate::robot::file;

/// Why a reference does not hold.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Expired {
    /// The robot file says something else than when the reference was set.
    #[error("the robot file's {field} was {then} when it was referenced, and is {now}")]
    RobotFile {
        /// The field.
        field: &'static str,
        /// What it said then.
        then: String,
        /// What it says now.
        now: String,
    },
    /// Another drive answers.
    #[error("its drive was referenced as {then}, and is {now} (vendor, product, serial number)")]
    AnotherDrive {
        /// Who was referenced.
        then: String,
        /// Who answers.
        now: String,
    },
    /// The marker is gone.
    #[error("its power marker reads {found}, expected {expected}: the drive has lost its power or was reset since")]
    MarkerLost {
        /// What it reads.
        found: String,
        /// What was written.
        expected: String,
    },
    /// The drive itself says so.
    #[error("its drive says that it is not referenced: bit {bit} of the statusword {statusword:04X}h is 0")]
    SaysSo {
        /// The bit of 6041h.
        bit: u8,
        /// 6041h.
        statusword: u16,
    },
    /// The angle is none that the joint can have.
    #[error("{position} counts would be {angle_deg:.1} deg, outside of {least} to {most} deg")]
    OutsideWindow {
        /// 6064h.
        position: i32,
        /// The angle that the reference gives it.
        angle_deg: f64,
        /// The smallest angle that is believed, degrees.
        least: f64,
        /// The largest angle that is believed, degrees.
        most: f64,
    },
}

/// The joint's angle, rad, by `reference`, if that still holds for the drive that was `found`.
///
/// # Errors
/// [`Expired`].
pub fn verify(file: &file::Joint, joint: &Joint, reference: &JointReference, found: &Shown) -> Result<f64, Expired> {
    same_file(file, reference)?;
    let identity = |vendor: Option<u32>, product: Option<u32>, serial: Option<u32>| {
        [vendor, product, serial].map(|number| number.map_or_else(|| "-".to_owned(), |n| n.to_string())).join(", ")
    };
    let then = identity(reference.vendor, reference.product, reference.serial);
    let now = identity(found.vendor, found.product, found.serial);
    if then != now {
        return Err(Expired::AnotherDrive { then, now });
    }
    if let Some(bit) = file.encoder.referenced_bit
        && found.statusword.bits() >> bit & 1 == 0
    {
        return Err(Expired::SaysSo { bit, statusword: found.statusword.bits() });
    }
    if let Some(expected) = file.encoder.power_marker.as_ref().map(file::ObjectWrite::as_value)
        && found.marker != expected
    {
        let show = |value: Option<_>| value.map_or_else(|| "nothing".to_owned(), |value| ShownValue(value).to_string());
        return Err(Expired::MarkerLost { found: show(found.marker), expected: show(expected) });
    }
    let counts = i64::from(found.position.wrapping_sub(reference.zero_counts));
    let angle = joint.encoder.direction.apply(counts as f64) * joint.encoder.counts_per_revolution.resolution();
    let [least, most] = reference.window_deg;
    if (least..=most).contains(&angle.to_degrees()) {
        Ok(angle)
    } else {
        Err(Expired::OutsideWindow { position: found.position, angle_deg: angle.to_degrees(), least, most })
    }
}

/// What the zero was computed from must still be what the robot file says.
fn same_file(file: &file::Joint, reference: &JointReference) -> Result<(), Expired> {
    let encoder = &file.encoder;
    let differs = |field, then: String, now: String| Err(Expired::RobotFile { field, then, now });
    if encoder.counts_per_revolution != reference.counts_per_revolution {
        let (then, now) = (reference.counts_per_revolution, encoder.counts_per_revolution);
        return differs("counts_per_revolution", then.to_string(), now.to_string());
    }
    if file.gear_ratio != reference.gear_ratio {
        let word = |ratio: Option<[u32; 2]>| ratio.map_or_else(|| "none".to_owned(), |ratio| format!("{ratio:?}"));
        return differs("gear_ratio", word(reference.gear_ratio), word(file.gear_ratio));
    }
    if encoder.direction != reference.direction {
        return differs("direction", format!("{:?}", reference.direction), format!("{:?}", encoder.direction));
    }
    if encoder.power_marker != reference.power_marker {
        let word = |marker: &Option<file::ObjectWrite>| {
            marker.as_ref().map_or_else(
                || "absent".to_owned(),
                |marker| format!("{:04X}h:{:02X} = {}", marker.index, marker.subindex, marker.value),
            )
        };
        return differs("power_marker", word(&reference.power_marker), word(&encoder.power_marker));
    }
    Ok(())
}
