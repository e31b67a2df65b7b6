//! Supply voltages and temperatures that a run reads, and their limits: checked.

use uarm_io::drive::readings::{Quantity, Reading, ReadingLimits, Readings};
use uarm_io::drive::words::Named;
use uarm_io::drive::{Address, DataType};

use super::error::{Checker, RobotError};
use super::file::{self, Protocol, RobotFile};

/// 6079h, DC link circuit voltage, mV (CiA 402-2).
const SUPPLY_VOLTAGE: file::ReadObject =
    file::ReadObject { index: 0x6079, subindex: 0, kind: file::ObjectType::U32, unit: 1e-3 };

/// No object: the place of a number in V or °C that an axis tells in a message, with the range that any of them has.
const OF_MESSAGE: file::ReadObject = file::ReadObject { index: 0, subindex: 0, kind: file::ObjectType::I16, unit: 1.0 };

/// What is read of the drive of joint `index`.
pub(super) fn check<const N: usize>(
    index: usize,
    drive: &file::Drive,
    file: &RobotFile<N>,
    check: &Checker<'_>,
) -> Result<Readings, RobotError> {
    let mut readings = Readings::default();
    for (reading, quantity) in readings.iter_mut().zip(Quantity::ALL) {
        let (name, limits, usual) = match quantity {
            Quantity::SupplyVoltage => ("supply_voltage_v", &drive.supply_voltage_v, Some(SUPPLY_VOLTAGE)),
            Quantity::Temperature => ("temperature_c", &drive.temperature_c, None),
        };
        let Some(limits) = limits else { continue };
        let field = format!("joints[{index}].drive.{name}");
        let usual = match file.bus.protocol {
            Protocol::Canopen => usual,
            Protocol::Odrive if limits.object.is_none() => Some(OF_MESSAGE),
            Protocol::Odrive => {
                let expected = "absent: an ODrive axis tells it in a message of its own";
                return Err(check.refuse(format!("{field}.object"), "a table", expected));
            }
        };
        *reading = Some(one(&field, limits, usual, check)?);
    }
    if let [Some(voltage), Some(temperature)] = &readings
        && voltage.object == temperature.object
        && file.bus.protocol == Protocol::Canopen
    {
        let field = format!("joints[{index}].drive.temperature_c.object");
        return Err(check.refuse(field, Named(temperature.object), "another than that of supply_voltage_v"));
    }
    Ok(readings)
}

fn one(
    field: &str,
    limits: &file::ReadingLimits,
    usual: Option<file::ReadObject>,
    check: &Checker<'_>,
) -> Result<Reading, RobotError> {
    let Some(object) = limits.object.or(usual) else {
        let expected = "{ index, subindex, type, unit }: the standard has no object for it";
        return Err(check.refuse(format!("{field}.object"), "absent", expected));
    };
    check.positive(&format!("{field}.object.unit"), object.unit)?;
    let [least_value, most_value] = object.kind.range();
    let given = [
        ("warn_below", limits.warn_below),
        ("stop_below", limits.stop_below),
        ("warn_above", limits.warn_above),
        ("stop_above", limits.stop_above),
    ];
    let given: Vec<_> = given.into_iter().filter_map(|(name, limit)| Some((name, limit?))).collect();
    for (name, limit) in &given {
        // One that no value of the object reaches would never be heard of.
        check.within(&format!("{field}.{name}"), *limit, least_value * object.unit, most_value * object.unit)?;
    }
    let found = given.iter().map(|(name, limit)| format!("{name} = {limit}")).collect::<Vec<_>>().join(", ");
    let least = |limit: Option<f64>| limit.unwrap_or(f64::NEG_INFINITY);
    let most = |limit: Option<f64>| limit.unwrap_or(f64::INFINITY);
    // What ends a run is never borne without a word, and the other way round.
    let stop = [least(limits.stop_below), most(limits.stop_above)];
    let warn = [least(limits.warn_below.or(limits.stop_below)), most(limits.warn_above.or(limits.stop_above))];
    if given.is_empty() {
        return Err(check.refuse(
            field,
            "without limits",
            "one of warn_below, stop_below, warn_above, stop_above at least",
        ));
    }
    let expected = "stop_below, warn_below, warn_above, stop_above in this order";
    let limits = ReadingLimits::new(warn, stop).ok_or_else(|| check.refuse(field, found, expected))?;
    let data_type: DataType = object.kind.data_type();
    Ok(Reading { object: Address::new(object.index, object.subindex), data_type, scale: object.unit, limits })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use uarm_io::drive::readings::{Readings, Verdict};
    use uarm_io::drive::{Address, DataType};

    use crate::robot::overrides::Overrides;
    use crate::robot::{BUILT_IN, Robot};

    fn with(keys: &str) -> Result<Readings, String> {
        let text = BUILT_IN.replacen(
            "drive = { rated_torque_nm = 0.2,",
            &format!("drive = {{ {keys}, rated_torque_nm = 0.2,"),
            1,
        );
        let robot =
            Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).map_err(|error| error.to_string())?;
        let [base, ..] = robot.description.joints;
        Ok(base.drive.readings)
    }

    #[test]
    fn voltage_is_read_from_the_standards_object_and_temperature_from_the_makers() {
        let [voltage, temperature] = with(
            "supply_voltage_v = { warn_below = 22.0, stop_below = 20.0, stop_above = 30.0 }, \
             temperature_c = { object = { index = 0x2010, subindex = 1, type = \"i16\", unit = 0.1 }, warn_above = 70, stop_above = 80 }",
        )
        .unwrap();
        let (voltage, temperature) = (voltage.unwrap(), temperature.unwrap());
        assert_eq!((voltage.object, voltage.data_type), (Address::new(0x6079, 0), DataType::Unsigned32));
        assert_eq!(voltage.scale, 1e-3);
        assert_eq!(voltage.limits.stop(), [20.0, 30.0]);
        assert_eq!(voltage.limits.warn(), [22.0, 30.0]);
        assert_eq!((temperature.object, temperature.data_type), (Address::new(0x2010, 1), DataType::Integer16));
        assert_eq!(temperature.scale, 0.1);
        assert_eq!(temperature.limits.verdict(75.0), Verdict::Warning);
        assert_eq!(temperature.limits.verdict(-40.0), Verdict::Good);
    }

    #[test]
    fn an_odrive_axis_tells_both_in_messages_of_its_own() {
        let with = |keys: &str| {
            let text = include_str!("../../robots/uarm-odrive.toml").replacen(
                "\ndrive = { ",
                &format!("\ndrive = {{ {keys}, "),
                1,
            );
            assert!(text.contains(keys));
            let robot = Robot::parse(Path::new("test.toml"), &text, &Overrides::default());
            robot.map(|robot| robot.description.joints[0].drive.readings).map_err(|error| error.to_string())
        };
        let [voltage, temperature] =
            with("supply_voltage_v = { stop_below = 20.0 }, temperature_c = { stop_above = 80.0 }").unwrap();
        assert_eq!(voltage.unwrap().limits.stop(), [20.0, f64::INFINITY]);
        assert_eq!(temperature.unwrap().limits.stop(), [f64::NEG_INFINITY, 80.0]);
        let object = "temperature_c = { stop_above = 80.0, object = { index = 0x2010, subindex = 0, type = \"i16\", unit = 0.1 } }";
        let message = with(object).unwrap_err();
        assert!(message.contains("joints[0].drive.temperature_c.object = a table: expected absent"), "{message}");
    }

    #[test]
    fn what_cannot_be_read_or_judged_is_refused_by_name() {
        for (keys, part) in [
            ("temperature_c = { stop_above = 80 }", "joints[0].drive.temperature_c.object = absent: expected { index"),
            ("supply_voltage_v = {}", "joints[0].drive.supply_voltage_v = without limits: expected one of warn_below"),
            (
                "supply_voltage_v = { warn_below = 19.0, stop_below = 20.0 }",
                "supply_voltage_v = warn_below = 19, stop_below = 20: expected stop_below, warn_below, warn_above, stop_above in this order",
            ),
            (
                "supply_voltage_v = { stop_below = -5.0 }",
                "supply_voltage_v.stop_below = -5: expected a number from 0 to 4294967.295",
            ),
            ("supply_voltage_v = { stop_above = nan }", "supply_voltage_v.stop_above = NaN: expected a number from 0"),
            (
                "temperature_c = { stop_above = 80.0, object = { index = 0x2010, subindex = 0, type = \"i16\", unit = 0.001 } }",
                "temperature_c.stop_above = 80: expected a number from -32.768 to 32.767",
            ),
            (
                "supply_voltage_v = { stop_below = 20.0 }, \
                 temperature_c = { stop_above = 80.0, object = { index = 0x6079, subindex = 0, type = \"u32\", unit = 1.0 } }",
                "joints[0].drive.temperature_c.object = 6079h:00 (DC link circuit voltage): expected another than that of supply_voltage_v",
            ),
            (
                "supply_voltage_v = { object = { index = 0x6079, subindex = 0, type = \"u32\", unit = 0.0 }, stop_below = 20.0 }",
                "joints[0].drive.supply_voltage_v.object.unit = 0",
            ),
        ] {
            let message = with(keys).unwrap_err();
            assert!(message.contains(part), "{keys}: {message}");
        }
    }
}
