//! SDO access to a drive that a run has left in NMT state *Stopped*, in which no drive answers, and many say nothing.

use std::time::Duration;

use uarm_io::drive::objects::DEVICE_TYPE;
use uarm_io::drive::sdo::{Bystander, Patience, SdoError};
use uarm_io::drive::wire::{self, Channel};
use uarm_io::drive::{NmtCommand, NmtState, NodeId};
use uarm_io::link::Link;
use uarm_io::time::Clock;

const PATIENCE: Patience = Patience { timeout: Duration::from_millis(200), attempts: 1 };
/// How long a heartbeat is waited for: drives send theirs several times a second.
const LISTENING: Duration = Duration::from_secs(1);

/// Makes sure that `node` answers SDO requests. A drive that does, in a run too, is left alone. One that does not, and that either says
/// *Stopped* in its heartbeat or has none, gets the NMT command *enter pre-operational*, which moves nothing: a drive in any other state
/// would have answered.
///
/// The link must receive the SDO answers and the heartbeat of `node`: see [`identifiers`].
///
/// # Errors
/// If the drive does not answer, not even then.
pub fn ensure<L: Link, C: Clock>(link: &mut L, clock: &C, node: NodeId) -> anyhow::Result<()>
where
    L::Error: Send + Sync + 'static,
{
    let mut state = None;
    let mut bus = Bystander::new(link, clock, PATIENCE, |received| {
        if Channel::of(received.frame.id()) == Some(Channel::Heartbeat(node)) {
            state = wire::decode_heartbeat(received.frame.data()).ok();
        }
    });
    let Err(silence) = answers(bus.read(node, &DEVICE_TYPE))? else { return Ok(()) };
    bus.listen(LISTENING)?;
    if state.is_some_and(|state| state != NmtState::Stopped) {
        return Err(silence.into());
    }
    link.send(&wire::nmt_frame(NmtCommand::EnterPreOperational, node))?;
    let mut bus = Bystander::new(link, clock, PATIENCE, |_| {});
    Ok(answers(bus.read(node, &DEVICE_TYPE))??)
}

/// What `node` must be heard with.
pub fn identifiers(node: NodeId) -> [uarm_io::embedded_can::StandardId; 2] {
    [Channel::SdoResponse(node).identifier(), Channel::Heartbeat(node).identifier()]
}

/// Silence apart from other errors; any answer will do.
fn answers<T, E>(outcome: Result<T, SdoError<E>>) -> Result<Result<(), SdoError<E>>, SdoError<E>> {
    match outcome {
        Ok(_) | Err(SdoError::Abort { .. } | SdoError::Response { .. }) => Ok(Ok(())),
        Err(silence @ SdoError::Timeout { .. }) => Ok(Err(silence)),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulated_bus::{bus, node};
    use uarm_io::drive::Value;
    use uarm_io::drive::objects::PRODUCER_HEARTBEAT_TIME;
    use uarm_io::frame::Frame;
    use uarm_io::link::{FrameDirection, ObservedLink};

    /// The NMT commands that are sent to make node 2 answer, after `before`; it has a heartbeat, or none if that is 0.
    fn commands(heartbeat_ms: u16, before: &[NmtCommand]) -> (anyhow::Result<()>, Vec<Frame>) {
        let (mut link, clock) = bus();
        let mut master = Bystander::new(&mut link, &clock, PATIENCE, |_| {});
        master.write(node(), PRODUCER_HEARTBEAT_TIME.address(), Value::Unsigned16(heartbeat_ms)).unwrap();
        for command in before {
            master.send(&wire::nmt_frame(*command, node())).unwrap();
        }
        let mut sent = Vec::new();
        let mut observed = ObservedLink::new(link, |direction, frame: &Frame, _| {
            if direction == FrameDirection::Sent && Channel::of(frame.id()) == Some(Channel::NmtCommand) {
                sent.push(*frame);
            }
        });
        (ensure(&mut observed, &clock, node()), sent)
    }

    #[test]
    fn a_stopped_drive_is_made_to_answer_and_any_other_is_left_alone() {
        // As after a start that was refused before the heartbeat was written, too.
        for heartbeat_ms in [50, 0] {
            let (outcome, sent) = commands(heartbeat_ms, &[NmtCommand::StopRemoteNode]);
            outcome.unwrap();
            // CiA 301, 7.2.8.3.1: 80h enters Pre-operational.
            assert_eq!(sent.iter().map(Frame::data).collect::<Vec<_>>(), [[0x80, 2]]);
        }
        for before in [&[][..], &[NmtCommand::StartRemoteNode]] {
            let (outcome, sent) = commands(50, before);
            outcome.unwrap();
            assert_eq!(sent, []);
        }
    }

    #[test]
    fn a_drive_that_is_not_there_is_named() {
        let (mut link, clock) = bus();
        let absent = NodeId::new(9).unwrap();
        let error = ensure(&mut link, &clock, absent).unwrap_err().to_string();
        assert!(error.contains("node 9 did not answer"), "{error}");
    }
}
