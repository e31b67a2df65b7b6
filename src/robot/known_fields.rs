//! Which fields a table of the robot file may have, those that are left out too: as `serde` knows them.

use std::fmt;

use serde::de::{self, Deserialize, Deserializer, Visitor};

use super::file;

/// The fields that the table of `field`, a path such as `joints.1.limits.torque`, may have, in words.
pub fn beside(field: &str) -> String {
    let parents = field.rsplit_once('.').map_or("", |(parents, _)| parents);
    let names: Vec<&str> = parents.split('.').filter(|name| name.parse::<usize>().is_err()).collect();
    let fields = match names.as_slice() {
        [""] => fields_of::<file::RobotFile>(),
        ["model"] => fields_of::<file::Model>(),
        ["model", "base"] => fields_of::<file::ModelBaseNumbers>(),
        ["model", "spacecraft"] => fields_of::<file::UrdfSpacecraft>(),
        ["model", "links"] => fields_of::<file::ModelLink>(),
        ["space_manipulator"] => fields_of::<file::SpaceManipulator>(),
        ["space_manipulator", "spacecraft"] => fields_of::<file::Spacecraft>(),
        ["space_manipulator", "links"] => fields_of::<file::SpaceLink>(),
        ["task"] => fields_of::<file::Task>(),
        ["task", "via"] => fields_of::<file::ViaPoint>(),
        ["task", "oscillations"] => fields_of::<file::Oscillation>(),
        ["control"] => fields_of::<file::Control>(),
        ["bus"] => fields_of::<file::Bus>(),
        ["bus", "odrive"] => fields_of::<file::Odrive>(),
        ["joints"] => fields_of::<file::Joint>(),
        ["joints", "encoder"] => fields_of::<file::Encoder>(),
        ["joints", "encoder", "homing"] => fields_of::<file::Homing>(),
        ["joints", "encoder", "power_marker"] | ["joints", "drive", "writes"] => fields_of::<file::ObjectWrite>(),
        ["joints", "drive"] => fields_of::<file::Drive>(),
        ["joints", "drive", "identity"] => fields_of::<file::Identity>(),
        ["joints", "drive", "supply_voltage_v" | "temperature_c"] => fields_of::<file::ReadingLimits>(),
        ["joints", "drive", "supply_voltage_v" | "temperature_c", "object"] => fields_of::<file::ReadObject>(),
        ["joints", "drive", "pdo"] => fields_of::<file::Pdo>(),
        ["joints", "limits"] => fields_of::<file::Limits>(),
        ["controllers"] => fields_of::<hinf_control::ControllerSettings>(),
        ["plant"] => fields_of::<file::Plant>(),
        _ => &[],
    };
    if fields.is_empty() {
        return "a field that robots/uarm.toml explains".to_owned();
    }
    format!("one of {}", fields.join(", "))
}

/// The names that a type reads its fields under.
fn fields_of<T: for<'de> Deserialize<'de>>() -> &'static [&'static str] {
    match T::deserialize(FieldNames) {
        Err(Asked(fields)) => fields,
        Ok(_) => &[],
    }
}

/// Answers with the fields that it was asked for, as an error.
struct FieldNames;

#[derive(Debug)]
struct Asked(&'static [&'static str]);

impl fmt::Display for Asked {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0.join(", "))
    }
}

impl std::error::Error for Asked {}

impl de::Error for Asked {
    fn custom<T: fmt::Display>(_: T) -> Self {
        Self(&[])
    }
}

impl<'de> Deserializer<'de> for FieldNames {
    type Error = Asked;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Asked> {
        Err(Asked(&[]))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, Asked> {
        Err(Asked(fields))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_that_are_left_out_are_named_too() {
        let encoder = beside("joints.1.encoder.refrence");
        assert!(
            ["counts_per_revolution", "reference", "power_marker", "referenced_bit", "homing"]
                .iter()
                .all(|key| encoder.contains(key))
        );
        assert!(beside("joints.0.drive.pdo.rdpo").contains("rpdo_transmission"));
        assert!(beside("bus.sync").contains("sync_counter"));
        assert!(beside("nmae").contains("schema, name"));
        assert_eq!(beside("estimator.x"), "a field that robots/uarm.toml explains");
    }
}
