//! Reading a joint's counts while it is turned, as long as its motor is off.

use std::time::Duration;

use uarm_io::drive::cia402::{PowerState, Statusword};
use uarm_io::drive::objects::{POSITION_ACTUAL, STATUSWORD};
use uarm_io::drive::sdo::{Bystander, Patience};
use uarm_io::drive::{NodeId, Value};
use uarm_io::link::Link;
use uarm_io::time::Clock;
use uarm_loop::stop_request::StopRequest;

use super::turning::Turning;

/// Time between two readings. A hand turns a joint by a few per cent of a revolution meanwhile.
const READING_INTERVAL: Duration = Duration::from_millis(20);
const PATIENCE: Patience = Patience { timeout: Duration::from_millis(200), attempts: 3 };

/// Reads the counts of `node` until a stop request, or for `limit`; shows each reading to `show`.
///
/// # Errors
/// If the drive does not answer, or its power stage is on.
pub fn watch<L: Link, C: Clock>(
    link: &mut L,
    clock: &C,
    node: NodeId,
    limit: Option<Duration>,
    stop: &StopRequest,
    mut show: impl FnMut(&Turning),
) -> anyhow::Result<Turning>
where
    L::Error: Send + Sync + 'static,
{
    let begin = clock.now();
    let mut bus = Bystander::new(link, clock, PATIENCE, |_| {});
    let mut turning = Turning::default();
    while !stop.is_made() && limit.is_none_or(|limit| clock.now().since(begin) < limit) {
        match bus.read(node, &STATUSWORD)? {
            Value::Unsigned16(bits) => demand_off(node, Statusword::from_bits(bits))?,
            value => anyhow::bail!("node {}: its statusword 6041h reads as {value:?}", node.raw()),
        }
        match bus.read(node, &POSITION_ACTUAL)? {
            Value::Integer32(position) => turning.note(position),
            value => anyhow::bail!("node {}: its position 6064h reads as {value:?}", node.raw()),
        }
        show(&turning);
        bus.listen(READING_INTERVAL)?;
    }
    Ok(turning)
}

/// A joint that a motor holds or moves is nothing to turn by hand.
fn demand_off(node: NodeId, statusword: Statusword) -> anyhow::Result<()> {
    match statusword.state() {
        Some(
            PowerState::NotReadyToSwitchOn
            | PowerState::SwitchOnDisabled
            | PowerState::ReadyToSwitchOn
            | PowerState::Fault,
        ) => Ok(()),
        _ => anyhow::bail!(
            "node {} is in {statusword}: its power stage may be on, expected Switch on disabled; end what drives it",
            node.raw()
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulated_bus::{bus, node};
    use uarm_io::drive::cia402::Command;
    use uarm_io::drive::cia402::Controlword;
    use uarm_io::encoder::Direction;
    use uarm_sim::Joint;
    use uarm_sim::drive::DriveFault;

    #[test]
    fn a_joint_that_was_turned_before_the_end_is_seen() {
        let (mut link, clock) = bus();
        let limit = Some(Duration::from_secs(1));
        let still = watch(&mut link, &clock, node(), limit, &StopRequest::default(), |_| {}).unwrap();
        // A reading every 20 ms; virtual time passes only between them.
        assert_eq!((still.direction(), still.readings()), (None, 50));
        // The request to stop comes from within, after the joint was turned between two readings.
        let stop = StopRequest::default();
        let mut turning = Turning::default();
        turning.note(still.last());
        link.inject(Joint::TWO, DriveFault::EncoderJump { counts: -500 });
        let moved = watch(&mut link, &clock, node(), None, &stop, |_| stop.make()).unwrap();
        turning.note(moved.last());
        assert_eq!(turning.direction(), Some(Direction::Negative));
    }

    #[test]
    fn a_drive_that_is_on_is_refused() {
        let (mut link, clock) = bus();
        let mut bus = Bystander::new(&mut link, &clock, PATIENCE, |_| {});
        for command in [Command::Shutdown, Command::SwitchOn] {
            let word = Value::Unsigned16(Controlword::of(command).bits());
            bus.write(node(), uarm_io::drive::objects::CONTROLWORD.address(), word).unwrap();
        }
        let error = watch(&mut link, &clock, node(), None, &StopRequest::default(), |_| {}).unwrap_err().to_string();
        assert!(error.contains("node 2 is in Switched on") && error.contains("Switch on disabled"), "{error}");
    }
}
