use super::*;
use proptest::prelude::*;

const PERIOD: Duration = Duration::from_millis(3);

fn configuration(counts: u32, bits: u8, direction: Direction, zero: i32) -> EncoderConfiguration {
    EncoderConfiguration {
        counts_per_revolution: CountsPerRevolution::new(counts).unwrap(),
        counter_width: CounterWidth::new(bits).unwrap(),
        direction,
        zero,
        jump_limit: JumpLimit::new(10.0, 4).unwrap(),
    }
}

/// What a counter of `bits` bits shows at `count`: the low bits, the rest garbage as a drive may leave it.
fn shown(count: i64, bits: u8, garbage: u32) -> i32 {
    let mask = if bits == 32 { u32::MAX } else { (1 << bits) - 1 };
    ((count as u32 & mask) | (garbage & !mask)) as i32
}

#[test]
fn ranges_are_checked() {
    assert_eq!(CounterWidth::new(7), Err(EncoderError::CounterWidth { bits: 7 }));
    assert_eq!(CounterWidth::new(33), Err(EncoderError::CounterWidth { bits: 33 }));
    assert_eq!(CountsPerRevolution::new(3), Err(EncoderError::CountsPerRevolution { counts: 3 }));
    assert!(JumpLimit::new(f64::NAN, 0).is_err());
    assert!(JumpLimit::new(0.0, 0).is_err());
}

/// A motor of 4096 counts behind a gear of 100 to 3 makes 409600 counts in three revolutions of the joint, which is
/// 136533 and a third in one.
#[test]
fn a_gear_makes_a_ratio_of_counts() {
    let gear = GearRatio::new(100, 3).unwrap();
    let counts = CountsPerRevolution::behind(4096, gear).unwrap();
    assert_eq!(counts.ratio(), (409_600, 3));
    assert_eq!(counts.of_motor(gear), Some(4096));
    assert!((counts.per_revolution() - 136_533.333_333_333_33).abs() < 1e-9);
    assert_eq!(CountsPerRevolution::behind(4096, GearRatio::DIRECT), CountsPerRevolution::new(4096));
    assert!(CountsPerRevolution::behind(1 << 30, GearRatio::new(100, 1).unwrap()).is_err());
    assert!(CountsPerRevolution::behind(3, gear).is_err());
}

/// The sums are made in whole numbers: counts, and revolutions as counts over counts per revolution.
#[test]
fn nothing_is_lost_over_many_revolutions_behind_a_gear() {
    let (motor_counts, motor, joint) = (5000_i128, 157_i128, 13_i128);
    let gear = GearRatio::new(157, 13).unwrap();
    for (bits, step) in [(16_u8, 12_345_i64), (16, -20_011), (32, 1_000_003)] {
        let counts = CountsPerRevolution::behind(5000, gear).unwrap();
        let fast = JumpLimit::new(1e9, u32::try_from(step.abs()).unwrap()).unwrap();
        let mut encoder = Encoder::new(EncoderConfiguration {
            counts_per_revolution: counts,
            jump_limit: fast,
            ..configuration(8000, bits, Direction::Positive, 0)
        });
        let mut exact = 0_i64;
        encoder.update(0, Duration::ZERO).unwrap();
        for _ in 0..100_000 {
            exact += step;
            assert_eq!(encoder.update(shown(exact, bits, 0), Duration::from_nanos(1)), Ok(exact));
        }
        // Revolutions of the joint: count · 13 / (5000 · 157), the whole ones apart, so that no digit is lost.
        let (over, under) = (i128::from(exact) * joint, motor_counts * motor);
        let (whole, rest) = (over.div_euclid(under), over.rem_euclid(under));
        let angle = core::f64::consts::TAU * (whole as f64 + rest as f64 / under as f64);
        assert!((encoder.angle().unwrap() - angle).abs() <= 4.0 * f64::EPSILON * angle.abs(), "{bits} bits, {step}");
    }
}

#[test]
fn a_jump_names_its_counts_and_leaves_the_encoder_as_it_was() {
    // 10 rad/s over 3 ms are 38.2 of 8000 counts per revolution; with the margin of 4 that makes 42.
    let mut encoder = Encoder::new(configuration(8000, 32, Direction::Positive, 0));
    encoder.update(1000, Duration::ZERO).unwrap();
    assert_eq!(encoder.update(1042, PERIOD), Ok(1042));
    assert_eq!(encoder.update(1085, PERIOD), Err(EncoderError::Jump { change: 43, limit: 42, elapsed: PERIOD }));
    assert_eq!(encoder.angle(), Some(encoder.angle_of(1042)));
    // The refused reading's time counts: now the same reading is within reach.
    assert_eq!(encoder.update(1085, PERIOD), Ok(1085));
}

#[test]
fn a_jump_is_judged_alike_in_both_directions() {
    for direction in [Direction::Positive, Direction::Negative] {
        for sign in [1, -1] {
            let mut encoder = Encoder::new(configuration(8000, 32, direction, 0));
            encoder.update(0, Duration::ZERO).unwrap();
            let refused = Err(EncoderError::Jump { change: i64::from(43 * sign), limit: 42, elapsed: PERIOD });
            assert_eq!(encoder.update(43 * sign, PERIOD), refused);
            let mut encoder = Encoder::new(configuration(8000, 32, direction, 0));
            encoder.update(0, Duration::ZERO).unwrap();
            assert!(encoder.update(42 * sign, PERIOD).is_ok());
        }
    }
}

/// No time, no turning: only the margin is left of the limit.
#[test]
fn without_time_the_margin_is_believed() {
    for (margin, believed, refused) in [(0, 0, 1), (1, 1, 2), (4, 4, 5)] {
        let jump_limit = JumpLimit::new(10.0, margin).unwrap();
        let configuration = EncoderConfiguration { jump_limit, ..configuration(8000, 32, Direction::Positive, 0) };
        let mut encoder = Encoder::new(configuration);
        encoder.update(0, Duration::ZERO).unwrap();
        let (change, limit, elapsed) = (i64::from(refused), i64::from(margin), Duration::ZERO);
        assert_eq!(encoder.update(refused, elapsed), Err(EncoderError::Jump { change, limit, elapsed }));
        assert_eq!(encoder.update(believed, elapsed), Ok(i64::from(believed)));
    }
}

/// 10 rad/s over 3 ms are 38 counts here: with a margin of 90 the limit is half the range of 8 bits, with 89 below it.
#[test]
fn a_limit_of_half_the_range_is_ambiguous() {
    for (margin, ambiguous) in [(89, false), (90, true)] {
        let jump_limit = JumpLimit::new(10.0, margin).unwrap();
        let configuration = EncoderConfiguration { jump_limit, ..configuration(8000, 8, Direction::Positive, 0) };
        let mut encoder = Encoder::new(configuration);
        encoder.update(0, Duration::ZERO).unwrap();
        let outcome = encoder.update(1, PERIOD);
        assert_eq!(matches!(outcome, Err(EncoderError::Ambiguous { limit: 128, half_range: 128, .. })), ambiguous);
        assert_eq!(outcome == Ok(1), !ambiguous);
    }
}

#[test]
fn a_gap_that_a_narrow_counter_cannot_bridge_is_refused() {
    let mut encoder = Encoder::new(configuration(8000, 8, Direction::Positive, 0));
    encoder.update(0, Duration::ZERO).unwrap();
    let elapsed = Duration::from_millis(10);
    let limit = 127 + 4;
    assert_eq!(encoder.update(1, elapsed), Err(EncoderError::Ambiguous { limit, half_range: 128, bits: 8, elapsed }));
}

#[test]
fn the_count_of_an_angle_rounds_half_up() {
    let counts = CountsPerRevolution::new(8).unwrap();
    let step = counts.resolution();
    assert_eq!([-0.51, -0.49, 0.49, 0.5, 7.9].map(|turned| counts.count_at(turned * step)), [-1, 0, 0, 1, 8]);
}

#[test]
fn a_negative_direction_negates_counts() {
    let mut encoder = Encoder::new(configuration(8000, 32, Direction::Negative, 0));
    assert_eq!(encoder.update(-10, Duration::ZERO), Ok(10));
    assert_eq!(encoder.update(-25, PERIOD), Ok(25));
    let mut encoder = Encoder::new(configuration(8000, 32, Direction::Negative, 100));
    assert_eq!(encoder.update(103, Duration::ZERO), Ok(-3));
}

#[test]
fn a_known_pose_sets_the_zero() {
    for direction in [Direction::Positive, Direction::Negative] {
        let angle = 20_f64.to_radians();
        let configuration = configuration(33_739, 24, direction, 0).referenced(-77_123, angle);
        let mut encoder = Encoder::new(configuration);
        let count = encoder.update(-77_123, Duration::ZERO).unwrap();
        assert_eq!(count, configuration.counts_per_revolution.count_at(angle));
    }
}

proptest! {
    /// A shaft walks at random over many wraps of its counter; the encoder follows without losing a count.
    #[test]
    fn unwrapping_is_exact(
        bits in CounterWidth::RANGE,
        reversed in any::<bool>(),
        zero in any::<i32>(),
        start in -100_i64..100,
        steps in proptest::collection::vec(-42_i64..=42, 0..300),
        garbage in any::<u32>(),
    ) {
        let direction = if reversed { Direction::Negative } else { Direction::Positive };
        let mut encoder = Encoder::new(configuration(8000, bits, direction, zero));
        let mut count = start;
        let show = |count: i64| shown(i64::from(zero) + direction.apply(count), bits, garbage);
        prop_assert_eq!(encoder.update(show(count), Duration::ZERO), Ok(count));
        for step in steps {
            count += step;
            prop_assert_eq!(encoder.update(show(count), PERIOD), Ok(count));
        }
    }

    /// Steady turning wraps narrow counters several times, either way.
    #[test]
    fn steady_turning_wraps_exactly(bits in 8_u8..=11, speed in prop_oneof![-42_i64..=-1, 1_i64..=42]) {
        let mut encoder = Encoder::new(configuration(8000, bits, Direction::Positive, 0));
        let cycles = 3 * (1 << bits) / speed.abs();
        for cycle in 0..cycles {
            let count = cycle * speed;
            prop_assert_eq!(encoder.update(shown(count, bits, 0), PERIOD), Ok(count));
        }
    }

    /// Quantising and reading back is the formula of the model of the robot, bit for bit.
    #[test]
    fn angles_are_multiples_of_the_resolution(angle in -50.0_f64..50.0, counts in 2_000_u32..70_000) {
        let counts = CountsPerRevolution::new(counts).unwrap();
        let step = core::f64::consts::TAU / counts.per_revolution();
        let encoder = Encoder::new(configuration(counts.of_motor(GearRatio::DIRECT).unwrap(), 32, Direction::Positive, 0));
        prop_assert_eq!(encoder.angle_of(counts.count_at(angle)), (angle / step + 0.5).floor() * step);
    }

    #[test]
    fn nothing_a_drive_reports_panics(
        bits in CounterWidth::RANGE,
        zero in any::<i32>(),
        readings in proptest::collection::vec((any::<i32>(), 0_u64..u64::MAX), 0..50),
    ) {
        let mut encoder = Encoder::new(configuration(1 << 30, bits, Direction::Negative, zero));
        for (raw, nanoseconds) in readings {
            let before = encoder.angle();
            if encoder.update(raw, Duration::from_nanos(nanoseconds)).is_err() {
                prop_assert_eq!(encoder.angle(), before);
            }
        }
    }
}
