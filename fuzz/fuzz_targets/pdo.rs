//! Every payload of the bus is decoded without a panic, and what is decoded is encoded to the same bytes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use uarm_io::drive::odrive::turns;
use uarm_io::drive::odrive::wire as odrive;
use uarm_io::drive::wire::{self, DriveCommand, DriveFeedback, NodeId};
use uarm_io::encoder::CountsPerRevolution;

fuzz_target!(|data: &[u8]| {
    if let Ok(node) = NodeId::new(1) {
        if let Ok(feedback) = DriveFeedback::decode(data) {
            assert_eq!(feedback.frame(node).data(), data);
        }
        if let Ok(command) = DriveCommand::decode(data) {
            assert_eq!(command.frame(node).data(), data);
        }
    }
    let _ = (wire::decode_sync(data), wire::decode_nmt(data), wire::decode_heartbeat(data));
    let _ = (wire::decode_emergency(data), wire::decode_sdo(data));
    let _ = (odrive::Heartbeat::decode(data), odrive::decode_torque(data), odrive::decode_state(data));
    let _ = odrive::ControllerMode::decode(data);
    if let (Ok(estimates), Ok(resolution)) = (odrive::EncoderEstimates::decode(data), CountsPerRevolution::new(8_192)) {
        let _ = turns::counts(estimates.position, resolution);
    }
});
