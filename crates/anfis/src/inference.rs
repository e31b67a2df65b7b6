//! A trained system: premises, consequents and their output.

use crate::data::DataSet;
use crate::error::AnfisError;
use crate::limits::in_magnitude;
use crate::network::{Network, weighted_output};
use crate::premises::PremiseSets;

/// A first-order Takagi–Sugeno system: y = Σ w̄_r (f_r0 + f_r1 x_1 + … + f_rn x_n), w̄ the normalised firing strengths.
///
/// Serialisable with the feature `serde`, so that a trained system can be kept whole; a controller takes its
/// [`premises`](Anfis::premises) alone.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(try_from = "AnfisRecord"))]
pub struct Anfis {
    premises: PremiseSets,
    consequents: Vec<f64>,
}

/// A system as it stands in a file, not yet validated.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct AnfisRecord {
    premises: PremiseSets,
    consequents: Vec<f64>,
}

#[cfg(feature = "serde")]
impl TryFrom<AnfisRecord> for Anfis {
    type Error = AnfisError;

    fn try_from(record: AnfisRecord) -> Result<Self, AnfisError> {
        Self::new(record.premises, record.consequents)
    }
}

impl Anfis {
    /// A system of given premises and consequents. `consequents` holds per rule, in the order of [`PremiseSets::rule`],
    /// the constant and then one coefficient per input: n + 1 values.
    ///
    /// # Errors
    /// [`AnfisError::Length`] for another number of consequents, [`AnfisError::Consequent`] for one that is not finite.
    pub fn new(premises: PremiseSets, consequents: Vec<f64>) -> Result<Self, AnfisError> {
        let expected = parameters(&premises);
        if consequents.len() != expected {
            return Err(AnfisError::Length { what: "consequents", found: consequents.len(), expected });
        }
        match consequents.iter().find(|value| !value.is_finite()) {
            Some(&value) => Err(AnfisError::Consequent(value)),
            None => Ok(Self { premises, consequents }),
        }
    }

    /// The premise sets.
    #[must_use]
    pub const fn premises(&self) -> &PremiseSets {
        &self.premises
    }

    /// The consequents, rule by rule, each rule's constant first.
    #[must_use]
    pub fn consequents(&self) -> &[f64] {
        &self.consequents
    }

    /// The output at one point. Finite everywhere the data set's range admits, also far outside the universes.
    ///
    /// # Errors
    /// [`AnfisError::Length`] for another number of inputs, [`AnfisError::Sample`] for one that is not finite or too large.
    pub fn output(&self, x: &[f64]) -> Result<f64, AnfisError> {
        let expected = self.premises.inputs().len();
        if x.len() != expected {
            return Err(AnfisError::Length { what: "inputs", found: x.len(), expected });
        }
        if let Some(&value) = x.iter().find(|value| !in_magnitude(**value)) {
            return Err(AnfisError::Sample { sample: 0, value });
        }
        let network = Network::new(&self.premises);
        let (mut grades, mut strengths) = (vec![0.0; network.bells.len()], vec![0.0; network.rules()]);
        network.fire(x, &mut grades, &mut strengths);
        Ok(weighted_output(&strengths, &self.consequents, x))
    }

    /// The outputs at all samples of a set, in order.
    ///
    /// # Errors
    /// [`AnfisError::Length`] when the set has another number of inputs.
    pub fn outputs(&self, data: &DataSet) -> Result<Vec<f64>, AnfisError> {
        check_width(&self.premises, data)?;
        let network = Network::new(&self.premises);
        let fired = network.fire_all(data);
        let rows = fired.strengths.chunks_exact(network.rules());
        Ok(data.samples().zip(rows).map(|((x, _), row)| weighted_output(row, &self.consequents, x)).collect())
    }

    /// Root of the mean squared difference between output and target, in the target's unit.
    ///
    /// # Errors
    /// As [`Anfis::outputs`].
    pub fn rmse(&self, data: &DataSet) -> Result<f64, AnfisError> {
        Ok(root_mean_square(self.outputs(data)?.iter().zip(data.targets()).map(|(y, target)| y - target)))
    }
}

/// Number of consequent parameters: rules times (inputs + 1).
pub(crate) fn parameters(premises: &PremiseSets) -> usize {
    premises.rules() * (premises.inputs().len() + 1)
}

pub(crate) fn check_width(premises: &PremiseSets, data: &DataSet) -> Result<(), AnfisError> {
    let (found, expected) = (data.width(), premises.inputs().len());
    if found == expected { Ok(()) } else { Err(AnfisError::Length { what: "inputs per sample", found, expected }) }
}

pub(crate) fn root_mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    (values.map(|value| value * value).sum::<f64>() / count).sqrt()
}
