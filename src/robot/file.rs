//! The robot file as it is written: field for field, no meaning yet. `robots/uarm.toml` explains each field.
//!
//! Fields that are not known are refused where a file is read, not here: a log of a later version is read without them.

#![allow(missing_docs, reason = "robots/uarm.toml documents every field, with its unit")]

use std::path::PathBuf;

use hinf_control::ControllerSettings;
use serde::{Deserialize, Serialize};
use uarm_io::drive::network::{EmergencyReaction, IgnoredTargetReaction};
use uarm_io::drive::wishes::{SyncCounterChoice, TorqueApplies};
use uarm_io::drive::{DataType, Value};
use uarm_io::encoder::Direction;
use uarm_io::torque::TorqueUnit;
use uarm_loop::reference::Passing;

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub struct RobotFile<const N: usize = 2> {
    pub schema: u32,
    pub name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<Model>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub space_manipulator: Option<SpaceManipulator>,
    pub task: Task,
    pub control: Control,
    pub estimator: Estimator,
    #[serde(default, skip_serializing_if = "is_default")]
    pub supervision: Supervision,
    pub bus: Bus,
    pub joints: Vec<Joint>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controllers: Option<ControllerSettings<N>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plant: Option<Plant>,
}

#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Model {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<ModelBase>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub links: Vec<ModelLink>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub urdf: Option<PathBuf>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spacecraft: Option<UrdfSpacecraft>,
    /// The text of the URDF, in logs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub urdf_text: Option<String>,
}

/// A spacecraft that the URDF does not have: xx, yy, zz, xy, xz, yz of its inertia.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq)]
pub struct UrdfSpacecraft {
    pub mass_kg: f64,
    pub inertia_kg_m2: [f64; 6],
}

#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(untagged, expecting = "{ inertia_kg_m2 = ..., length_m = ... }, or beside `urdf` the name of a link")]
pub enum ModelBase {
    Numbers(ModelBaseNumbers),
    Link(String),
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct ModelBaseNumbers {
    pub inertia_kg_m2: f64,
    pub length_m: f64,
}

#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct ModelLink {
    pub mass_kg: f64,
    pub inertia_kg_m2: f64,
    pub length_m: f64,
    pub centre_of_mass_m: f64,
}

/// A space manipulator; `uarm map` reads files that hold nothing else.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct SpaceManipulator {
    pub spacecraft: Spacecraft,
    pub links: Vec<SpaceLink>,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Spacecraft {
    pub mass_kg: f64,
    pub inertia_kg_m2: f64,
    pub centre_of_mass_to_joint_m: f64,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct SpaceLink {
    pub mass_kg: f64,
    pub inertia_kg_m2: f64,
    pub joint_to_centre_of_mass_m: f64,
    pub centre_of_mass_to_joint_m: f64,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Task {
    pub start_deg: Vec<f64>,
    pub end_deg: Vec<f64>,
    pub duration_s: f64,
    pub hold_s: f64,
    pub start_tolerance_deg: f64,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub via: Vec<ViaPoint>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub via_csv: Option<PathBuf>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub oscillations: Vec<Oscillation>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub oscillation_ramp_s: Option<f64>,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct ViaPoint {
    pub at_s: f64,
    pub angles_deg: Vec<f64>,
    #[serde(default, skip_serializing_if = "is_default")]
    pub passing: Passing,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Oscillation {
    pub joint: String,
    pub amplitude_deg: f64,
    pub frequency_hz: f64,
    #[serde(default, skip_serializing_if = "is_default")]
    pub phase_deg: f64,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Control {
    pub period_us: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub feedback_timeout_us: Option<u32>,
    pub tracking_error_limit_deg: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub overruns_in_a_row: Option<u8>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop_ramp_ms: Option<u16>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub saturation_stop_ms: Option<u16>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest_velocity_deg_per_s: Option<f64>,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Estimator {
    LowPass { cutoff_rad_per_s: f64 },
    TrackingLoop { bandwidth_rad_per_s: f64 },
    Kalman { jerk_density_rad2_per_s5: f64 },
    Levant { jerk_bound_rad_per_s3: f64 },
}

#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct Supervision {
    #[serde(default, skip_serializing_if = "is_default")]
    pub mode: SupervisionMode,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unmodelled_torque_nm: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model_error: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bandwidth_rad_per_s: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residual_ms: Option<u16>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum SupervisionMode {
    #[default]
    On,
    Off,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Bus {
    #[serde(default, skip_serializing_if = "is_default")]
    pub protocol: Protocol,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub odrive: Option<Odrive>,
    pub bitrate_hz: u32,
    pub controller_heartbeat_ms: u16,
    pub controller_timeout_ms: u16,
    pub drive_heartbeat_ms: u16,
    pub drive_timeout_ms: u16,
    pub sdo_timeout_ms: u16,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub listen_ms: Option<u16>,
    pub sdo_attempts: Option<u8>,
    pub boot_timeout_ms: Option<u16>,
    pub nmt_timeout_ms: Option<u16>,
    pub power_timeout_ms: Option<u16>,
    pub sync_counter: Option<SyncCounterChoice>,
    pub emergency: Option<EmergencyReaction>,
    pub target_ignored: Option<IgnoredTargetReaction>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Protocol {
    #[default]
    Canopen,
    Odrive,
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct Odrive {
    pub encoder_msg_rate_ms: u16,
}

/// What is as it is by default is not written.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Joint {
    pub name: String,
    pub role: Role,
    pub node: u8,
    pub gear_ratio: Option<[u32; 2]>,
    pub gear_efficiency: Option<f64>,
    pub encoder: Encoder,
    pub drive: Drive,
    pub limits: Limits,
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    Passive,
    Active,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Encoder {
    pub counts_per_revolution: u32,
    pub counter_bits: u8,
    pub direction: Direction,
    pub zero_counts: i32,
    pub resolution_object: Option<ResolutionObject>,
    #[serde(default, skip_serializing_if = "ReferenceKind::is_absolute")]
    pub reference: ReferenceKind,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power_marker: Option<ObjectWrite>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub referenced_bit: Option<u8>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub homing: Option<Homing>,
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq)]
pub struct Homing {
    pub method: i64,
    pub speeds: [u32; 2],
    pub acceleration: Option<u32>,
    #[serde(default, skip_serializing_if = "is_default")]
    pub offset: i32,
    pub counts_at_home: Option<i32>,
    pub angle_deg: f64,
    pub travel_deg: f64,
    pub timeout_s: Option<u16>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum ReferenceKind {
    #[default]
    Absolute,
    Incremental,
}

impl ReferenceKind {
    const fn is_absolute(&self) -> bool {
        matches!(self, Self::Absolute)
    }
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(untagged, expecting = "\"608F\", \"absent\" or { index, subindex, equals }")]
pub enum ResolutionObject {
    Named(NamedResolution),
    Object(MakersObject),
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub enum NamedResolution {
    #[serde(rename = "608F")]
    Standard,
    #[serde(rename = "absent")]
    Absent,
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
pub struct MakersObject {
    pub index: u16,
    pub subindex: u8,
    pub equals: i64,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Drive {
    pub profile: Option<String>,
    pub rated_torque_nm: f64,
    #[serde(default, skip_serializing_if = "is_default")]
    pub identity: Identity,
    pub rated_torque_unit: Option<TorqueUnit>,
    pub target_torque_of: Option<TargetTorqueOf>,
    pub rated_current_ma: Option<u32>,
    pub torque_applies: Option<TorqueApplies>,
    pub torque_delay_us: Option<u32>,
    pub watchdog: Option<Watchdog>,
    pub rpdo_timeout_ms: Option<u16>,
    pub watchdog_test: Option<String>,
    pub without_6007h: Option<String>,
    pub pdo: Option<Pdo>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub supply_voltage_v: Option<ReadingLimits>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<ReadingLimits>,
    #[serde(default)]
    pub writes: Vec<ObjectWrite>,
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq)]
pub struct ReadingLimits {
    pub object: Option<ReadObject>,
    pub warn_below: Option<f64>,
    pub stop_below: Option<f64>,
    pub warn_above: Option<f64>,
    pub stop_above: Option<f64>,
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq)]
pub struct ReadObject {
    pub index: u16,
    pub subindex: u8,
    #[serde(rename = "type")]
    pub kind: ObjectType,
    pub unit: f64,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
pub struct Identity {
    pub vendor: Option<u32>,
    pub product: Option<u32>,
    pub serial: Option<u32>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum TargetTorqueOf {
    #[default]
    RatedTorque,
    StatedTorque,
    RatedCurrent,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Watchdog {
    #[default]
    Heartbeat,
    RpdoTimeout,
}

#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
pub struct Pdo {
    pub rpdo: Option<u16>,
    pub rpdo_id: Option<u16>,
    pub rpdo_transmission: Option<u8>,
    pub tpdo: Option<u16>,
    pub tpdo_id: Option<u16>,
    pub torque_tpdo: Option<u16>,
    pub torque_tpdo_id: Option<u16>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub keep_rpdos: Vec<u16>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub keep_tpdos: Vec<u16>,
}

#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub struct ObjectWrite {
    pub index: u16,
    pub subindex: u8,
    #[serde(rename = "type")]
    pub kind: ObjectType,
    pub value: i64,
    pub when: Option<When>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum When {
    #[default]
    Before,
    After,
}

impl ObjectWrite {
    /// The value as its type has it; `None` if it does not fit.
    pub fn as_value(&self) -> Option<Value> {
        match self.kind {
            ObjectType::U8 => u8::try_from(self.value).map(Value::Unsigned8),
            ObjectType::U16 => u16::try_from(self.value).map(Value::Unsigned16),
            ObjectType::U32 => u32::try_from(self.value).map(Value::Unsigned32),
            ObjectType::I8 => i8::try_from(self.value).map(Value::Integer8),
            ObjectType::I16 => i16::try_from(self.value).map(Value::Integer16),
            ObjectType::I32 => i32::try_from(self.value).map(Value::Integer32),
        }
        .ok()
    }
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum ObjectType {
    U8,
    U16,
    U32,
    I8,
    I16,
    I32,
}

impl ObjectType {
    /// The least and the largest value.
    pub fn range(self) -> [f64; 2] {
        let [least, most] = match self {
            Self::U8 => [0, i64::from(u8::MAX)],
            Self::U16 => [0, i64::from(u16::MAX)],
            Self::U32 => [0, i64::from(u32::MAX)],
            Self::I8 => [i64::from(i8::MIN), i64::from(i8::MAX)],
            Self::I16 => [i64::from(i16::MIN), i64::from(i16::MAX)],
            Self::I32 => [i64::from(i32::MIN), i64::from(i32::MAX)],
        };
        [least as f64, most as f64]
    }

    /// The type of the object dictionary.
    pub const fn data_type(self) -> DataType {
        match self {
            Self::U8 => DataType::Unsigned8,
            Self::U16 => DataType::Unsigned16,
            Self::U32 => DataType::Unsigned32,
            Self::I8 => DataType::Integer8,
            Self::I16 => DataType::Integer16,
            Self::I32 => DataType::Integer32,
        }
    }
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Limits {
    pub torque_nm: f64,
    pub torque_rate_nm_per_s: f64,
    #[serde(alias = "rate_deg_per_s")]
    pub velocity_deg_per_s: f64,
    pub minimum_deg: f64,
    pub maximum_deg: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brake_ms: Option<u16>,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Plant {
    pub base_inertia_scale: f64,
    pub link_scale: f64,
    pub viscous_friction_nm_s: Vec<f64>,
    pub coulomb_friction_nm: Vec<f64>,
    pub torque_gain: f64,
    #[serde(default)]
    pub tilt_m_per_s2: [f64; 2],
}
