//! The laws for arms of N joints: the same as the paper's in its plane, and the proven level in space.

mod common;

use approx::assert_relative_eq;
use common::dissipation::{Sample, dissipates};
use common::spatial::{Draws, draws};
use dem_model::nalgebra::{SMatrix, SVector, Vector2};
use dem_model::{
    BaseFreedom, BaseMotion, PlanarBaseManipulator, PlanarDem, SerialManipulator, SerialState, ThreeLinkDem,
};
use hinf_control::adaptation::{Adaptation, ScalarWeight};
use hinf_control::{
    Adaptive, AdaptiveBaseAcceleration, AnyController, ArmModel, AuxiliaryMotion, BaseAcceleration, BuildContext,
    CatalogueModel, Controller, ControllerSettings, Law, LinearModel, Measurement, Momentum, NonlinearHInfinity,
    ProvenAttenuation, Synthesis, TrackingError, WeightReading, Weights,
};
use proptest::prelude::*;

fn planar_twins() -> (ThreeLinkDem<f64>, PlanarBaseManipulator<f64, 2>) {
    let closed = ThreeLinkDem::table_2();
    (closed, PlanarBaseManipulator::planar(&PlanarDem::new(*closed.base(), *closed.links()).unwrap()))
}

/// Weights with different numbers for each joint, T11 diagonal.
fn design<const N: usize>() -> Synthesis<f64, N> {
    let ramp = |from: f64, to: f64| SVector::<f64, N>::from_fn(|row, _| from + (to - from) * row as f64 / N as f64);
    let weights = Weights::diagonal(ramp(0.5, 0.8), ramp(9.0, 5.0), ramp(0.9, 2.5), 2.0, WeightReading::Blocks);
    Synthesis::new(&weights).unwrap()
}

fn acceleration<const N: usize, const B: usize>(
    arm: &SerialManipulator<f64, N, B>,
    measurement: &Measurement<f64, N, B>,
    torque: &SVector<f64, N>,
) -> (SVector<f64, B>, SVector<f64, N>)
where
    BaseFreedom<B>: BaseMotion<f64, B>,
{
    let state = state(measurement);
    let acceleration = arm.forward_dynamics(&state, &SVector::zeros(), torque).unwrap();
    (acceleration.base, acceleration.joints)
}

fn state<const N: usize, const B: usize>(measurement: &Measurement<f64, N, B>) -> SerialState<f64, N, B> {
    SerialState {
        position: measurement.position,
        velocity: measurement.velocity,
        base_velocity: measurement.base.velocity,
    }
}

/// What the disturbed arm shows under a law: V is taken with M̄ and its rate by differences along q̇_m.
fn sample<const N: usize>(
    arm: &SerialManipulator<f64, N, 3>,
    measurement: &Measurement<f64, N, 3>,
    error: TrackingError<f64, N>,
    reference_acceleration: &SVector<f64, N>,
    command: &hinf_control::Command<f64, N>,
    disturbance: SVector<f64, N>,
) -> Sample<N> {
    let step = 1e-5;
    let mass = |offset: f64| arm.generalised_inertia(&(measurement.position + measurement.velocity * offset)).unwrap();
    let (_, joints) = acceleration(arm, measurement, &(command.torque + disturbance));
    Sample {
        error,
        error_acceleration: joints - reference_acceleration,
        control_input: command.control_input,
        disturbance,
        mass: mass(0.0),
        mass_rate: (mass(step) - mass(-step)) / (2.0 * step),
        parameter_storage_rate: 0.0,
    }
}

/// The balance in one random state of a random arm, under a random disturbance and under the worst.
fn keeps_the_level<const N: usize>(numbers: Vec<f64>, mode: BaseAcceleration) -> bool {
    let mut draws = Draws::new(numbers);
    let arm = draws.arm::<N>();
    let mut measurement = draws.measurement::<N, 3>();
    if mode == BaseAcceleration::Reduced {
        let reduced = arm.reduced(&measurement.position, &measurement.velocity, &SVector::zeros()).unwrap();
        measurement.base.velocity = reduced.base_velocity;
    }
    let reference = draws.near(&measurement);
    let design = design::<N>();
    let level = design.proven_attenuation_level().unwrap();
    assert!(level.level_squared <= 4.0, "γ = 2 was designed for");
    let error = TrackingError::new(&measurement, &reference);
    let mut law = NonlinearHInfinity::new(arm, design, mode);
    let command = law.update(&measurement, &reference, 0.0);
    assert!(!command.adaptation.fell_back);
    let random = draws.vector::<N>() * 10f64.powf(2.0 * draws.next());
    let worst = design.t11_inverse()
        * design.t11_inverse()
        * design.filtered_error(&error)
        * (level.storage_gain / level.level_squared);
    [random, worst].into_iter().all(|disturbance| {
        let sample = sample(&arm, &measurement, error, &reference.acceleration, &command, disturbance);
        dissipates(&design, &level, &sample)
    })
}

proptest! {
    #[test]
    fn the_paper_s_arm_is_the_same_as_a_serial_one(numbers in draws()) {
        let (closed, serial) = planar_twins();
        let mut draws = Draws::new(numbers);
        let measurement = draws.measurement::<2, 1>();
        let motion = AuxiliaryMotion { acceleration: draws.vector(), velocity: draws.vector() };
        let torque: Vector2<f64> = draws.vector();
        let same = |left: Vector2<f64>, right: Vector2<f64>| (left - right).amax() < 1e-13 * (1.0 + left.amax());
        prop_assert!(same(closed.arm_torque(&measurement, &motion), serial.arm_torque(&measurement, &motion)));
        prop_assert!(same(closed.base_reaction(&measurement), serial.base_reaction(&measurement)));
        // With momentum the two write C̃ differently, by a skew matrix times x2 − q̇_m: equal along the motion itself.
        let along = AuxiliaryMotion { velocity: measurement.velocity, ..motion };
        for (momentum, motion) in [(Momentum::Zero, motion), (Momentum::Measured, along)] {
            let reduced = closed.reduced_torque(&measurement, &motion, momentum).unwrap();
            prop_assert!(same(reduced, serial.reduced_torque(&measurement, &motion, momentum).unwrap()));
        }
        let compensated = closed.base_compensated_torque(&measurement, &torque).unwrap();
        prop_assert!(same(compensated, serial.base_compensated_torque(&measurement, &torque).unwrap()));
        let inertia = closed.generalised_inertia(&measurement.position).unwrap();
        prop_assert!((inertia - serial.generalised_inertia(&measurement.position).unwrap()).amax() < 1e-15);
        let linear = |regressor: &[SMatrix<f64, 2, 10>; 2], parameters: SMatrix<f64, 10, 2>| {
            regressor[0] * parameters.column(0) + regressor[1] * parameters.column(1)
        };
        let regressor = LinearModel::regressor(&serial, &measurement, &motion);
        prop_assert!(same(linear(&regressor, serial.parameters()), closed.arm_torque(&measurement, &motion)));
    }

    /// The laws' error dynamics in space: with the true base acceleration M_mm ṡ + C_mm s = T11⁻¹u.
    #[test]
    fn f_and_e_are_the_whole_torque_in_space(numbers in draws()) {
        let mut draws = Draws::new(numbers);
        let arm = draws.arm::<3>();
        let mut measurement = draws.measurement::<3, 3>();
        let torque = draws.vector::<3>();
        let (base, joints) = acceleration(&arm, &measurement, &torque);
        measurement.base.acceleration = base;
        let motion = AuxiliaryMotion { acceleration: joints, velocity: measurement.velocity };
        let rebuilt = arm.arm_torque(&measurement, &motion) + arm.base_reaction(&measurement);
        prop_assert!((rebuilt - torque).amax() < 1e-10 * (1.0 + joints.amax()));
        // Eliminated: the joints accelerate as the locked arm does under τ̄.
        let compensated = arm.base_compensated_torque(&measurement, &torque).unwrap();
        let (_, joints) = acceleration(&arm, &measurement, &compensated);
        let motion = AuxiliaryMotion { acceleration: joints, velocity: measurement.velocity };
        prop_assert!((arm.arm_torque(&measurement, &motion) - torque).amax() < 1e-10 * (1.0 + joints.amax()));
        // Reduced: with the true momentum the whole motion of the arm.
        let (_, joints) = acceleration(&arm, &measurement, &torque);
        let motion = AuxiliaryMotion { acceleration: joints, velocity: measurement.velocity };
        let reduced = arm.reduced_torque(&measurement, &motion, Momentum::Measured).unwrap();
        prop_assert!((reduced - torque).amax() < 1e-10 * (1.0 + joints.amax()));
    }

    #[test]
    fn the_reduced_law_keeps_its_level_in_space(numbers in draws()) {
        prop_assert!(keeps_the_level::<3>(numbers.clone(), BaseAcceleration::Reduced));
        prop_assert!(keeps_the_level::<3>(numbers.clone(), BaseAcceleration::ReducedMomentum));
        prop_assert!(keeps_the_level::<6>(numbers, BaseAcceleration::ReducedMomentum));
    }

    #[test]
    fn momentum_that_is_left_out_can_break_the_level(numbers in prop::collection::vec(draws(), 40)) {
        // The check can fail: the reduced law of a base at rest, on a base that turns.
        let fails = numbers.into_iter().filter(|numbers| {
            let mut draws = Draws::new(numbers.clone());
            let arm = draws.arm::<3>();
            let mut measurement = draws.measurement::<3, 3>();
            measurement.base.velocity *= 3.0;
            let reference = draws.near(&measurement);
            let design = design::<3>();
            let level = design.proven_attenuation_level().unwrap();
            let mut law = NonlinearHInfinity::new(arm, design, BaseAcceleration::Reduced);
            let command = law.update(&measurement, &reference, 0.0);
            let error = TrackingError::new(&measurement, &reference);
            let undisturbed =
                sample(&arm, &measurement, error, &reference.acceleration, &command, SVector::zeros());
            !dissipates(&design, &level, &undisturbed)
        });
        prop_assert!(fails.count() > 0);
    }
}

#[test]
fn an_estimate_that_belongs_to_no_arm_is_told_and_not_divided_by() {
    fn check<const K: usize, const G: usize, const N: usize, const B: usize, M>(model: M, estimate: SMatrix<f64, K, G>)
    where
        M: LinearModel<f64, N, B, K, G>,
    {
        let adaptation = Adaptation::new(estimate, ScalarWeight::new(1.0).unwrap()).unwrap();
        let law = |mode| Adaptive::new(model.clone(), design::<N>(), mode, adaptation.clone());
        let measurement = Measurement {
            position: SVector::repeat(0.4),
            velocity: SVector::repeat(0.2),
            base: hinf_control::BaseMeasurement { velocity: SVector::repeat(0.1), acceleration: SVector::zeros() },
        };
        let reference = Draws::new(vec![0.5; 100]).near(&measurement);
        let eliminated = law(AdaptiveBaseAcceleration::Eliminated).update(&measurement, &reference, 0.0);
        let omitted = law(AdaptiveBaseAcceleration::Omitted).update(&measurement, &reference, 0.0);
        assert!(eliminated.adaptation.fell_back && !eliminated.adaptation.not_finite);
        assert!(!omitted.adaptation.fell_back);
        assert_eq!(eliminated.torque, omitted.torque);
    }
    let (closed, serial) = planar_twins();
    // All zero: singular. With less than nothing in the second joint: indefinite, but invertible.
    check(closed, SMatrix::zeros());
    check(
        closed,
        closed.regressor_parameters().map(|value| value * 0.01) - SVector::from([0.0, 0.02, 0.0, 0.0, 0.0, 0.0]),
    );
    check(serial, SMatrix::zeros());
    let spatial = Draws::new((0..600).map(|index| f64::from(index).sin()).collect()).arm::<3>();
    check(spatial, SMatrix::zeros());
    check(spatial, -spatial.parameters());
}

fn laws_for<const N: usize, const B: usize, M: CatalogueModel<f64, N, B>>(
    model: &M,
    start: &SVector<f64, N>,
) -> Vec<(Law, BaseAcceleration, AnyController<f64, N, B, M>)> {
    let context = BuildContext::new(model.clone());
    let derived = ControllerSettings::derived(model, start).unwrap();
    let mut laws = Vec::new();
    for law in Law::ALL {
        for mode in BaseAcceleration::ALL {
            let mut settings = derived;
            if settings.set_base_acceleration(law, mode).is_ok() {
                laws.push((law, mode, settings.build(law, &context).unwrap()));
            }
        }
        if matches!(law, Law::Neural | Law::Fuzzy) {
            laws.push((law, BaseAcceleration::Omitted, derived.build(law, &context).unwrap()));
        }
    }
    laws
}

#[test]
fn every_law_freezes_and_thaws_for_eight_joints() {
    let mut draws = Draws::new((0..600).map(|index| (f64::from(index) * 1.7).sin()).collect());
    let arm = draws.arm::<8>();
    let measurement = draws.measurement::<8, 3>();
    let reference = draws.near(&measurement);
    for (law, mode, mut controller) in laws_for(&arm, &measurement.position) {
        controller.update(&measurement, &reference, 0.0);
        controller.update(&measurement, &reference, 0.003);
        let state = controller.freeze();
        let next = controller.update(&measurement, &reference, 0.003);
        controller.reset();
        controller.thaw(&state).unwrap();
        assert_eq!(controller.update(&measurement, &reference, 0.003), next, "{law:?} {mode:?}");
        assert!(!next.adaptation.not_finite, "{law:?} {mode:?}");
    }
}

#[test]
fn derived_weights_make_t11_one_and_the_fastest_pole_160_per_second() {
    let mut draws = Draws::new((0..600).map(|index| (f64::from(index) * 0.7).cos()).collect());
    let arm = draws.arm::<4>();
    let start = draws.vector::<4>();
    let settings = ControllerSettings::derived(&arm, &start).unwrap();
    let design = Synthesis::new(&settings.weights(Law::Nonlinear)).unwrap();
    assert_relative_eq!(design.t11(), &SMatrix::identity(), epsilon = 1e-12);
    assert_relative_eq!(design.error_rate(), &(SMatrix::identity() * 3.5), epsilon = 1e-12);
    let gamma = design.attenuation_level();
    let ProvenAttenuation { level_squared, .. } = design.proven_attenuation_level().unwrap();
    assert!(level_squared <= gamma * gamma * (1.0 + 1e-12));
    // The poles of M̄ṡ = −R⁻¹s are the eigenvalues of M̄⁻¹R⁻¹, similar to the symmetric R^−½M̄⁻¹R^−½.
    let root = SMatrix::<f64, 4, 4>::from_diagonal(&design.control_weight().diagonal().map(|r: f64| r.sqrt().recip()));
    let inverse = arm.generalised_inertia(&start).unwrap().try_inverse().unwrap();
    assert_relative_eq!((root * inverse * root).symmetric_eigenvalues().max(), 160.0, max_relative = 1e-9);
}
