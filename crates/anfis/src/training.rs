//! Hybrid learning: least squares forward, gradient backward, epoch after epoch.

use std::num::NonZeroUsize;
use std::ops::{ControlFlow, RangeInclusive};

use crate::bell::{Bell, BellParameters};
use crate::data::DataSet;
use crate::error::AnfisError;
use crate::gradient::BellGradient;
use crate::inference::Anfis;
use crate::inference::{check_width, parameters};
use crate::input::InputSets;
use crate::limits::{MAXIMUM_STEEPNESS, MINIMUM_RELATIVE_HALF_WIDTH, MINIMUM_STEEPNESS};
use crate::pass::{ConsequentEstimator, Pass};
use crate::premises::PremiseSets;
use crate::step_size::StepSize;
use crate::step_size::StepSizeRule;

/// The units in which the length of a step is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum StepMetric {
    /// Each input's own unit, as Jang has it: right where all inputs have a like range.
    #[default]
    Raw,
    /// Half the span of each input's universe: the sets of all inputs move alike whatever the units, and the result does
    /// not depend on them.
    Universe,
}

/// Which values the training may give to the steepness b of a bell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum SteepnessRange {
    /// b stays at or above [`MINIMUM_STEEPNESS`]: every set remains a bell.
    #[default]
    Positive,
    /// b may pass through 0, which turns a bell inside out (0 at its centre, 1 far away). Jang's program does not forbid
    /// it, so that his figures are compared with this. Such sets are for study: files with them are refused when read.
    Unrestricted,
}

impl SteepnessRange {
    const fn range(self) -> RangeInclusive<f64> {
        match self {
            Self::Positive => MINIMUM_STEEPNESS..=MAXIMUM_STEEPNESS,
            Self::Unrestricted => -MAXIMUM_STEEPNESS..=MAXIMUM_STEEPNESS,
        }
    }
}

/// Which of the epochs' systems is handed back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Keep {
    /// The last one.
    Last,
    /// The one of the lowest error on the training set.
    #[default]
    LowestTrainingError,
    /// The one of the lowest error on the checking set: the remedy against overfitting.
    LowestCheckingError {
        /// Early stopping: ends the training after so many epochs without a new lowest checking error.
        patience: Option<NonZeroUsize>,
    },
}

/// The options of a training run. The default is Jang's: exact least squares, step 0.01, ×1.1, ×0.9.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Training {
    /// How often the premises move, at most. 0 fits the consequents only.
    pub premise_updates: usize,
    /// Start and heuristics of the step size.
    pub step: StepSizeRule,
    /// Units of the step size.
    pub metric: StepMetric,
    /// Which values the steepness of a bell may take.
    pub steepness_range: SteepnessRange,
    /// How the consequents are found.
    pub estimator: ConsequentEstimator,
    /// Which system is handed back, and early stopping.
    pub keep: Keep,
}

/// What is known after an epoch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Epoch {
    /// How often the premises have moved; 0 for the first record.
    pub premise_updates: usize,
    /// Root mean square error on the training set, in the target's unit.
    pub rmse: f64,
    /// Root mean square error on the checking set, where there is one.
    pub checking_rmse: Option<f64>,
    /// The length of the step that follows.
    pub step: f64,
    /// Numerical rank of the least squares problem, where the estimator reveals it.
    pub rank: Option<usize>,
}

/// Why a training ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// All updates were made.
    Completed,
    /// The checking error had not fallen for `patience` epochs.
    OutOfPatience,
    /// The gradient vanished.
    Stationary,
    /// The progress callback asked for it.
    Interrupted,
}

/// The outcome of a training.
#[derive(Clone, Debug, PartialEq)]
pub struct Trained {
    /// The system kept.
    pub anfis: Anfis,
    /// Index of the kept system's epoch in `history`.
    pub kept: usize,
    /// One record per epoch, the first before any move.
    pub history: Vec<Epoch>,
    /// Number of consequent parameters; an epoch of a lower rank did not determine them all.
    pub parameters: usize,
    /// Why the training ended.
    pub stopped: StopReason,
}

impl Trained {
    /// The record of the kept system.
    #[must_use]
    pub fn kept_epoch(&self) -> &Epoch {
        &self.history[self.kept]
    }

    /// The epochs in which the rank had dropped below the number of parameters. Their consequents are the shortest of
    /// many that fit as well: fewer sets, or data that cover the universe better, would help.
    pub fn rank_drops(&self) -> impl Iterator<Item = &Epoch> {
        self.history.iter().filter(|epoch| epoch.rank.is_some_and(|rank| rank < self.parameters))
    }
}

impl Training {
    /// Trains the sets of `start` on `training`. The same input gives the same bits.
    ///
    /// Each epoch: consequents by least squares, errors, gradient, a move of the premises by the current step against the
    /// normalised gradient, then the step size's heuristics. `progress` sees each epoch's record, and may end the
    /// training. Half widths stay positive, steepnesses in their range; each input's sets stay in the order of their centres.
    ///
    /// # Errors
    /// [`AnfisError::Length`] when a data set has another number of inputs than `start`; [`AnfisError::NoCheckingSet`]
    /// when [`Keep::LowestCheckingError`] is asked for without one.
    pub fn run(
        &self,
        start: &PremiseSets,
        training: &DataSet,
        checking: Option<&DataSet>,
        mut progress: impl FnMut(&Epoch) -> ControlFlow<()>,
    ) -> Result<Trained, AnfisError> {
        if let Some(checking) = checking {
            check_width(start, checking)?;
        } else if let Keep::LowestCheckingError { .. } = self.keep {
            return Err(AnfisError::NoCheckingSet);
        }
        let mut premises = start.clone();
        let mut step = StepSize::new(self.step, self.largest_step(start));
        let mut history = Vec::with_capacity(self.premise_updates.saturating_add(1).min(1 << 16));
        let mut best: Option<(usize, f64, Anfis)> = None;
        let stopped = loop {
            let pass = Pass::new(&premises, training, self.estimator)?;
            let anfis = pass.system(premises.clone())?;
            let epoch = Epoch {
                premise_updates: history.len(),
                rmse: pass.rmse(),
                checking_rmse: checking.map(|data| anfis.rmse(data)).transpose()?,
                step: step.current(),
                rank: pass.rank(),
            };
            history.push(epoch);
            let measure = self.measure(&epoch);
            if best.as_ref().is_none_or(|(_, lowest, _)| measure < *lowest) {
                best = Some((epoch.premise_updates, measure, anfis));
            }
            let since_best = best.as_ref().map_or(0, |(index, ..)| epoch.premise_updates - index);
            if progress(&epoch).is_break() {
                break StopReason::Interrupted;
            } else if self.out_of_patience(since_best) {
                break StopReason::OutOfPatience;
            } else if epoch.premise_updates >= self.premise_updates {
                break StopReason::Completed;
            }
            match self.moved(&premises, pass.gradient(), step.current()) {
                Some(next) => premises = next,
                None => break StopReason::Stationary,
            }
            step.observe(epoch.rmse);
        };
        let (kept, _, anfis) = best.ok_or(AnfisError::NoCheckingSet)?;
        Ok(Trained { anfis, kept, history, parameters: parameters(start), stopped })
    }

    /// What the kept system has the least of.
    fn measure(&self, epoch: &Epoch) -> f64 {
        match self.keep {
            Keep::Last => -(epoch.premise_updates as f64),
            Keep::LowestTrainingError => epoch.rmse,
            Keep::LowestCheckingError { .. } => epoch.checking_rmse.unwrap_or(f64::INFINITY),
        }
    }

    fn out_of_patience(&self, since_best: usize) -> bool {
        match self.keep {
            Keep::LowestCheckingError { patience: Some(patience) } => since_best >= patience.get(),
            _ => false,
        }
    }

    /// The length of one unit of an input in the step's metric.
    fn unit(&self, input: &InputSets) -> f64 {
        match self.metric {
            StepMetric::Raw => 1.0,
            StepMetric::Universe => 0.5 * input.universe().span(),
        }
    }

    /// The widest universe: a longer step would throw the sets out of it.
    fn largest_step(&self, premises: &PremiseSets) -> f64 {
        premises.inputs().iter().map(|input| input.universe().span() / self.unit(input)).fold(0.0, f64::max)
    }

    /// The premises after a step of length `step` against the gradient; `None` where the gradient vanishes.
    fn moved(&self, premises: &PremiseSets, gradient: &[BellGradient], step: f64) -> Option<PremiseSets> {
        let bells = || premises.inputs().iter().flat_map(|input| input.sets().iter().map(move |bell| (input, bell)));
        let scaled: Vec<[f64; 3]> = bells()
            .zip(gradient)
            .map(|((input, bell), d)| {
                let unit = self.unit(input);
                // A steepness at the end of its range cannot follow: it must not shorten the others' step.
                let range = self.steepness_range.range();
                let held = if d.steepness > 0.0 {
                    bell.steepness() <= *range.start()
                } else {
                    bell.steepness() >= *range.end()
                };
                [d.half_width * unit, if held { 0.0 } else { d.steepness }, d.centre * unit]
            })
            .collect();
        // Divided by the largest entry first, so that no square over- or underflows.
        let largest = scaled.as_flattened().iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
        if largest == 0.0 {
            return None;
        }
        let norm = scaled.as_flattened().iter().map(|entry| (entry / largest) * (entry / largest)).sum::<f64>().sqrt();
        let moved = bells().zip(&scaled).map(|((input, bell), direction)| {
            let unit = self.unit(input);
            let by = direction.map(|entry| -step * (entry / largest / norm));
            let to = BellParameters {
                half_width: bell.half_width() + unit * by[0],
                steepness: bell.steepness() + by[1],
                centre: bell.centre() + unit * by[2],
            };
            Bell::nearest(to, MINIMUM_RELATIVE_HALF_WIDTH * input.universe().span(), self.steepness_range.range())
        });
        Some(premises.with_bells(moved))
    }
}
