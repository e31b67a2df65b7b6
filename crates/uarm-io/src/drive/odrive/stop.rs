//! From any state to *idle*, as well as it can be done.

use super::master::OdriveNetwork;
use super::start::Feeding;
use super::wire::{self, AxisState};
use crate::drive::network::{Confirmation, DriveStop, StopReport};
use crate::link::Link;
use crate::time::{Clock, Duration, Instant};

impl<L: Link, const JOINTS: usize> OdriveNetwork<L, JOINTS> {
    /// Torque 0 and *idle* to all axes, and after that the emergency stop to those that did not confirm. Each step goes to
    /// all axes before any is waited for.
    ///
    /// Confirmed is a heartbeat with *idle*; it stands for all three steps of the report, since quick stop and NMT stop have
    /// no counterpart. Nothing is sent on a bus that was found to be another master's.
    pub(super) fn stop_axes<C: Clock>(&mut self, clock: &C) -> StopReport<JOINTS> {
        if self.is_withheld {
            let withheld = Confirmation::Withheld;
            return StopReport {
                drives: self.axes.map(|axis| DriveStop {
                    node: axis.node.raw(),
                    quick_stop: withheld,
                    power_off: withheld,
                    nmt_stop: withheld,
                    last_defence: axis.last_defence,
                }),
            };
        }
        let _ = self.torques([0.0; JOINTS]);
        let idle = self.nodes().map(|node| self.send(&wire::state_frame(node, AxisState::IDLE)).is_ok());
        // Not longer than an axis may take to tell: its watchdog has disarmed it by then in any case.
        let waited = self.configuration.times.heartbeat_timeout + self.configuration.times.watchdog;
        let begun = clock.now();
        self.await_idle(clock, begun, waited);
        let unconfirmed = self.axes.map(|axis| (axis.node, axis.is_idle_since(begun)));
        let mut again = false;
        for (node, confirmed) in unconfirmed {
            again |= !confirmed && self.send(&wire::estop_frame(node)).is_ok();
        }
        if again {
            self.await_idle(clock, begun, waited);
        }
        let mut drives = [DriveStop::default(); JOINTS];
        for ((drive, axis), sent) in drives.iter_mut().zip(&self.axes).zip(idle) {
            let power_off = match (axis.is_idle_since(begun), sent) {
                (true, _) => Confirmation::Confirmed,
                (false, true) => Confirmation::Unconfirmed,
                (false, false) => Confirmation::NotSent,
            };
            *drive = DriveStop {
                node: axis.node.raw(),
                quick_stop: power_off,
                power_off,
                nmt_stop: power_off,
                last_defence: axis.last_defence,
            };
        }
        StopReport { drives }
    }

    fn await_idle<C: Clock>(&mut self, clock: &C, since: Instant, waited: Duration) {
        // A link that fails here leaves the axes to their watchdogs; the report tells.
        let _ = self
            .wait(clock, clock.now() + waited, Feeding::Off, |axes| axes.iter().all(|axis| axis.is_idle_since(since)));
    }
}
