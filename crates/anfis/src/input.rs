//! One input: its universe of discourse and the sets on it.

use crate::bell::{Bell, BellParameters};
use crate::error::AnfisError;
use crate::limits::{MINIMUM_RELATIVE_SPAN, MINIMUM_SPAN, in_magnitude};

/// The steepness b of a grid's bells before training (Jang's choice).
const GRID_STEEPNESS: f64 = 2.0;

/// A universe of discourse: the range on which sets are laid out. In files `[lower, upper]`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "[f64; 2]", into = "[f64; 2]")
)]
pub struct Universe {
    lower: f64,
    upper: f64,
}

#[cfg(feature = "serde")]
impl TryFrom<[f64; 2]> for Universe {
    type Error = AnfisError;

    fn try_from([lower, upper]: [f64; 2]) -> Result<Self, AnfisError> {
        Self::new(lower, upper)
    }
}

#[cfg(feature = "serde")]
impl From<Universe> for [f64; 2] {
    fn from(universe: Universe) -> Self {
        [universe.lower, universe.upper]
    }
}

impl Universe {
    /// The range from `lower` to `upper`, in the input's unit.
    ///
    /// # Errors
    /// [`AnfisError::Universe`] unless both ends are finite and the upper is above the lower by more than rounding.
    pub fn new(lower: f64, upper: f64) -> Result<Self, AnfisError> {
        let least = MINIMUM_SPAN.max(MINIMUM_RELATIVE_SPAN * lower.abs().max(upper.abs()));
        if in_magnitude(lower) && in_magnitude(upper) && upper - lower >= least {
            Ok(Self { lower, upper })
        } else {
            Err(AnfisError::Universe { lower, upper })
        }
    }

    /// The lower end, in the unit of the input.
    #[must_use]
    pub const fn lower(&self) -> f64 {
        self.lower
    }

    /// The upper end, in the unit of the input.
    #[must_use]
    pub const fn upper(&self) -> f64 {
        self.upper
    }

    /// Upper less lower end, in the unit of the input; > 0.
    #[must_use]
    pub fn span(&self) -> f64 {
        self.upper - self.lower
    }

    /// `points` abscissae evenly spaced from end to end, both included (the middle for one point).
    pub fn abscissae(&self, points: usize) -> impl Iterator<Item = f64> + use<> {
        let Self { lower, upper } = *self;
        let spacing = (upper - lower) / (points.max(2) - 1) as f64;
        (0..points).map(move |index| match (index, points) {
            (_, 1) => lower + 0.5 * (upper - lower),
            (index, points) if index + 1 == points => upper,
            (index, _) => lower + spacing * index as f64,
        })
    }
}

/// One input: its name, unit and universe, and the sets on it in ascending order of their centres.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(try_from = "InputRecord"))]
pub struct InputSets {
    name: String,
    unit: String,
    universe: Universe,
    sets: Vec<Bell>,
}

/// An input as it stands in a file, not yet validated.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct InputRecord {
    name: String,
    unit: String,
    universe: Universe,
    sets: Vec<Bell>,
}

#[cfg(feature = "serde")]
impl TryFrom<InputRecord> for InputSets {
    type Error = AnfisError;

    fn try_from(record: InputRecord) -> Result<Self, AnfisError> {
        Self::new(record.name, record.unit, record.universe, record.sets)
    }
}

impl InputSets {
    /// An input with given sets.
    ///
    /// # Errors
    /// [`AnfisError::TooFew`] without a set, [`AnfisError::CentreOrder`] when the centres descend.
    pub fn new(
        name: impl Into<String>,
        unit: impl Into<String>,
        universe: Universe,
        sets: Vec<Bell>,
    ) -> Result<Self, AnfisError> {
        let name = name.into();
        at_least("sets of an input", sets.len(), 1)?;
        if let Some([previous, next]) = sets.windows(2).find(|pair| pair[0].centre() > pair[1].centre()) {
            return Err(AnfisError::CentreOrder { input: name, previous: previous.centre(), next: next.centre() });
        }
        Ok(Self { name, unit: unit.into(), universe, sets })
    }

    /// `count` bells evenly spaced with the outer centres on the ends of the universe: a is half the spacing, so that
    /// neighbours cross at ½, and b = 2 (Jang's start). A single bell stands in the middle and is as wide as the universe.
    ///
    /// # Errors
    /// [`AnfisError::TooFew`] for a count of 0.
    pub fn grid(
        name: impl Into<String>,
        unit: impl Into<String>,
        universe: Universe,
        count: usize,
    ) -> Result<Self, AnfisError> {
        let half_width = 0.5 * universe.span() / (count.max(2) - 1) as f64;
        let sets = universe
            .abscissae(count)
            .map(|centre| Bell::new(BellParameters { half_width, steepness: GRID_STEEPNESS, centre }))
            .collect::<Result<Vec<_>, _>>()?;
        Self::new(name, unit, universe, sets)
    }

    /// The input's name, for plots and files.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The unit in which the input, the universe, the centres and half widths are given.
    #[must_use]
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// The universe of discourse.
    #[must_use]
    pub const fn universe(&self) -> Universe {
        self.universe
    }

    /// The sets in ascending order of their centres; never empty.
    #[must_use]
    pub fn sets(&self) -> &[Bell] {
        &self.sets
    }

    /// The same input with other sets, which the caller has put in order.
    pub(crate) fn with_sets(&self, sets: Vec<Bell>) -> Self {
        Self { sets, ..self.clone() }
    }

    /// Each set's membership function sampled at `points` abscissae over the universe: what a plot draws.
    #[must_use]
    pub fn curves(&self, points: usize) -> MembershipCurves {
        let abscissae: Vec<f64> = self.universe.abscissae(points).collect();
        let memberships =
            self.sets.iter().map(|bell| abscissae.iter().map(|&x| bell.membership(x)).collect()).collect();
        MembershipCurves { abscissae, memberships }
    }
}

/// Sampled membership functions of one input.
#[derive(Clone, Debug, PartialEq)]
pub struct MembershipCurves {
    /// The points, in the input's unit.
    pub abscissae: Vec<f64>,
    /// Per set, μ at each abscissa.
    pub memberships: Vec<Vec<f64>>,
}

pub(crate) fn at_least(what: &'static str, found: usize, expected: usize) -> Result<(), AnfisError> {
    if found < expected { Err(AnfisError::TooFew { what, found, expected }) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn universe() -> Universe {
        Universe::new(-1.0, 1.0).unwrap()
    }

    #[test]
    fn a_grid_covers_its_universe_and_neighbours_cross_at_one_half() {
        let input = InputSets::grid("x", "m", Universe::new(-2.0, 0.5).unwrap(), 3).unwrap();
        let centres: Vec<f64> = input.sets().iter().map(Bell::centre).collect();
        assert_eq!(centres, [-2.0, -0.75, 0.5]);
        assert!(input.sets().iter().all(|bell| bell.half_width() == 0.625 && bell.steepness() == 2.0));
        assert_eq!(input.sets()[0].membership(-1.375), 0.5);
        let single = InputSets::grid("x", "m", universe(), 1).unwrap();
        assert_eq!((single.sets()[0].centre(), single.sets()[0].half_width()), (0.0, 1.0));
    }

    #[test]
    fn illegal_inputs_cannot_be_built() {
        assert!(matches!(Universe::new(1.0, 1.0), Err(AnfisError::Universe { .. })));
        assert!(matches!(Universe::new(0.0, f64::NAN), Err(AnfisError::Universe { .. })));
        let descending =
            [1.0, 0.0].map(|centre| Bell::new(BellParameters { half_width: 1.0, steepness: 2.0, centre }).unwrap());
        assert!(matches!(
            InputSets::new("x", "", universe(), descending.to_vec()),
            Err(AnfisError::CentreOrder { .. })
        ));
        assert!(matches!(InputSets::grid("x", "", universe(), 0), Err(AnfisError::TooFew { .. })));
    }

    #[test]
    fn curves_are_sampled_from_end_to_end() {
        let curves = InputSets::grid("x", "m", universe(), 2).unwrap().curves(5);
        assert_eq!(curves.abscissae, [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert_eq!(curves.memberships[0][0], 1.0);
        assert_eq!(curves.memberships[1][2], 0.5);
    }
}
