//! Who is compared: a law in one of its forms.

use std::path::Path;
use std::str::FromStr;

use hinf_control::{BaseAcceleration, Law, LawVariant, VariantOrigin};
use serde::Serialize;

use crate::robot::Robot;
use crate::robot::error::RobotError;
use crate::robot::overrides::Overrides;

/// Where a controller variant comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// One of the paper's six, as the robot file has it.
    Paper,
    /// Another reading of a law of the paper.
    Reading,
    /// Ours, beyond the paper.
    Extension,
    /// Not of the paper, for comparison.
    Baseline,
}

impl Origin {
    /// The origin in a word or two.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Reading => "other reading",
            Self::Extension => "our extension",
            Self::Baseline => "baseline",
        }
    }
}

/// A law in one of its forms: one row of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControllerVariant {
    name: &'static str,
    law: Law,
    /// The form, where it is not the robot file's.
    form: Option<BaseAcceleration>,
    origin: Origin,
}

impl ControllerVariant {
    /// The paper's six.
    pub fn paper() -> impl Iterator<Item = Self> {
        Law::PAPER.into_iter().map(|law| Self { name: law.name(), law, form: None, origin: Origin::Paper })
    }

    /// All variants: the paper's six, the forms that laws name as rows of their own, and every law that is not in the paper.
    pub fn all() -> impl Iterator<Item = Self> {
        let form = |law: Law, form: &LawVariant| Self {
            name: form.name,
            law,
            form: Some(form.base_acceleration),
            origin: match form.origin {
                VariantOrigin::Reading => Origin::Reading,
                VariantOrigin::Extension => Origin::Extension,
            },
        };
        let forms = Law::ALL.into_iter().flat_map(move |law| law.variants().iter().map(move |each| form(law, each)));
        let others = Law::ALL.into_iter().filter(|law| !law.is_in_paper());
        let others = others.map(|law| Self { name: law.name(), law, form: None, origin: Origin::Baseline });
        Self::paper().chain(forms).chain(others)
    }

    /// The variant of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|variant| variant.name == name)
    }

    /// The name on command lines and in tables.
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// The law.
    pub const fn law(&self) -> Law {
        self.law
    }

    /// Where the variant comes from.
    pub const fn origin(&self) -> Origin {
        self.origin
    }

    /// The robot of `file` (without one, the paper's), its laws in this variant's form. `overrides` may change the
    /// rest; a form in them is replaced.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn robot(&self, file: Option<&Path>, overrides: &Overrides) -> Result<Robot, RobotError> {
        let base_acceleration = self.form.map(|form| (self.law, form));
        Robot::load_with(file, &Overrides { base_acceleration, ..*overrides })
    }
}

/// What describes the robot.
#[derive(Clone, Copy, Debug, Default)]
pub struct RobotFiles<'a> {
    /// The robot file; without it the paper's UARM.
    pub robot: Option<&'a Path>,
    /// Trained sets for the fuzzy laws; without them the untrained grid.
    pub fuzzy_sets: Option<&'a Path>,
}

/// A variant with the robot that it controls.
#[derive(Clone, Debug)]
pub struct VariantRobot {
    /// The controller variant.
    pub variant: ControllerVariant,
    /// The robot, its laws in the variant's form.
    pub robot: Robot,
}

impl VariantRobot {
    /// ControllerVariants with the robot of `files`. `overrides` may change it, but for the laws' form.
    ///
    /// # Errors
    /// As [`Robot::load`] and [`Robot::load_fuzzy_sets`].
    pub fn load(
        variants: &[ControllerVariant],
        files: RobotFiles<'_>,
        overrides: &Overrides,
    ) -> Result<Vec<Self>, RobotError> {
        let load = |variant: &ControllerVariant| {
            let mut robot = variant.robot(files.robot, overrides)?;
            robot.load_fuzzy_sets(files.fuzzy_sets, variants.iter().map(ControllerVariant::law))?;
            Ok(Self { variant: *variant, robot })
        };
        variants.iter().map(load).collect()
    }
}

/// ControllerVariants as a command line names them: `paper`, `all`, or names with commas between.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ControllerVariants(Vec<ControllerVariant>);

impl ControllerVariants {
    /// The variants, each once, in the order asked for.
    pub fn as_slice(&self) -> &[ControllerVariant] {
        &self.0
    }
}

impl FromStr for ControllerVariants {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "all" => return Ok(Self(ControllerVariant::all().collect())),
            "paper" => return Ok(Self(ControllerVariant::paper().collect())),
            _ => {}
        }
        let mut variants = Vec::new();
        for name in text.split(',').map(str::trim) {
            let variant = ControllerVariant::from_name(name).ok_or_else(|| {
                let names: Vec<_> = ControllerVariant::all().map(|variant| variant.name).collect();
                format!("found {name:?}, expected paper, all, or some of {}", names.join(","))
            })?;
            if variants.contains(&variant) {
                return Err(format!("{name} is named twice, expected each controller once"));
            }
            variants.push(variant);
        }
        Ok(Self(variants))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hinf_control::AdaptationGuard;

    #[test]
    fn each_variant_has_a_name_of_its_own_and_can_be_built() {
        for variant in ControllerVariant::all() {
            assert_eq!(ControllerVariant::from_name(variant.name()), Some(variant));
            let robot = variant.robot(None, &Overrides::default()).unwrap();
            robot.controller(variant.law(), AdaptationGuard::None).unwrap();
        }
    }

    #[test]
    fn lists_are_read_in_order_and_wrong_ones_refused() {
        let list: ControllerVariants = "fuzzy, nonlinear-reduced".parse().unwrap();
        let names: Vec<_> = list.as_slice().iter().map(ControllerVariant::name).collect();
        assert_eq!(names, ["fuzzy", "nonlinear-reduced"]);
        assert_eq!("all".parse::<ControllerVariants>().unwrap().as_slice().len(), 13);
        assert!("fuzzy,fuzzy".parse::<ControllerVariants>().unwrap_err().contains("twice"));
        assert!("".parse::<ControllerVariants>().unwrap_err().contains("expected"));
        assert!("pid".parse::<ControllerVariants>().unwrap_err().contains("nonlinear"));
    }
}
