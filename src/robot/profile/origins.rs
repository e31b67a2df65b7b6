//! Which fields of a completed joint a profile gave, so that what is wrong with one is told where it was written.

use std::path::Path;

use crate::robot::error::RobotError;

/// The fields of one joint that its profile gave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origins {
    /// `joints[1].`.
    joint: String,
    fields: Vec<&'static str>,
    /// Of the first entries of `drive.writes`, the positions in the profile's own list.
    writes: Vec<usize>,
}

impl Origins {
    /// Of joint `index`, none yet.
    pub fn of_joint(index: usize) -> Self {
        Self { joint: format!("joints[{index}]."), fields: Vec::new(), writes: Vec::new() }
    }

    /// The same, where the first entries of `drive.writes` are these of the profile.
    pub fn with_writes(self, writes: Vec<usize>) -> Self {
        Self { writes, ..self }
    }

    /// Takes `default` where `own` says nothing.
    pub fn take<T: Clone>(&mut self, own: &mut Option<T>, default: Option<&T>, field: &'static str) {
        if own.is_none() && default.is_some() {
            *own = default.cloned();
            self.fields.push(field);
        }
    }

    /// Takes `default` where `own` has no entry.
    pub fn take_list<T: Clone>(&mut self, own: &mut Vec<T>, default: &[T], field: &'static str) {
        if own.is_empty() && !default.is_empty() {
            own.extend_from_slice(default);
            self.fields.push(field);
        }
    }

    /// The same error, told where its field was written; `profile` is what the robot file calls the profile.
    pub fn tell(&self, error: RobotError, profile: &str) -> RobotError {
        let RobotError::Field { file, field, value, expected } = error else { return error };
        let Some(rest) = field.strip_prefix(&self.joint) else {
            return RobotError::Field { file, field, value, expected };
        };
        let in_profile = |field: String| {
            let expected = format!("{expected}; {}drive.profile in {} names this profile", self.joint, file.display());
            RobotError::Field {
                file: Path::new(&format!("profile {profile}")).into(),
                field,
                value: value.clone(),
                expected,
            }
        };
        let is_within = |given: &&&str| {
            rest.strip_prefix(**given).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        if self.fields.iter().any(|given| is_within(&given)) {
            return in_profile(rest.to_owned());
        }
        let entry = rest.strip_prefix("drive.writes[").and_then(|rest| rest.split_once(']'));
        match entry.and_then(|(number, rest)| Some((number.parse::<usize>().ok()?, rest))) {
            Some((number, rest)) => match self.writes.get(number) {
                Some(number) => in_profile(format!("drive.writes[{number}]{rest}")),
                None => {
                    let field = format!("{}drive.writes[{}]{rest}", self.joint, number - self.writes.len());
                    RobotError::Field { file, field, value, expected }
                }
            },
            None => RobotError::Field { file, field, value, expected },
        }
    }
}
