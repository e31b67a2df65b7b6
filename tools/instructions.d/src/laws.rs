//! A step of each law: state in, torque out, parameters adapted.

use crate::case;
use dem_model::{Scalar, ThreeLinkDem};
use hinf_control::adaptation::{Adaptation, AdaptiveOutput, ParameterBox, ParameterEstimator, ScalarWeight};
use hinf_control::{
    AdaptationGuard, BaseMeasurement, BuildContext, Controller, ControllerSettings, FUZZY_PARAMETERS, Law, Measurement,
    QuinticReference,
};
use nalgebra::{SMatrix, SVector, Vector2};
use std::error::Error;
use std::hint::black_box;

/// The paper's period, s.
const PERIOD: f64 = 0.003;

/// A little off the way in the middle of the paper's task.
fn typical<T: Scalar>() -> Measurement<T> {
    measurement([0.86, 0.71], [0.63, 0.45])
}

/// Many turns away and fast: large arguments of sine and cosine, neurons that saturate, no rule that fires.
fn wild<T: Scalar>() -> Measurement<T> {
    measurement([-40.3, 57.1], [21.0, -33.0])
}

fn measurement<T: Scalar>(position: [f64; 2], velocity: [f64; 2]) -> Measurement<T> {
    Measurement {
        position: Vector2::from(position.map(T::constant)),
        velocity: Vector2::from(velocity.map(T::constant)),
        base: BaseMeasurement::planar(T::constant(-0.5), T::constant(0.1)),
    }
}

pub fn run<T: Scalar>(number: &str) -> Result<(), Box<dyn Error>> {
    let mut context = BuildContext::new(ThreeLinkDem::<T>::table_2());
    context.adaptation_guard = AdaptationGuard::Bounded;
    for law in Law::ALL {
        let settings = ControllerSettings::default();
        for (state, measurement) in [("typical", typical()), ("wild", wild())] {
            let controller = settings.build(law, &context)?;
            second_step(&format!("{number} law {} {state}", law.name()), controller, &measurement);
        }
        for variant in law.variants() {
            let mut settings = settings;
            settings.set_base_acceleration(law, variant.base_acceleration)?;
            second_step(&format!("{number} law {} typical", variant.name), settings.build(law, &context)?, &typical());
        }
    }
    estimator::<T>(number)
}

/// The first step of a law has nothing to adapt by.
fn second_step<T: Scalar>(name: &str, mut controller: impl Controller<T>, measurement: &Measurement<T>) {
    let reference = QuinticReference::paper().at(T::constant(1.5));
    controller.update(measurement, &reference, T::zero());
    controller.limited([false; 2]);
    let period = T::constant(PERIOD);
    case(name, || controller.update(black_box(measurement), black_box(&reference), black_box(period)));
}

/// The parameters of the fuzzy laws adapted, by a law that costs nothing.
fn estimator<T: Scalar>(number: &str) -> Result<(), Box<dyn Error>> {
    let corner = |distance: f64| SMatrix::<T, FUZZY_PARAMETERS, 2>::repeat(T::constant(distance));
    let adaptation = Adaptation::new(corner(0.0), ScalarWeight::new(T::constant(0.8))?)?
        .projected_onto_box(ParameterBox::new(corner(-1.0), corner(1.0))?)?;
    let mut estimator = ParameterEstimator::new(adaptation);
    let (measurement, reference) = (typical::<T>(), QuinticReference::paper().at(T::constant(1.5)));
    let output = AdaptiveOutput {
        torque: SVector::<T, 2>::zeros(),
        control_input: SVector::zeros(),
        gradient: corner(0.1),
        fell_back: false,
    };
    let period = T::constant(PERIOD);
    estimator.cycle(&measurement, &reference, period, |_| output);
    case(&format!("{number} estimator 54 parameters"), || {
        estimator.cycle(black_box(&measurement), black_box(&reference), black_box(period), |_| *black_box(&output))
    });
    Ok(())
}
