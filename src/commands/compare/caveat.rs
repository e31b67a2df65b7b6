//! What must be said wherever numbers of the fitted plant stand beside the paper's.

use uarm_sim::UarmPlantParameters;

use crate::robot::Robot;
use crate::simulated_plant::PlantChoice;

const FITTED_PLANT_CAVEAT: &str = "\
The imperfect plant is one fit of 13 parameters to the 12 numbers of Table 4, chosen after 26 fits. It shows what an
imperfect robot does to the controllers, not what the paper's robot was: that L2 and E come near Table 4 is its making.
On the plants near it, too (--monte-carlo), `nonlinear` is worst in L2, but only as the fit has it, with the base
acceleration eliminated: see `nonlinear-omitted`. The order in E, and among the adaptive laws in L2, shows nothing.";

/// What must be said of numbers of this plant: something, if it was fitted to the paper's.
pub fn caveat<const J: usize, const N: usize>(robot: &Robot<J, N>, plant: PlantChoice) -> Option<&'static str> {
    let is_fitted = plant == PlantChoice::Uarm && robot.plant.uarm == UarmPlantParameters::fitted();
    (is_fitted && robot.is_the_papers()).then_some(FITTED_PLANT_CAVEAT)
}
