//! Counts of an encoder that counts backwards become angles and velocities; a torque becomes per mille.

use uarm_io::encoder::{CounterWidth, CountsPerRevolution, Direction, Encoder, EncoderConfiguration, JumpLimit};
use uarm_io::estimator::{LowPassDerivative, VelocityEstimator};
use uarm_io::time::Duration;
use uarm_io::torque::{RatedTorque, TorqueCeiling, TorqueScale};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut encoder = Encoder::new(EncoderConfiguration {
        counts_per_revolution: CountsPerRevolution::new(8_000)?,
        counter_width: CounterWidth::new(16)?,
        direction: Direction::Negative,
        zero: 0,
        jump_limit: JumpLimit::new(10.0, 1)?,
    });
    let mut estimator = VelocityEstimator::new(LowPassDerivative::new(27.8)?);
    let period = Duration::from_millis(3);
    for raw in [0, -10, -20, -30] {
        let count = encoder.update(raw, period)?;
        let estimate = estimator.update(encoder.angle_of(count), period.as_secs_f64());
        println!("{:.5} rad, {:.3} rad/s", estimate.position, estimate.velocity);
    }
    let scale = TorqueScale {
        rated_torque: RatedTorque::from_millinewton_metres(200)?,
        direction: Direction::Negative,
        ceiling: TorqueCeiling::RATED,
        transmission: Default::default(),
    };
    assert_eq!(scale.to_drive(0.1)?.per_mille, -500);
    Ok(())
}
