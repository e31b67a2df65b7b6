//! Premise sets: the grid of rules that the sets of all inputs span.

use crate::bell::Bell;
use crate::error::AnfisError;
use crate::input::InputSets;
use crate::input::at_least;
use crate::limits::MAXIMUM_RULES;

/// How the memberships of a rule's premises become its firing strength.
///
/// Train with the one that runs: sets trained for the product are not the best ones for the minimum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Firing {
    /// w = Π μ, Jang's choice: smooth in the premise parameters.
    #[default]
    Product,
    /// w = min μ, the choice of Pazelli et al. (2011), eq. 38. The gradient passes through the least membership (the
    /// first input's where several are equal).
    Minimum,
}

/// The premises of a Takagi–Sugeno system: a grid partition of the input space.
///
/// The rules are all combinations of one set per input, the first input's set changing slowest: with three sets on each
/// of (velocity error, position error), rule 3·i + j has velocity set i and position set j.
/// Serialisable with the feature `serde`; what is read is validated.
///
/// # Example
/// ```
/// # use anfis::{Firing, InputSets, PremiseSets, Universe};
/// let velocity = InputSets::grid("velocity error", "deg/s", Universe::new(-20.0, 20.0)?, 3)?;
/// let position = InputSets::grid("position error", "deg", Universe::new(-2.0, 0.5)?, 3)?;
/// let sets = PremiseSets::new(Firing::Minimum, vec![velocity, position])?;
/// assert_eq!(sets.rules(), 9);
/// assert_eq!(sets.rule(5).collect::<Vec<_>>(), [1, 2]);
/// # Ok::<(), anfis::AnfisError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(try_from = "PremiseRecord"))]
pub struct PremiseSets {
    firing: Firing,
    inputs: Vec<InputSets>,
}

/// Premises as they stand in a file, not yet validated.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct PremiseRecord {
    firing: Firing,
    inputs: Vec<InputSets>,
}

#[cfg(feature = "serde")]
impl TryFrom<PremiseRecord> for PremiseSets {
    type Error = AnfisError;

    fn try_from(record: PremiseRecord) -> Result<Self, AnfisError> {
        Self::new(record.firing, record.inputs)
    }
}

impl PremiseSets {
    /// The grid of rules over `inputs`.
    ///
    /// # Errors
    /// [`AnfisError::TooFew`] without an input, [`AnfisError::TooManyRules`] above [`MAXIMUM_RULES`].
    pub fn new(firing: Firing, inputs: Vec<InputSets>) -> Result<Self, AnfisError> {
        at_least("inputs", inputs.len(), 1)?;
        let mut rules = 1_usize;
        for input in &inputs {
            rules = rules.saturating_mul(input.sets().len());
            if rules > MAXIMUM_RULES {
                return Err(AnfisError::TooManyRules);
            }
        }
        Ok(Self { firing, inputs })
    }

    /// How memberships become firing strengths.
    #[must_use]
    pub const fn firing(&self) -> Firing {
        self.firing
    }

    /// The inputs in their order; never empty.
    #[must_use]
    pub fn inputs(&self) -> &[InputSets] {
        &self.inputs
    }

    /// Number of rules: the product of the numbers of sets.
    #[must_use]
    pub fn rules(&self) -> usize {
        self.inputs.iter().map(|input| input.sets().len()).product()
    }

    /// The set that rule `rule` takes from each input, in the inputs' order.
    pub fn rule(&self, rule: usize) -> impl Iterator<Item = usize> + use<'_> {
        let mut stride = self.rules();
        self.inputs.iter().map(move |input| {
            stride /= input.sets().len();
            rule / stride % input.sets().len()
        })
    }

    /// Number of bells over all inputs.
    #[must_use]
    pub fn bells(&self) -> usize {
        self.inputs.iter().map(|input| input.sets().len()).sum()
    }

    /// The same inputs with other sets, each input's sorted by centre. Sorting only renumbers rules.
    pub(crate) fn with_bells(&self, mut bells: impl Iterator<Item = Bell>) -> Self {
        let inputs = self.inputs.iter().map(|input| {
            let mut sets: Vec<Bell> = bells.by_ref().take(input.sets().len()).collect();
            sets.sort_by(|left, right| left.centre().total_cmp(&right.centre()));
            input.with_sets(sets)
        });
        Self { firing: self.firing, inputs: inputs.collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Universe;

    fn universe() -> Universe {
        Universe::new(-1.0, 1.0).unwrap()
    }

    #[test]
    fn the_first_input_changes_slowest() {
        let inputs = vec![
            InputSets::grid("x", "", universe(), 2).unwrap(),
            InputSets::grid("y", "", universe(), 3).unwrap(),
            InputSets::grid("z", "", universe(), 2).unwrap(),
        ];
        let sets = PremiseSets::new(Firing::Product, inputs).unwrap();
        let rules: Vec<Vec<usize>> = (0..sets.rules()).map(|rule| sets.rule(rule).collect()).collect();
        assert_eq!(rules[0], [0, 0, 0]);
        assert_eq!(rules[1], [0, 0, 1]);
        assert_eq!(rules[2], [0, 1, 0]);
        assert_eq!(rules[11], [1, 2, 1]);
    }

    #[test]
    fn illegal_sets_cannot_be_built() {
        assert!(matches!(PremiseSets::new(Firing::Minimum, vec![]), Err(AnfisError::TooFew { .. })));
        let many = vec![InputSets::grid("x", "", universe(), 100).unwrap(); 3];
        assert_eq!(PremiseSets::new(Firing::Minimum, many), Err(AnfisError::TooManyRules));
    }
}
