//! What a robot file watches in a drive of which there is a dictionary only: a measurement is none of a dictionary's values.

use uarm_eds::{Dictionary, Kind, Value};
use uarm_io::drive::readings::{QUANTITIES, Quantity, Reading, Readings};
use uarm_sim::drive::DriveDictionary;

/// What the supply of the paper's drives has, V.
const USUAL_VOLTAGE: f64 = 24.0;
/// What a drive at rest has, °C.
const USUAL_TEMPERATURE: f64 = 30.0;

/// Those of `readings` whose object `dictionary` has without a value. A 0 that nobody can write is none: makers write it where
/// only the drive knows.
pub fn unstated<'a>(
    dictionary: &Dictionary,
    node: u8,
    readings: &'a Readings,
) -> impl Iterator<Item = (Quantity, &'a Reading)> {
    of(readings).filter(move |(_, reading)| {
        let object = dictionary.object(uarm_eds::Address::new(reading.object.index, reading.object.subindex));
        object.is_some_and(|object| match object.value(node) {
            None => true,
            Some(value) => value == Value::Integer(0) && !object.access.is_writable(),
        })
    })
}

/// The objects of a simulated drive with a good supply and temperature for `readings`, where `dictionary`, if it has a maker's, does not
/// state them.
pub fn with_good_readings(
    objects: DriveDictionary,
    dictionary: Option<(&Dictionary, u8)>,
    readings: &Readings,
) -> DriveDictionary {
    let unstated: Vec<_> = match dictionary {
        Some((dictionary, node)) => unstated(dictionary, node, readings).collect(),
        None => of(readings).collect(),
    };
    unstated.into_iter().fold(objects, |objects, (quantity, reading)| {
        let value = Value::Integer(good(quantity, reading)).to_wire(Kind::Basic(reading.data_type));
        // An object that is absent or of another type is refused at the start.
        value.and_then(|value| objects.clone().storing(reading.object, value).ok()).unwrap_or(objects)
    })
}

/// A good supply, V, and a good temperature, °C, of a simulated drive that tells both as they are.
pub fn good_readings(readings: &Readings) -> [f32; QUANTITIES] {
    let mut places = readings.iter().zip(Quantity::ALL);
    [(); QUANTITIES].map(|()| {
        places.next().map_or(0.0, |(reading, quantity)| {
            let limits = reading.map(|reading| reading.limits.warn());
            limits.map_or(usual(quantity), |limits| well_within(usual(quantity), limits)) as f32
        })
    })
}

/// `usual`, or what is so far within the limits that an `f32` is, too.
fn well_within(usual: f64, [least, most]: [f64; 2]) -> f64 {
    match (least.is_finite(), most.is_finite()) {
        _ if (least..=most).contains(&usual) => usual,
        (true, true) => f64::midpoint(least, most),
        (true, false) => least + 1.0,
        _ => most - 1.0,
    }
}

const fn usual(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::SupplyVoltage => USUAL_VOLTAGE,
        Quantity::Temperature => USUAL_TEMPERATURE,
    }
}

fn of(readings: &Readings) -> impl Iterator<Item = (Quantity, &Reading)> {
    Quantity::ALL.into_iter().zip(readings).filter_map(|(quantity, reading)| Some((quantity, reading.as_ref()?)))
}

/// What the object reads when all is well: the usual value, or the nearest to it of which nothing is said.
fn good(quantity: Quantity, reading: &Reading) -> i128 {
    let [least, most] = reading.limits.warn().map(|limit| limit / reading.scale);
    let usual = usual(quantity) / reading.scale;
    let whole = if usual < least {
        least.ceil()
    } else if usual > most {
        most.floor()
    } else {
        usual.round()
    };
    whole as i128
}

#[cfg(test)]
mod tests {
    use uarm_io::drive::readings::{ReadingLimits, Verdict};
    use uarm_io::drive::{Address, DataType};

    use super::*;

    fn reading(index: u16, scale: f64, [least, most]: [f64; 2]) -> Reading {
        let limits = ReadingLimits::new([least, most], [least - 1.0, most + 1.0]).unwrap();
        Reading { object: Address::new(index, 0), data_type: DataType::Unsigned16, scale, limits }
    }

    #[test]
    fn a_good_value_is_one_of_which_nothing_is_said() {
        for (quantity, scale, limits, expected) in [
            (Quantity::SupplyVoltage, 0.1, [20.0, 28.0], 240),
            (Quantity::SupplyVoltage, 0.1, [44.05, 52.0], 441),
            (Quantity::SupplyVoltage, 1.0, [10.0, 12.9], 12),
            (Quantity::SupplyVoltage, 1e-3, [f64::NEG_INFINITY, 30.0], 24_000),
            (Quantity::Temperature, 1.0, [f64::NEG_INFINITY, 80.0], 30),
            (Quantity::Temperature, 0.1, [-20.0, 15.0], 150),
        ] {
            let reading = reading(0x2206, scale, limits);
            let found = good(quantity, &reading);
            assert_eq!(found, expected, "{quantity:?} {limits:?}");
            assert_eq!(reading.limits.verdict(found as f64 * scale), Verdict::Good);
        }
    }

    #[test]
    fn a_good_value_is_well_within_its_limits() {
        for (limits, expected) in [
            ([20.0, 28.0], 24.0),
            ([40.3, 56.3], 48.3),
            ([40.0, f64::INFINITY], 41.0),
            ([f64::NEG_INFINITY, 12.0], 11.0),
        ] {
            let found = well_within(24.0, limits);
            assert!((found - expected).abs() < 1e-9, "{limits:?}: {found}");
        }
        assert_eq!(good_readings(&[None, None]), [24.0, 30.0]);
    }

    #[test]
    fn a_dictionary_states_a_measurement_seldom() {
        let readings = [Some(reading(0x2206, 0.1, [20.0, 28.0])), Some(reading(0x2207, 0.1, [0.0, 80.0]))];
        let unstated_in = |keys: &str| {
            let text = format!("[2206]\nDataType=6\n{keys}\n[2207]\nDataType=6\nAccessType=ro\nDefaultValue=250\n");
            let dictionary = Dictionary::parse("own.eds", text.as_bytes()).unwrap();
            unstated(&dictionary, 2, &readings).map(|(quantity, _)| quantity).collect::<Vec<_>>()
        };
        assert_eq!(unstated_in("AccessType=ro\n"), [Quantity::SupplyVoltage]);
        assert_eq!(unstated_in("AccessType=ro\nDefaultValue=0\n"), [Quantity::SupplyVoltage]);
        assert_eq!(unstated_in("AccessType=rw\nDefaultValue=0\n"), []);
        assert_eq!(unstated_in("AccessType=ro\nDefaultValue=240\n"), []);
        let without = Dictionary::parse("own.eds", b"[2207]\nDataType=6\nAccessType=ro\nDefaultValue=250\n").unwrap();
        assert_eq!(unstated(&without, 2, &readings).count(), 0, "an object that is absent is refused at the start");
    }
}
