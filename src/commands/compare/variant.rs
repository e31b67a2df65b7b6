//! Who is compared: a law in one of its forms.

use std::path::Path;
use std::str::FromStr;

use hinf_control::{BaseAcceleration, Law, LawVariant, VariantOrigin};
use serde::Serialize;

use crate::robot::error::RobotError;
use crate::robot::overrides::Overrides;
use crate::robot::{Robot, RobotText};
use crate::usage::UsageError;

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

/// Why a variant is for other robots.
pub const UNSENSED: &str = "it reads the motion of the base, on which the robot has no sensor";

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

    /// `error` as one of this variant: whoever names it has not asked for its form by another option.
    fn refused(&self, error: RobotError) -> RobotError {
        match error {
            RobotError::Override(_) => {
                RobotError::Override(UsageError::new(format!("--controllers {}: {UNSENSED}", self.name)))
            }
            other => other,
        }
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

    /// The robot of `file`, its laws in this variant's form. `overrides` may change the rest; a form in them is replaced.
    ///
    /// # Errors
    /// As [`Robot::load`]; [`RobotError::Override`] if the form reads what the robot has no sensor for.
    pub fn robot<const J: usize, const N: usize>(
        &self,
        file: &RobotText,
        overrides: &Overrides,
    ) -> Result<Robot<J, N>, RobotError> {
        let base_acceleration = self.form.map(|form| (self.law, form));
        Robot::of_text(&file.name, &file.text, &Overrides { base_acceleration, ..*overrides })
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
pub struct VariantRobot<const J: usize = 3, const N: usize = 2> {
    /// The controller variant.
    pub variant: ControllerVariant,
    /// The robot, its laws in the variant's form.
    pub robot: Robot<J, N>,
}

impl<const J: usize, const N: usize> VariantRobot<J, N> {
    /// Variants with the robot of `files`. `overrides` may change it, but for the laws' form.
    ///
    /// # Errors
    /// As [`Robot::load`] and [`Robot::load_fuzzy_sets`]; if the robot lacks a sensor that one of them reads.
    pub fn load(
        variants: &[ControllerVariant],
        files: RobotFiles<'_>,
        overrides: &Overrides,
    ) -> Result<Vec<Self>, RobotError> {
        let file = RobotText::read(files.robot)?;
        let load = |variant: &ControllerVariant| {
            let mut robot = variant.robot(&file, overrides).map_err(|error| variant.refused(error))?;
            robot.load_fuzzy_sets(files.fuzzy_sets, variants.iter().map(ControllerVariant::law))?;
            Ok(Self { variant: *variant, robot })
        };
        variants.iter().map(load).collect()
    }
}

/// Controller variants as a command line names them: `paper`, `all`, or names with commas between.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ControllerVariants {
    variants: Vec<ControllerVariant>,
    asked: Asked,
}

/// How variants were asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    /// Each by its name, or as one of the paper's.
    ByName,
    /// As all that there are.
    All,
}

impl ControllerVariants {
    /// The variants, each once, in the order asked for.
    pub fn as_slice(&self) -> &[ControllerVariant] {
        &self.variants
    }

    /// Those for which the robot of `files` has the sensors, if all were asked for, and those for which it has not.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn on_robot<const J: usize, const N: usize>(
        &self,
        files: RobotFiles<'_>,
    ) -> Result<(Vec<ControllerVariant>, Vec<ControllerVariant>), RobotError> {
        if self.asked == Asked::ByName {
            return Ok((self.variants.clone(), Vec::new()));
        }
        let file = RobotText::read(files.robot)?;
        let (mut fitting, mut others) = (Vec::new(), Vec::new());
        for variant in &self.variants {
            match variant.robot::<J, N>(&file, &Overrides::default()) {
                Ok(_) => fitting.push(*variant),
                Err(RobotError::Override(_)) => others.push(*variant),
                Err(error) => return Err(error),
            }
        }
        Ok((fitting, others))
    }
}

impl FromStr for ControllerVariants {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "all" => return Ok(Self { variants: ControllerVariant::all().collect(), asked: Asked::All }),
            "paper" => return Ok(Self { variants: ControllerVariant::paper().collect(), asked: Asked::ByName }),
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
        Ok(Self { variants, asked: Asked::ByName })
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
            let robot = variant.robot::<3, 2>(&RobotText::read(None).unwrap(), &Overrides::default()).unwrap();
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
