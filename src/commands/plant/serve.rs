//! The robot on its bus: frames answered, time passed on, faults brought about, the truth written down.

use std::io::{ErrorKind, Write};
use std::time::Duration;

use uarm_io::drive::wire::Channel;
use uarm_io::link::{Link, LinkError, LinkErrorKind};
use uarm_io::monotonic::MonotonicClock;
use uarm_io::socketcan_link::SocketCanLink;
use uarm_io::time::Clock;
use uarm_loop::stop_request::StopRequest;
use uarm_sim::Outbox;

use super::bench::Bench;
use super::faults::Schedule;
use super::truth::TruthFile;

/// How long the robot waits for a frame before it looks whether it shall end, or whether a fault was ordered.
const LONGEST_WAIT: Duration = Duration::from_millis(20);

/// What is done with the robot beside answering.
pub struct Extras {
    /// The faults to come.
    pub faults: Schedule,
    /// Where the truth goes.
    pub truth: Option<TruthFile>,
    /// The line that is printed once the drives listen.
    pub ready: String,
}

/// Answers frames and lets time pass, until `stop` is made.
///
/// # Errors
/// If the link fails in a way that does not pass, or the truth cannot be written.
pub fn serve(
    robot: &mut dyn Bench,
    mut link: SocketCanLink,
    stop: &StopRequest,
    mut extras: Extras,
) -> anyhow::Result<()> {
    let clock = MonotonicClock;
    let mut outbox = Outbox::new();
    robot.power_on(clock.now(), &mut outbox);
    flush(&mut outbox, &mut link)?;
    say(&extras.ready)?;
    while !stop.is_made() {
        flush(&mut outbox, &mut link)?;
        let wait = clock.now() + LONGEST_WAIT;
        let deadline = robot.next_deadline().map_or(wait, |deadline| deadline.min(wait));
        match link.receive(deadline) {
            Ok(Some(received)) => {
                robot.on_frame(&received.frame, clock.now(), &mut outbox);
                if let (Some(Channel::Sync), Some(file)) = (Channel::of(received.frame.id()), &mut extras.truth) {
                    file.write(robot.truth().as_ref())?;
                }
            }
            Ok(None) => robot.on_time(clock.now(), &mut outbox),
            Err(error) => {
                robot.on_time(clock.now(), &mut outbox);
                bear(error, &mut link)?;
            }
        }
        for order in extras.faults.due(robot.time()) {
            robot.obey(&order, clock.now(), &mut outbox);
        }
    }
    extras.truth.map_or(Ok(()), TruthFile::finish)
}

/// A line on standard output, at once: another program waits for it. That it has gone away is no reason to end.
fn say(line: &str) -> anyhow::Result<()> {
    let mut output = std::io::stdout().lock();
    match writeln!(output, "{line}").and_then(|()| output.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

fn flush(outbox: &mut Outbox, link: &mut SocketCanLink) -> anyhow::Result<()> {
    while let Some(pending) = outbox.pop() {
        if let Err(error) = link.send(&pending.frame) {
            bear(error, link)?;
        }
    }
    Ok(())
}

/// A robot outlives its bus: it waits, while its drives notice the silence and brake.
fn bear<E: LinkError + Send + Sync + 'static>(error: E, link: &mut SocketCanLink) -> anyhow::Result<()> {
    match error.kind() {
        LinkErrorKind::Down | LinkErrorKind::QueueFull | LinkErrorKind::Controller | LinkErrorKind::BusOff => {
            std::thread::sleep(Duration::from_millis(1));
            Ok(())
        }
        LinkErrorKind::Gone => {
            std::thread::sleep(LONGEST_WAIT);
            // As long as the interface is not back this fails, and is tried again.
            let _ = link.reopen();
            Ok(())
        }
        _ => Err(anyhow::Error::new(error)),
    }
}
