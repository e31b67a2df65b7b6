//! Who is compared: a law in one of its forms.

use std::path::Path;
use std::str::FromStr;

use hinf_control::Law;
use serde::Serialize;

use crate::robot::Robot;
use crate::robot::error::RobotError;
use crate::robot::file::BaseAccelerationMode;
use crate::robot::overrides::Overrides;

/// Where a contestant comes from.
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
pub struct Contestant {
    name: &'static str,
    law: Law,
    /// The form, where it is not the robot file's.
    form: Option<BaseAccelerationMode>,
    origin: Origin,
}

const fn paper(law: Law) -> Contestant {
    Contestant { name: law.name(), law, form: None, origin: Origin::Paper }
}

const fn variant(name: &'static str, law: Law, form: BaseAccelerationMode, origin: Origin) -> Contestant {
    Contestant { name, law, form: Some(form), origin }
}

impl Contestant {
    /// The paper's six.
    pub const PAPER: [Self; 6] = [
        paper(Law::Nonlinear),
        paper(Law::Adaptive),
        paper(Law::Neural),
        paper(Law::NeuralModel),
        paper(Law::Fuzzy),
        paper(Law::FuzzyModel),
    ];

    /// Those that are no rows of Table 4.
    pub const BEYOND_THE_PAPER: [Self; 7] = {
        use BaseAccelerationMode::{Measured, Omitted, Reduced, ReducedMomentum};
        [
            variant("nonlinear-measured", Law::Nonlinear, Measured, Origin::Reading),
            variant("nonlinear-omitted", Law::Nonlinear, Omitted, Origin::Reading),
            variant("nonlinear-reduced", Law::Nonlinear, Reduced, Origin::Extension),
            variant("nonlinear-reduced-momentum", Law::Nonlinear, ReducedMomentum, Origin::Extension),
            variant("neural-model-reduced", Law::NeuralModel, Reduced, Origin::Extension),
            variant("fuzzy-model-reduced", Law::FuzzyModel, Reduced, Origin::Extension),
            Self { name: Law::ComputedTorque.name(), law: Law::ComputedTorque, form: None, origin: Origin::Baseline },
        ]
    };

    /// All contestants, the paper's six first.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::PAPER.into_iter().chain(Self::BEYOND_THE_PAPER)
    }

    /// The contestant of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|contestant| contestant.name == name)
    }

    /// The name on command lines and in tables.
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// The law.
    pub const fn law(&self) -> Law {
        self.law
    }

    /// Where the contestant comes from.
    pub const fn origin(&self) -> Origin {
        self.origin
    }

    /// The robot of `file` (without one, the paper's), its laws in this contestant's form. `overrides` may change the
    /// rest; a form in them is replaced.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn robot(&self, file: Option<&Path>, overrides: &Overrides) -> Result<Robot, RobotError> {
        let base_acceleration = self.form.map(|form| (self.law, form));
        Robot::load_with(file, &Overrides { base_acceleration, ..*overrides })
    }
}

/// A contestant with the robot that it controls.
#[derive(Clone, Debug)]
pub struct Entrant {
    /// Who.
    pub contestant: Contestant,
    /// The robot, its laws in the contestant's form.
    pub robot: Robot,
}

impl Entrant {
    /// Contestants with the robot of `file` (without one, the paper's). `overrides` may change it, but for the laws' form.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn load(
        contestants: &[Contestant],
        file: Option<&Path>,
        overrides: &Overrides,
    ) -> Result<Vec<Self>, RobotError> {
        let load =
            |contestant: &Contestant| Ok(Self { contestant: *contestant, robot: contestant.robot(file, overrides)? });
        contestants.iter().map(load).collect()
    }
}

/// Contestants as a command line names them: `paper`, `all`, or names with commas between.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contestants(Vec<Contestant>);

impl Contestants {
    /// The contestants, each once, in the order asked for.
    pub fn as_slice(&self) -> &[Contestant] {
        &self.0
    }
}

impl FromStr for Contestants {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "all" => return Ok(Self(Contestant::all().collect())),
            "paper" => return Ok(Self(Contestant::PAPER.to_vec())),
            _ => {}
        }
        let mut contestants = Vec::new();
        for name in text.split(',') {
            let contestant = Contestant::from_name(name).ok_or_else(|| {
                let names: Vec<_> = Contestant::all().map(|contestant| contestant.name).collect();
                format!("found {name:?}, expected paper, all, or some of {}", names.join(","))
            })?;
            if contestants.contains(&contestant) {
                return Err(format!("{name} is named twice, expected each controller once"));
            }
            contestants.push(contestant);
        }
        Ok(Self(contestants))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_contestant_has_a_name_of_its_own_and_can_be_built() {
        for contestant in Contestant::all() {
            assert_eq!(Contestant::from_name(contestant.name()), Some(contestant));
            let robot = contestant.robot(None, &Overrides::default()).unwrap();
            crate::controllers::build(contestant.law(), &robot, crate::controllers::AdaptationGuard::None).unwrap();
        }
    }

    #[test]
    fn lists_are_read_in_order_and_wrong_ones_refused() {
        let list: Contestants = "fuzzy,nonlinear-reduced".parse().unwrap();
        let names: Vec<_> = list.as_slice().iter().map(Contestant::name).collect();
        assert_eq!(names, ["fuzzy", "nonlinear-reduced"]);
        assert_eq!("all".parse::<Contestants>().unwrap().as_slice().len(), 13);
        assert!("fuzzy,fuzzy".parse::<Contestants>().unwrap_err().contains("twice"));
        assert!("".parse::<Contestants>().unwrap_err().contains("expected"));
        assert!("pid".parse::<Contestants>().unwrap_err().contains("nonlinear"));
    }
}
