//! `uarm plant` and `uarm run` as processes.

use rustix::process::{Pid, Signal, kill_process};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use super::bus::{Bus, HEARTBEAT};
use super::{INTERFACE, Workshop};

/// The priority of the emulated robot where timing counts: below the controller's, as a drive does not run on its CPU.
const ROBOT_PRIORITY: &str = "60";

/// Longer than an emulated robot takes to boot.
const BOOT_TIME: Duration = Duration::from_secs(60);

/// How finely the plant is integrated where the loop is what is looked at: in guest time the integration is most of the work.
pub const COARSE_STEP: &str = "1ms";

/// How a process is scheduled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheduling {
    Ordinary,
    Fifo,
}

/// The emulated robot, killed when dropped.
pub struct Robot(Child);

impl Robot {
    /// Starts another one on the same bus, with the robot file at `robot`, and waits until its drive of `node` has booted.
    pub fn start_beside(workshop: &Workshop, bus: &Bus, robot: &Path, node: u8) -> Self {
        bus.drain();
        let mut command = workshop.command();
        command.args(["plant", "--can", INTERFACE, "--robot"]).arg(robot);
        let robot = Self(command.stdout(Stdio::null()).spawn().unwrap());
        bus.wait_for("boot-up message", BOOT_TIME, |seen| seen.id == HEARTBEAT + u16::from(node));
        robot
    }

    /// Starts it, and waits until its drives have booted.
    pub fn start(workshop: &Workshop, bus: &Bus, scheduling: Scheduling, arguments: &[&str]) -> Self {
        let uarm = workshop.uarm();
        let mut command = match scheduling {
            Scheduling::Ordinary => Command::new(uarm),
            Scheduling::Fifo => {
                let mut chrt = Command::new("chrt");
                chrt.args(["--fifo", ROBOT_PRIORITY]).arg(uarm);
                chrt
            }
        };
        bus.drain();
        command.args(["plant", "--can", INTERFACE, "--robot"]).arg(workshop.robot()).args(arguments);
        let robot = Self(command.stdout(Stdio::null()).spawn().unwrap());
        bus.wait_for_boot_up();
        robot
    }

    /// Is it still there?
    pub fn is_alive(&mut self) -> bool {
        self.0.try_wait().unwrap().is_none()
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }
}

/// A command that runs the controller on the interface.
pub fn controller(workshop: &Workshop, arguments: &[&str]) -> Command {
    let mut command = workshop.command();
    command.args(["run", "--can", INTERFACE, "--robot"]).arg(workshop.robot()).args(arguments);
    if !arguments.contains(&"--rt") {
        command.args(["--rt", "prefer"]); // a native run may have no right to SCHED_FIFO
    }
    command
}

/// A process in the background, its output kept; killed when dropped, so that a failed test leaves nothing behind.
pub struct Running(Option<Child>);

impl Running {
    /// Starts a command.
    pub fn start(command: &mut Command) -> Self {
        Self(Some(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()))
    }

    /// Sends a signal.
    pub fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(self.0.as_ref().expect("not ended")), signal).unwrap();
    }

    /// Is it still there?
    pub fn is_alive(&mut self) -> bool {
        self.0.as_mut().expect("not ended").try_wait().unwrap().is_none()
    }

    /// Waits for its end.
    pub fn end(mut self) -> Output {
        self.0.take().expect("not ended").wait_with_output().unwrap()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(mut child) = self.0.take() {
            // It may have ended by itself.
            let _ = child.kill();
            let output = child.wait_with_output().unwrap();
            println!("{}", describe(&output));
        }
    }
}

/// Runs a command to its end, which must be a success.
pub fn succeed(command: &mut Command) -> Output {
    end_with(command, &[0])
}

/// Runs `uarm` to its end, which must be a finished run; deadlines may have been missed.
pub fn finish(command: &mut Command) -> Output {
    const FINISHED_WITH_A_LOSS: i32 = 3;
    end_with(command, &[0, FINISHED_WITH_A_LOSS])
}

fn end_with(command: &mut Command, codes: &[i32]) -> Output {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let ended = output.status.code().is_some_and(|code| codes.contains(&code));
    assert!(ended, "{command:?}: {}\n{}", output.status, describe(&output));
    output
}

/// Both outputs of a process, for the message of a failed assertion.
pub fn describe(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// Sets the interface up or down.
pub fn set_interface(state: &str) {
    succeed(Command::new("ip").args(["link", "set", INTERFACE, state]));
}
