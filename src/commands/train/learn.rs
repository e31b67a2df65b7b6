//! ANFIS on the samples, from the grid of the paper's universes.

use std::num::NonZeroUsize;
use std::ops::ControlFlow;

use anfis::{
    AnfisError, Bell, DataSet, Epoch, InputSets, Keep, PremiseSets, StepMetric, StepSizeRule, Trained, Training,
    Universe,
};
use hinf_control::{BellError, BellShape, Firing, FuzzySets, GeneralisedBell};

/// The universe of velocity errors in the paper's Fig. 12, °/s.
pub const VELOCITY_UNIVERSE: [f64; 2] = [-20.0, 20.0];
/// The universe of position errors in the paper's Fig. 12, °.
pub const POSITION_UNIVERSE: [f64; 2] = [-2.0, 0.5];
/// Without a checking set, every so many samples check what the others train. Their samples
/// alternate joint by joint: so many joints, or a part of so many, would have one of them checked alone.
const CHECK_ONE_IN: usize = 5;

/// Jang's factors for the step: after four decreases of the error in a row, and after it went up and down twice.
const STEP_INCREASE: f64 = 1.1;
const STEP_DECREASE: f64 = 0.9;

/// What a training may be told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How often the sets move, at most.
    pub epochs: usize,
    /// The length of the first step, in units of half a universe and of one in steepness.
    pub step: f64,
    /// Stop after so many epochs without a lower checking error.
    pub patience: Option<NonZeroUsize>,
    /// How a rule's memberships become its strength: train with what runs.
    pub firing: Firing,
}

/// What a training gave.
#[derive(Clone, Debug)]
pub struct Learned {
    /// The sets, in rad/s and rad.
    pub sets: FuzzySets<f64>,
    /// Errors by epoch, and the system in degrees.
    pub trained: Trained,
    /// How many samples trained, how many checked.
    pub counts: [usize; 2],
}

/// Why nothing was learned.
#[derive(Debug, thiserror::Error)]
pub enum LearnError {
    /// The learning refused data or settings.
    #[error(transparent)]
    Anfis(#[from] AnfisError),
    /// It left a set that the controller refuses.
    #[error("the trained sets: {0}")]
    Sets(#[from] BellError),
    /// It left another number of sets.
    #[error("the trained sets: not three on each of two inputs")]
    Count,
}

/// Trains the grid on `data`. Without `checking` every fifth sample checks. `progress` sees each epoch.
///
/// # Errors
/// [`LearnError`].
pub fn learn(
    data: &DataSet,
    checking: Option<&DataSet>,
    settings: &Settings,
    progress: impl FnMut(&Epoch) -> ControlFlow<()>,
) -> Result<Learned, LearnError> {
    let split;
    let (data, checking) = match checking {
        Some(checking) => (data, checking),
        None => {
            split = data.split(CHECK_ONE_IN)?;
            (&split.0, &split.1)
        }
    };
    let training = Training {
        premise_updates: settings.epochs,
        step: StepSizeRule::new(settings.step, STEP_INCREASE, STEP_DECREASE)?,
        metric: StepMetric::Universe,
        keep: Keep::LowestCheckingError { patience: settings.patience },
        ..Training::default()
    };
    let trained = training.run(&grid(settings.firing)?, data, Some(checking), progress)?;
    Ok(Learned { sets: sets(trained.anfis.premises())?, trained, counts: [data.len(), checking.len()] })
}

/// The grid before training, in °/s and °.
fn grid(firing: Firing) -> Result<PremiseSets, AnfisError> {
    let [velocity, position] = [VELOCITY_UNIVERSE, POSITION_UNIVERSE].map(|[lower, upper]| Universe::new(lower, upper));
    let firing = match firing {
        Firing::Minimum => anfis::Firing::Minimum,
        Firing::Product => anfis::Firing::Product,
    };
    let inputs = vec![
        InputSets::grid("velocity error", "deg/s", velocity?, hinf_control::SETS)?,
        InputSets::grid("position error", "deg", position?, hinf_control::SETS)?,
    ];
    PremiseSets::new(firing, inputs)
}

/// Trained premises as the controller takes them.
fn sets(premises: &PremiseSets) -> Result<FuzzySets<f64>, LearnError> {
    let [velocity, position] = premises.inputs() else { return Err(LearnError::Count) };
    let bells = |input: &InputSets| -> Result<[GeneralisedBell<f64>; hinf_control::SETS], LearnError> {
        let bell = |bell: &Bell| {
            GeneralisedBell::new(BellShape {
                centre: bell.centre().to_radians(),
                half_width: bell.half_width().to_radians(),
                steepness: bell.steepness(),
            })
        };
        let bells = input.sets().iter().map(bell).collect::<Result<Vec<_>, _>>()?;
        bells.try_into().map_err(|_| LearnError::Count)
    };
    Ok(FuzzySets { velocity: bells(velocity)?, position: bells(position)? })
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    #[test]
    fn the_grid_is_the_one_that_the_controller_runs_with_when_untrained() {
        let (grid, untrained) = (sets(&grid(Firing::Minimum).unwrap()).unwrap(), FuzzySets::untrained());
        let all = |sets: &FuzzySets<f64>| sets.velocity.into_iter().chain(sets.position).collect::<Vec<_>>();
        for (bell, expected) in all(&grid).iter().zip(all(&untrained)) {
            // The same numbers in another order of operations.
            assert_relative_eq!(bell.centre(), expected.centre(), epsilon = 1e-15);
            assert_relative_eq!(bell.half_width(), expected.half_width(), max_relative = 1e-14);
            assert_eq!(bell.steepness(), expected.steepness());
        }
    }

    #[test]
    fn what_sets_of_this_shape_can_express_is_learned_the_same_each_time() {
        // A bend at a velocity error of 5 deg/s, where the grid has no set.
        let wave = (0..400).map(|k| 0.03 * f64::from(k));
        let samples = wave.map(|t| {
            let (rate, position) = (15.0 * (7.0 * t).sin(), -0.75 + 1.2 * (11.0 * t).cos());
            ([rate, position], 0.02 * (0.4 * (rate - 5.0)).tanh() + 0.01 * position)
        });
        let data = DataSet::new(samples).unwrap();
        let settings = Settings { epochs: 20, step: 0.05, patience: None, firing: Firing::Minimum };
        let learn = || learn(&data, None, &settings, |_| ControlFlow::Continue(())).unwrap();
        let learned = learn();
        let history = &learned.trained.history;
        assert!(learned.trained.kept_epoch().rmse < 0.8 * history[0].rmse, "{:?}", learned.trained.kept_epoch());
        assert_eq!(learned.counts, [320, 80]);
        assert_eq!(learned.sets, learn().sets);
    }
}
