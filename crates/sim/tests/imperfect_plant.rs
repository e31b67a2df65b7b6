//! The fitted UARM under all six laws gives the indices that an independent implementation gave (`uarm_plant.json`).
//!
//! The plant is a fit of 13 parameters to 12 numbers, chosen after 26 fits: what agrees here are two programs, not a robot.

use core::time::Duration;
use dem_model::ThreeLinkDem;
use hinf_control::{
    BaseAcceleration, BaseMeasurement, BuildContext, Controller, ControllerSettings, Disturbance, Law, Measurement,
    PerformanceIndices, QuinticReference, TrackingError,
};
use nalgebra::Vector3;
use serde_json::Value;
use uarm_io::encoder::Direction;
use uarm_sim::drive::Encoder;
use uarm_sim::{Brake, EncoderDescription, Plant, UarmPlant, UarmPlantParameters};

/// A quantised loop is chaotic at the count, so that 1 % would be all one can ask of two programs that differ in a rounding.
/// Here no count differs, and the transcendentals are the same on every machine: what remains is the rounding of sums.
const TOLERANCE: f64 = 1e-9;
const PERIOD: Duration = Duration::from_millis(3);
/// The task's 3 s.
const CYCLES: u32 = 1_000;

/// What the run of one law came to.
struct Outcome {
    tracking: f64,
    torque: f64,
    base_degrees: f64,
}

fn run(law: Law, counts_per_revolution: u32, bandwidth: f64) -> Outcome {
    let nominal = ThreeLinkDem::table_2();
    let mut plant =
        UarmPlant::new(&nominal, UarmPlantParameters::fitted()).unwrap().with_disturbance(Disturbance::Paper);
    let mut settings = ControllerSettings::default();
    settings.set_base_acceleration(Law::Adaptive, BaseAcceleration::Omitted).unwrap();
    let mut controller = settings.build(law, &BuildContext::new(nominal)).unwrap();
    let reference = QuinticReference::<f64>::paper();
    let description = EncoderDescription { counts_per_revolution, counter_bits: 32, zero_offset: 0 };
    let encoder = Encoder::new(description, Direction::Positive).unwrap();
    let per_count = core::f64::consts::TAU / f64::from(counts_per_revolution);
    let measured = |plant: &UarmPlant| plant.position().map(|angle| f64::from(encoder.counts(angle)) * per_count);
    let period = PERIOD.as_secs_f64();
    let smoothing = 1.0 - (-bandwidth * period).exp();
    let (mut position, mut rate) = (measured(&plant), Vector3::zeros());
    let mut indices = PerformanceIndices::new();
    let mut base_degrees = 0.0;
    for k in 0..CYCLES {
        let last = core::mem::replace(&mut position, measured(&plant));
        rate += ((position - last) / period - rate) * smoothing;
        let measurement =
            Measurement { position: position.yz(), velocity: rate.yz(), base: BaseMeasurement::planar(rate.x, 0.0) };
        let wanted = reference.at(f64::from(k) * period);
        let elapsed = if k == 0 { 0.0 } else { period };
        let torque = controller.update(&measurement, &wanted, elapsed).torque;
        // As the robot sees it, not as it is: the paper's indices come from its encoders.
        indices.record(&TrackingError::new(&measurement, &wanted), &torque, period);
        base_degrees = plant.position().x.to_degrees();
        plant.advance(PERIOD * (k + 1), &Vector3::new(0.0, torque.x, torque.y), [Brake::Released; 3]);
    }
    Outcome { tracking: indices.tracking(), torque: indices.torque(), base_degrees }
}

#[test]
fn six_laws_on_the_fitted_plant() {
    let vectors: Value = serde_json::from_str(include_str!("vectors/uarm_plant.json")).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let bandwidth = number(&vectors["params"]["wc"]);
    let laws = [Law::Nonlinear, Law::Adaptive, Law::Neural, Law::NeuralModel, Law::Fuzzy, Law::FuzzyModel];
    let rows = vectors["rows"].as_array().unwrap();
    assert_eq!(rows.len(), laws.len());
    for (law, row) in laws.into_iter().zip(rows) {
        let outcome = run(law, 33_739, bandwidth);
        approx::assert_relative_eq!(outcome.tracking, number(&row["L2"]), max_relative = TOLERANCE);
        approx::assert_relative_eq!(outcome.torque, number(&row["E"]), max_relative = TOLERANCE);
        approx::assert_relative_eq!(outcome.base_degrees, number(&row["base_deg_3s"]), max_relative = TOLERANCE);
    }
}

/// The constants in the code are those of the vectors.
#[test]
fn the_fitted_parameters_are_those_of_the_vectors() {
    let vectors: Value = serde_json::from_str(include_str!("vectors/uarm_plant.json")).unwrap();
    let p = |name: &str| vectors["params"][name].as_f64().unwrap();
    let fitted = UarmPlantParameters::fitted();
    assert_eq!(*fitted.viscous_friction(), Vector3::new(p("b1"), p("bj"), p("bj")));
    assert_eq!(*fitted.coulomb_friction(), Vector3::new(p("c1"), p("c2"), p("c3")));
    assert_eq!((fitted.base_inertia_scale(), fitted.link_inertia_scale()), (p("I1s"), p("ms")));
    assert_eq!(fitted.gain(), p("gain"));
    assert_eq!(*fitted.tilt(), nalgebra::Vector2::new(p("gx"), p("gy")));
    assert_eq!(p("counts_per_rev"), 33_739.0);
}
