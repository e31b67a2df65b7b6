//! The in-process robot runs on the real-time thread: after it is built it does not allocate, whatever happens.

mod support;

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use std::time::Duration;
use support::{PERIOD, drives, lockstep, node};
use uarm_io::drive::NmtCommand;
use uarm_io::drive::cia402::{Command, Controlword};
use uarm_io::drive::wire::{self, DriveCommand};
use uarm_io::link::Link;
use uarm_io::time::{Clock, Instant};
use uarm_sim::{DriveFault, EmulatedRobot, InProcessLink, Joint, UarmPlant, UarmPlantParameters, VirtualClock};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

fn drain(link: &mut impl Link, until: Instant) -> usize {
    core::iter::from_fn(|| link.receive(until).ok().flatten()).count()
}

#[test]
fn nothing_is_allocated_after_construction() {
    let nominal = dem_model::ThreeLinkDem::table_2();
    let plant = UarmPlant::new(&nominal, UarmPlantParameters::fitted()).unwrap();
    let mut clock = VirtualClock::new();
    let mut link = InProcessLink::new(EmulatedRobot::new(plant, drives(), lockstep()).unwrap(), clock.clone());
    let heard = assert_no_alloc(|| {
        let mut heard = 0;
        let _ = link.send(&wire::nmt_frame(NmtCommand::ResetCommunication, node(2)));
        // Mode of operation 10 by SDO, then a request that is refused.
        for mode in [10, 3] {
            let _ = link.send(&wire::sdo_request_frame(node(2), &[0x2F, 0x60, 0x60, 0, mode, 0, 0, 0]));
        }
        // A SYNC with counter.
        for id in 1..=3 {
            let _ = link.send(&wire::sdo_request_frame(node(id), &[0x2F, 0x19, 0x10, 0, 240, 0, 0, 0]));
        }
        let _ = link.send(&wire::nmt_frame(NmtCommand::StartRemoteNode, uarm_io::drive::NodeId::BROADCAST));
        for command in [Command::Shutdown, Command::EnableOperation] {
            for id in 1..=3 {
                let command = DriveCommand { controlword: Controlword::of(command), target_torque: 100 };
                let _ = link.send(&command.frame(node(id)));
            }
        }
        for counter in 1..=200 {
            let _ = link.send(&wire::sync_frame(counter));
            let _ = link.send(&wire::master_heartbeat_frame());
            let deadline = clock.now() + PERIOD;
            heard += drain(&mut link, deadline);
        }
        link.inject(Joint::ONE, DriveFault::OverTemperature);
        let silence = clock.now() + Duration::from_secs(1);
        heard += drain(&mut link, silence);
        clock.sleep_until(silence);
        heard
    });
    assert!(heard > 600, "{heard}");
}
