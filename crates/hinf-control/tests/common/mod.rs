//! What the integration tests share: an ideal plant under RK4, the paper's disturbance, and designs.
#![allow(dead_code)] // Each test binary uses a part of it.

pub mod dissipation;
pub mod spatial;

use dem_model::ThreeLinkDem;
use hinf_control::{
    BaseMeasurement, Command, Controller, ControllerSettings, Law, Measurement, PerformanceIndices, QuinticReference,
    Synthesis, TrackingError, WeightReading,
};
use nalgebra::{Vector2, Vector3};

/// The control period of the paper, s.
pub const PERIOD: f64 = 0.003;
/// Integration steps per period, as the reference vectors were made with. They meet t = 1 s.
pub const SUBSTEPS: u32 = 30;

/// Angles and velocities of base, joint 2 and joint 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    pub q: Vector3<f64>,
    pub velocity: Vector3<f64>,
}

impl State {
    /// The start of the paper's task with the base turning at `base_velocity`, rad/s.
    pub fn paper(base_velocity: f64) -> Self {
        let start = 20.0_f64.to_radians();
        Self { q: Vector3::new(0.0, start, start), velocity: Vector3::new(base_velocity, 0.0, 0.0) }
    }

    pub fn measurement(&self, base_acceleration: f64) -> Measurement<f64> {
        Measurement {
            position: Vector2::new(self.q.y, self.q.z),
            velocity: Vector2::new(self.velocity.y, self.velocity.z),
            base: BaseMeasurement::planar(self.velocity.x, base_acceleration),
        }
    }

    fn along(&self, slope: &State, time: f64) -> State {
        State { q: self.q + slope.q * time, velocity: self.velocity + slope.velocity * time }
    }
}

/// One RK4 step of `derivative(time, state)`.
pub fn runge_kutta(state: &State, time: f64, step: f64, derivative: impl Fn(f64, &State) -> State) -> State {
    let k1 = derivative(time, state);
    let k2 = derivative(time + step / 2.0, &state.along(&k1, step / 2.0));
    let k3 = derivative(time + step / 2.0, &state.along(&k2, step / 2.0));
    let k4 = derivative(time + step, &state.along(&k3, step));
    let mean = |a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>, d: Vector3<f64>| (a + b * 2.0 + c * 2.0 + d) / 6.0;
    state.along(
        &State { q: mean(k1.q, k2.q, k3.q, k4.q), velocity: mean(k1.velocity, k2.velocity, k3.velocity, k4.velocity) },
        step,
    )
}

/// Eq. 48 from t = 1 s on, N·m at the joints.
pub fn paper_disturbance(time: f64) -> Vector2<f64> {
    let since = time - 1.0;
    if since <= 0.0 {
        return Vector2::zeros();
    }
    Vector2::new(0.075, 0.05) * ((-5.0 * since).exp() * (6.0 * core::f64::consts::PI * since).sin())
}

/// The ideal plant under a joint torque held over one period, with the paper's disturbance.
pub fn hold(model: &ThreeLinkDem<f64>, state: &State, time: f64, torque: &Vector2<f64>) -> State {
    let step = PERIOD / f64::from(SUBSTEPS);
    (0..SUBSTEPS).fold(*state, |state, substep| {
        runge_kutta(&state, time + f64::from(substep) * step, step, |time, state| {
            let joint = torque + paper_disturbance(time);
            let force = Vector3::new(0.0, joint.x, joint.y);
            State { q: state.velocity, velocity: model.forward_dynamics(&state.q, &state.velocity, &force) }
        })
    })
}

/// One sample of a closed loop: what was measured and asked for at its time.
pub struct Sample {
    pub time: f64,
    pub state: State,
    pub command: Command<f64>,
    pub parameters: Vec<f64>,
}

/// The paper's task on the ideal plant: every sample from 0 to 3 s, and the indices over the cycles before 3 s.
pub fn paper_run(controller: &mut dyn Controller<f64>, start: State) -> (Vec<Sample>, PerformanceIndices<f64>) {
    let model = ThreeLinkDem::table_2();
    let reference = QuinticReference::paper();
    let mut indices = PerformanceIndices::new();
    let mut samples = Vec::new();
    let mut state = start;
    for cycle in 0..=1000_u32 {
        let time = f64::from(cycle) * PERIOD;
        let measurement = state.measurement(f64::NAN); // The modes run here must not read it.
        let desired = reference.at(time);
        let period = if cycle == 0 { 0.0 } else { PERIOD };
        let command = controller.update(&measurement, &desired, period);
        samples.push(Sample { time, state, command, parameters: controller.parameters().to_vec() });
        if cycle < 1000 {
            indices.record(&TrackingError::new(&measurement, &desired), &command.torque, PERIOD);
            state = hold(&model, &state, time, &command.torque);
        }
    }
    (samples, indices)
}

pub fn table_3(law: Law, reading: WeightReading) -> Synthesis<f64> {
    let settings = ControllerSettings { reading, ..ControllerSettings::default() };
    Synthesis::new(&settings.weights(law)).unwrap()
}
