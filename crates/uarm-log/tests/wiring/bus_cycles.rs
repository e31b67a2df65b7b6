//! Which frame of a cycle counts.

use uarm_log::replay::bus_cycles::bus_cycles;
use uarm_log::uarm_loop::recording::FrameRecord;
use uarm_log::uarm_loop::uarm_io::embedded_can::StandardId;
use uarm_log::uarm_loop::uarm_io::frame::Frame;
use uarm_log::uarm_loop::uarm_io::link::FrameDirection;
use uarm_log::uarm_loop::uarm_io::time::Instant;

fn frames(frames: &[(u16, &[u8])]) -> Vec<FrameRecord> {
    let record = |(sequence, (id, data)): (u32, &(u16, &[u8]))| FrameRecord {
        sequence,
        direction: FrameDirection::Sent,
        frame: Frame::new(StandardId::new(*id).unwrap(), data).unwrap(),
        at: Instant::from_nanoseconds(u64::from(sequence)),
    };
    (0..).zip(frames).map(record).collect()
}

#[test]
fn the_first_torque_of_a_cycle_counts() {
    let frames = frames(&[
        (0x080, &[1]),
        (0x202, &[0x0F, 0x00, 5, 0]),
        (0x202, &[0x0F, 0x00, 9, 0]),
        (0x203, &[0x02, 0x00, 7, 0]), // quick stop: no torque of the loop
        (0x203, &[0x0F, 0x00, 8, 0]),
    ]);
    let cycles = bus_cycles(&frames, [1, 2, 3]);
    assert_eq!(cycles[0].sent, [None, Some(5), Some(8)]);
    assert_eq!(cycles[0].all_sent(), None, "joint 1 was sent nothing");
}

#[test]
fn drives_are_joints_in_the_order_of_their_nodes() {
    let frames = frames(&[
        (0x080, &[1]),
        (0x187, &[0x27, 0x00, 1, 0, 0, 0]),
        (0x185, &[0x28, 0x00, 2, 0, 0, 0]),
        (0x189, &[0x29, 0x00, 3, 0, 0, 0]), // node 9 is none of the robot's
        (0x186, &[0x2A, 0x00, 4, 0, 0, 0]),
    ]);
    let cycles = bus_cycles(&frames, [5, 6, 7]);
    assert_eq!((cycles[0].all_counts(), cycles[0].statuswords), (Some([2, 4, 1]), [0x28, 0x2A, 0x27]));
}
