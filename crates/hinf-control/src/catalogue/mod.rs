//! The one list of control laws: their names, what the paper says of each, and how each is built from options.

mod any;
mod options;

pub use any::AnyController;
pub use options::{AdaptationWeights, BuildError, ControllerOptions, LimitAction, ParameterLimits};

/// A control law of this crate. The register: a new law is added here, and the compiler asks for the rest of this module.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Law {
    /// Controller 1, the model-based nonlinear H∞ law (paper eq. 11).
    Nonlinear,
    /// Controller 2, with a linear parametrisation (paper eqs. 13–21).
    Adaptive,
    /// Controller 3, neural networks without a model (paper eqs. 22–31).
    Neural,
    /// Controller 4, neural networks beside the nominal model (paper eqs. 32–37).
    NeuralModel,
    /// Controller 5, fuzzy systems without a model (paper eqs. 38–43).
    Fuzzy,
    /// Controller 6, fuzzy systems beside the nominal model (paper eqs. 44–46).
    FuzzyModel,
    /// The baseline, not in the paper: PD+ with the computed torque of the nominal model.
    ComputedTorque,
}

/// The paper's performance indices of one law (Table 4): means of five experiments on the UARM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedIndices {
    /// L2 of the state tracking error.
    pub tracking: f64,
    /// E, the summed torque, N·m·s.
    pub torque: f64,
}

impl Law {
    /// Every law, in the paper's order, the baseline last.
    pub const ALL: [Self; 7] = [
        Self::Nonlinear,
        Self::Adaptive,
        Self::Neural,
        Self::NeuralModel,
        Self::Fuzzy,
        Self::FuzzyModel,
        Self::ComputedTorque,
    ];

    /// The paper's six laws, in its order.
    pub const PAPER: [Self; 6] =
        [Self::Nonlinear, Self::Adaptive, Self::Neural, Self::NeuralModel, Self::Fuzzy, Self::FuzzyModel];

    /// The name in files and on command lines.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nonlinear => "nonlinear",
            Self::Adaptive => "adaptive",
            Self::Neural => "neural",
            Self::NeuralModel => "neural-model",
            Self::Fuzzy => "fuzzy",
            Self::FuzzyModel => "fuzzy-model",
            Self::ComputedTorque => "computed-torque",
        }
    }

    /// The law of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|law| law.name() == name)
    }

    /// What the law is, in a line.
    pub const fn description(self) -> &'static str {
        match self {
            Self::Nonlinear => "nonlinear H-infinity control with the nominal model",
            Self::Adaptive => "adaptive nonlinear H-infinity control, linear parametrisation",
            Self::Neural => "adaptive neural network nonlinear H-infinity control, no model",
            Self::NeuralModel => "adaptive neural network nonlinear H-infinity control beside the nominal model",
            Self::Fuzzy => "adaptive fuzzy nonlinear H-infinity control, no model",
            Self::FuzzyModel => "adaptive fuzzy nonlinear H-infinity control beside the nominal model",
            Self::ComputedTorque => "PD+ with the computed torque of the nominal model (baseline, not in the paper)",
        }
    }

    /// The scalar z of the paper's adaptation weight Z = zI (Table 3); `None` for a law that does not adapt.
    pub const fn published_adaptation_weight(self) -> Option<f64> {
        match self {
            Self::Adaptive | Self::Neural => Some(10.0),
            Self::NeuralModel => Some(100.0),
            Self::Fuzzy => Some(0.8),
            Self::FuzzyModel => Some(20.0),
            Self::Nonlinear | Self::ComputedTorque => None,
        }
    }

    /// The paper's Table 4; `None` for a law that is not in the paper.
    pub const fn published_indices(self) -> Option<PublishedIndices> {
        let (tracking, torque) = match self {
            Self::Nonlinear => (0.0778, 0.1419),
            Self::Adaptive => (0.0379, 0.1244),
            Self::Neural => (0.0317, 0.1322),
            Self::NeuralModel => (0.0292, 0.1406),
            Self::Fuzzy => (0.0340, 0.1563),
            Self::FuzzyModel => (0.0318, 0.1788),
            Self::ComputedTorque => return None,
        };
        Some(PublishedIndices { tracking, torque })
    }
}
