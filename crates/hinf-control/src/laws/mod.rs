//! One file per control law, each opening with its equations, and the one list of them.

mod register;
#[cfg(feature = "serde")]
mod sections;
mod state;

#[cfg(feature = "serde")]
use sections::{MissingSection, of_the_paper};

register::laws! {
    Nonlinear => nonlinear,
    Adaptive => adaptive,
    Neural => neural,
    NeuralModel => neural_model,
    Fuzzy => fuzzy,
    FuzzyModel => fuzzy_model,
    ComputedTorque => computed_torque,
}
