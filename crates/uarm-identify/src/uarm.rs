//! The paper's robot with its imperfections.

use crate::model::{Model, Parameter};
use crate::sample::Sample;
use core::time::Duration;
use dem_model::ThreeLinkDem;
use nalgebra::{SVector, Vector3};
use uarm_sim::{Brake, InitialState, IntegrationStep, Plant, UarmImperfections, UarmPlant, UarmPlantParameters};

/// Whether the torque at the joint per commanded torque is sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gain {
    /// It is this. All that is found is in proportion to it.
    Known(f64),
    /// It is sought, by a disturbance that is known.
    Sought,
}

/// A number that is not ideal in the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UarmParameter {
    /// Viscous friction of a joint, counted from 0, N·m·s.
    Viscous(usize),
    /// Coulomb friction of a joint, N·m.
    Coulomb(usize),
    /// Factor of the base's inertia.
    BaseInertia,
    /// Factor of the links' masses and inertias.
    Links,
    /// Acceleration of a tilted table along an axis of the fixed frame, m/s².
    Tilt(usize),
    /// Torque at the joint per commanded torque.
    Gain,
}

impl UarmParameter {
    /// All of them, in the order of an estimate's values.
    pub const ALL: [Self; 11] = [
        Self::Viscous(0),
        Self::Viscous(1),
        Self::Viscous(2),
        Self::Coulomb(0),
        Self::Coulomb(1),
        Self::Coulomb(2),
        Self::BaseInertia,
        Self::Links,
        Self::Tilt(0),
        Self::Tilt(1),
        Self::Gain,
    ];

    /// Its name in a robot file's `[plant]`.
    pub fn name(self) -> String {
        match self {
            Self::Viscous(joint) => format!("viscous_friction_nm_s[{joint}]"),
            Self::Coulomb(joint) => format!("coulomb_friction_nm[{joint}]"),
            Self::BaseInertia => "base_inertia_scale".to_owned(),
            Self::Links => "link_scale".to_owned(),
            Self::Tilt(axis) => format!("tilt_m_per_s2[{axis}]"),
            Self::Gain => "torque_gain".to_owned(),
        }
    }

    fn parameter(self) -> Parameter {
        let (unit, least, scale, start) = match self {
            Self::Viscous(_) => ("N m s", 0.0, 0.02, 0.01),
            Self::Coulomb(_) => ("N m", 0.0, 0.03, 0.01),
            Self::BaseInertia | Self::Links | Self::Gain => ("", SMALLEST_FACTOR, 1.0, 1.0),
            Self::Tilt(_) => ("m/s2", f64::NEG_INFINITY, 0.2, 0.0),
        };
        Parameter { name: self.name(), unit, least, scale, start }
    }
}

/// The least factor that the search looks at; a robot without mass has no motion.
const SMALLEST_FACTOR: f64 = 0.01;

/// The paper's robot: its nominal model with friction, other masses, a motor gain and a tilted table.
#[derive(Clone, Copy, Debug)]
pub struct Uarm {
    nominal: ThreeLinkDem<f64>,
    gain: Gain,
}

impl Uarm {
    /// The robot whose nominal model is `nominal`.
    pub const fn new(nominal: ThreeLinkDem<f64>, gain: Gain) -> Self {
        Self { nominal, gain }
    }

    /// What is sought, in the order of the values.
    pub fn sought(&self) -> Vec<UarmParameter> {
        let all = UarmParameter::ALL.into_iter();
        all.filter(|parameter| self.gain == Gain::Sought || *parameter != UarmParameter::Gain).collect()
    }

    /// The imperfections that `values` are, in the order of [`sought`](Self::sought); those that are missing are ideal.
    pub fn imperfections(&self, values: &[f64]) -> UarmImperfections {
        let mut found = UarmImperfections {
            viscous_friction: [0.0; 3],
            coulomb_friction: [0.0; 3],
            base_inertia_scale: 1.0,
            link_inertia_scale: 1.0,
            gain: match self.gain {
                Gain::Known(gain) => gain,
                Gain::Sought => 1.0,
            },
            tilt: [0.0; 2],
        };
        for (parameter, value) in self.sought().into_iter().zip(values) {
            let place = match parameter {
                UarmParameter::Viscous(joint) => &mut found.viscous_friction[joint],
                UarmParameter::Coulomb(joint) => &mut found.coulomb_friction[joint],
                UarmParameter::BaseInertia => &mut found.base_inertia_scale,
                UarmParameter::Links => &mut found.link_inertia_scale,
                UarmParameter::Tilt(axis) => &mut found.tilt[axis],
                UarmParameter::Gain => &mut found.gain,
            };
            *place = *value;
        }
        found
    }
}

impl Model<3> for Uarm {
    fn parameters(&self) -> Vec<Parameter> {
        self.sought().into_iter().map(UarmParameter::parameter).collect()
    }

    fn angles(
        &self,
        values: &[f64],
        position: &SVector<f64, 3>,
        velocity: &SVector<f64, 3>,
        window: &[Sample<3>],
    ) -> Option<Vec<SVector<f64, 3>>> {
        let imperfections = self.imperfections(values);
        let parameters = UarmPlantParameters::new(imperfections).ok()?;
        let start = InitialState { position: *position, velocity: *velocity };
        let mut plant = UarmPlant::new(&self.nominal, parameters)
            .ok()?
            .with_initial_state(start)
            .with_integration_step(IntegrationStep::COARSE);
        let begin = window.first()?.at;
        let since = |at: f64| Duration::try_from_secs_f64((at - begin).max(0.0)).ok();
        let mut angles = vec![*position];
        for pair in window.windows(2) {
            let [sample, next] = pair else { continue };
            // The disturbance acts behind the gain, and between its samples it is taken for a straight line.
            let span = next.at - sample.at;
            let known = |time: f64| {
                let share = (time + begin - sample.at) / span;
                let [before, after] = [sample, next].map(|sample| Vector3::from(sample.disturbance));
                (before + (after - before) * share) / imperfections.gain
            };
            let mut advance = |until: f64, torque: [f64; 3]| {
                plant.advance_under(since(until)?, |time| Vector3::from(torque) + known(time), [Brake::Released; 3]);
                Some(())
            };
            let torque_at = sample.torque_at.clamp(sample.at, next.at);
            advance(torque_at, sample.torque_before)?;
            advance(next.at, sample.torque)?;
            angles.push(plant.position());
        }
        angles.iter().all(|angles| angles.iter().all(|angle| angle.is_finite())).then_some(angles)
    }
}
