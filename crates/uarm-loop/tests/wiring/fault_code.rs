//! Which faults come again in a replay.

use uarm_loop::choice::Choice;
use uarm_loop::fault_code::FaultCode;

#[test]
fn what_the_signals_cause_comes_again_and_what_drives_and_bus_do_does_not() {
    for name in [
        "start-position",
        "feedback-missing",
        "encoder-implausible",
        "joint-angle",
        "joint-velocity",
        "tracking-error",
        "torque-invalid",
        "not-finite",
        "torque-saturated",
        "encoder-stuck",
        "torque-reversed",
        "model-contradicted",
    ] {
        assert!(FaultCode::from_name(name).unwrap().is_of_signals(), "{name}");
    }
    for name in [
        "other-master",
        "drive-rebooted",
        "two-drives-one-node",
        "drive-not-enabled",
        "target-ignored",
        "drive-emergency",
        "drive-silent",
        "drive-not-operational",
        "supply-voltage",
        "temperature",
        "reading-missing",
        "overrun",
        "stop-unconfirmed",
    ] {
        assert!(!FaultCode::from_name(name).unwrap().is_of_signals(), "{name}");
    }
}
