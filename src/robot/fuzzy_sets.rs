//! Files of trained fuzzy sets, as `uarm train` writes and `--fuzzy-sets` takes them.

use std::fmt::Write;
use std::path::Path;

use hinf_control::{BellShape, Firing, FuzzySets, GeneralisedBell, Law};
use serde::Deserialize;

use super::Robot;
use super::error::{Checker, RobotError};
use crate::text_file;

/// The name under which the built-in file appears in messages.
pub const BUILT_IN_NAME: &str = "robots/uarm-fuzzy-sets.toml (built in)";
/// The sets trained on the simulated UARM, built in.
pub const BUILT_IN: &str = include_str!("../../robots/uarm-fuzzy-sets.toml");
/// The version of the format that this program reads.
const SCHEMA: u32 = 1;
/// No error of a joint is larger, and no set need be wider, degrees or degrees per second.
const LARGEST: f64 = 1e4;
/// The narrowest set, degrees or degrees per second: far below any encoder's count.
const NARROWEST: f64 = 1e-6;
/// Steepnesses between a constant and a step.
const STEEPNESS: [f64; 2] = [1e-3, 1e3];

/// Trained sets, with the firing they were trained for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainedSets {
    /// How rules fire: sets trained for one firing are not the best for the other.
    pub firing: Firing,
    /// The sets, rad/s and rad.
    pub sets: FuzzySets<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SetsFile {
    schema: u32,
    firing: Firing,
    #[serde(alias = "rate_error_deg_per_s")]
    velocity_error_deg_per_s: Vec<SetFile>,
    position_error_deg: Vec<SetFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SetFile {
    centre: f64,
    half_width: f64,
    steepness: f64,
}

impl TrainedSets {
    /// Reads a file.
    ///
    /// # Errors
    /// [`RobotError`] names file, field, value and expectation.
    pub fn load(file: &Path) -> Result<Self, RobotError> {
        let text = text_file::read(file).map_err(|source| RobotError::Read { file: file.to_owned(), source })?;
        Self::parse(file, &text)
    }

    /// The sets trained on the simulated UARM.
    ///
    /// # Errors
    /// None, unless the program was built with a wrong file; a test reads it.
    pub fn built_in() -> Result<Self, RobotError> {
        Self::parse(Path::new(BUILT_IN_NAME), BUILT_IN)
    }

    /// Sets from the text of a file; `name` is what messages call it.
    ///
    /// # Errors
    /// As [`TrainedSets::load`].
    pub fn parse(name: &Path, text: &str) -> Result<Self, RobotError> {
        let check = Checker::new(name);
        let file: SetsFile = toml::from_str(text)
            .map_err(|error| RobotError::Syntax { file: name.to_owned(), error: Box::new(error) })?;
        if file.schema != SCHEMA {
            return Err(check.refuse("schema", file.schema, format!("{SCHEMA}")));
        }
        Ok(Self {
            firing: file.firing,
            sets: FuzzySets {
                velocity: bells("velocity_error_deg_per_s", &file.velocity_error_deg_per_s, &check)?,
                position: bells("position_error_deg", &file.position_error_deg, &check)?,
            },
        })
    }

    /// The text of a file with these sets. `comment` goes above them, line by line.
    pub fn to_text(&self, comment: &str) -> String {
        let mut text = String::new();
        for line in comment.lines() {
            text.push_str(format!("# {line}").trim_end());
            text.push('\n');
        }
        let firing = firing_name(self.firing);
        text.push_str(&format!("\nschema = {SCHEMA}\nfiring = \"{firing}\"  # of the rules, in training as in use\n"));
        for (name, bells) in
            [("velocity_error_deg_per_s", &self.sets.velocity), ("position_error_deg", &self.sets.position)]
        {
            text.push_str(&format!("{name} = [\n"));
            for bell in bells {
                // Writing to a String cannot fail.
                let _ = writeln!(
                    text,
                    "  {{ centre = {:?}, half_width = {:?}, steepness = {:?} }},",
                    bell.centre().to_degrees(),
                    bell.half_width().to_degrees(),
                    bell.steepness()
                );
            }
            text.push_str("]\n");
        }
        text
    }
}

impl<const J: usize, const N: usize> Robot<J, N> {
    /// Lets the fuzzy ones of `laws` run with the sets in `file`, if one is given.
    ///
    /// # Errors
    /// [`RobotError`] if the file is wrong, its sets were trained for another firing than the laws have, or none of `laws` is fuzzy.
    pub fn load_fuzzy_sets(
        &mut self,
        file: Option<&Path>,
        mut laws: impl Iterator<Item = Law>,
    ) -> Result<(), RobotError> {
        let Some(file) = file else { return Ok(()) };
        let sets = TrainedSets::load(file)?;
        if !laws.any(|law| self.is_fuzzy(law)) {
            let fuzzy = Law::ALL.into_iter().filter(|law| self.is_fuzzy(*law)).map(Law::name);
            let expected = format!("one with fuzzy sets: {}", fuzzy.collect::<Vec<_>>().join(", "));
            return Err(Checker::new(file).refuse("controller", "one without", expected));
        }
        self.use_fuzzy_sets(file, &sets)
    }

    fn is_fuzzy(&self, law: Law) -> bool {
        self.controllers.firing(law).is_some()
    }

    /// What to say of a run with `law`, if it has trained sets.
    pub fn trained_sets_of(&self, law: Law) -> Option<String> {
        self.fuzzy_sets_crc32().filter(|_| self.is_fuzzy(law)).map(described)
    }

    /// Lets the fuzzy laws run with trained sets; `name` is what messages call their file.
    ///
    /// # Errors
    /// [`RobotError`] if the sets were trained for another firing than the laws have.
    pub fn use_fuzzy_sets(&mut self, name: &Path, trained: &TrainedSets) -> Result<(), RobotError> {
        for law in Law::ALL {
            let Some(firing) = self.controllers.firing(law) else { continue };
            if firing != trained.firing {
                let [expected, found] = [firing, trained.firing].map(firing_name);
                let expected = format!("{expected}, which controllers.{}.firing of the robot file says", law.name());
                return Err(Checker::new(name).refuse("firing", found, expected));
            }
        }
        self.fuzzy_sets = Some(trained.sets);
        Ok(())
    }

    /// CRC-32 of the trained sets as they are printed; none if there are none.
    pub fn fuzzy_sets_crc32(&self) -> Option<u32> {
        self.fuzzy_sets.map(|sets| crc32fast::hash(format!("{sets:?}").as_bytes()))
    }
}

/// As the files have it.
const fn firing_name(firing: Firing) -> &'static str {
    match firing {
        Firing::Minimum => "minimum",
        Firing::Product => "product",
    }
}

/// Trained sets in words.
pub fn described(crc32: u32) -> String {
    format!("fuzzy laws with trained sets (CRC-32 {crc32:08x})")
}

fn bells(
    field: &str,
    sets: &[SetFile],
    check: &Checker<'_>,
) -> Result<[GeneralisedBell<f64>; hinf_control::SETS], RobotError> {
    let sets: &[SetFile; hinf_control::SETS] = sets
        .try_into()
        .map_err(|_| check.refuse(field, format!("{} sets", sets.len()), format!("{}", hinf_control::SETS)))?;
    for (index, pair) in sets.windows(2).enumerate() {
        if pair[0].centre > pair[1].centre {
            let expected = format!("at least {}, the centre before it", pair[0].centre);
            return Err(check.refuse(format!("{field}[{}].centre", index + 1), pair[1].centre, expected));
        }
    }
    let mut bells = FuzzySets::untrained().velocity;
    for ((bell, set), index) in bells.iter_mut().zip(sets).zip(0..) {
        let name = |part: &str| format!("{field}[{index}].{part}");
        let centre = check.within(&name("centre"), set.centre, -LARGEST, LARGEST)?;
        let half_width = check.within(&name("half_width"), set.half_width, NARROWEST, LARGEST)?;
        let steepness = check.within(&name("steepness"), set.steepness, STEEPNESS[0], STEEPNESS[1])?;
        *bell = GeneralisedBell::new(BellShape {
            centre: centre.to_radians(),
            half_width: half_width.to_radians(),
            steepness,
        })
        .map_err(|error| check.refuse(format!("{field}[{index}]"), error, "a bell"))?;
    }
    Ok(bells)
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    use super::*;

    fn parsed(text: &str) -> Result<TrainedSets, String> {
        TrainedSets::parse(Path::new("sets.toml"), text).map_err(|error| error.to_string())
    }

    fn untrained() -> TrainedSets {
        TrainedSets { firing: Firing::Minimum, sets: FuzzySets::untrained() }
    }

    #[test]
    fn what_is_written_is_read() {
        let read = parsed(&untrained().to_text("two\n\nlines")).unwrap();
        assert_eq!(read.firing, Firing::Minimum);
        for (bell, expected) in read.sets.velocity.iter().zip(untrained().sets.velocity) {
            // Degrees and back cost a rounding or two.
            assert_relative_eq!(bell.centre(), expected.centre(), epsilon = 1e-15);
            assert_relative_eq!(bell.half_width(), expected.half_width(), max_relative = 1e-15);
            assert_eq!(bell.steepness(), expected.steepness());
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let good = untrained().to_text("");
        for (from, to, message) in [
            ("schema = 1", "schema = 2", "sets.toml: schema = 2: expected 1"),
            (
                "steepness = 2.0",
                "steepness = -2.0",
                "velocity_error_deg_per_s[0].steepness = -2: expected a number from",
            ),
            ("half_width = 10.0", "half_width = 0.0", "velocity_error_deg_per_s[0].half_width = 0: expected"),
            ("half_width = 10.0", "half_width = nan", "velocity_error_deg_per_s[0].half_width = NaN: expected"),
            ("centre = -20.0", "centre = 30.0", "velocity_error_deg_per_s[1].centre = 0: expected at least 30"),
            ("firing", "fire", "unknown field `fire`"),
            (
                "]\n",
                "{ centre = 9.0, half_width = 1.0, steepness = 1.0 }]\n",
                "velocity_error_deg_per_s = 4 sets: expected 3",
            ),
        ] {
            let text = good.replacen(from, to, 1);
            assert_ne!(text, good, "{from}");
            let found = parsed(&text).unwrap_err();
            assert!(found.contains(message), "{found}");
        }
    }

    #[test]
    fn sets_for_another_firing_are_refused() {
        let mut robot = Robot::load(None).unwrap();
        let product = TrainedSets { firing: Firing::Product, ..untrained() };
        let message = robot.use_fuzzy_sets(Path::new("sets.toml"), &product).unwrap_err().to_string();
        assert!(message.contains("firing = product: expected minimum"), "{message}");
        assert!(robot.fuzzy_sets.is_none());
        robot.use_fuzzy_sets(Path::new("sets.toml"), &untrained()).unwrap();
        assert!(robot.fuzzy_sets.is_some());
    }

    proptest! {
        #[test]
        fn no_text_makes_it_panic(text in any::<String>(), cut in 0..400_usize, middle in "[-0-9.e={}, a-z\n\"\\[\\]]{0,30}") {
            let _ = parsed(&text);
            let good = untrained().to_text("");
            let cut = cut.min(good.len());
            let _ = parsed(&format!("{}{middle}{}", &good[..cut], &good[cut..]));
        }
    }
}
