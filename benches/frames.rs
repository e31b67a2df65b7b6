//! One loop cycle's frames, encoded for SocketCAN and decoded from it, without the socket: SYNC out, the feedback of
//! three drives in, three torques out, and the busiest housekeeping, in which every heartbeat falls too.

use criterion::{Criterion, criterion_group, criterion_main};
use socketcan::{CanFrame, EmbeddedFrame};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::hint::black_box;
use std::time::Duration;
use uarm_io::drive::cia402::{PowerState, Statusword};
use uarm_io::drive::network::{DriveConfiguration, DriveNetwork, NetworkConfiguration};
use uarm_io::drive::wire::{self, Channel, DriveFeedback};
use uarm_io::drive::{NmtState, NodeId};
use uarm_io::frame::Frame;
use uarm_io::link::{Link, Received};
use uarm_io::time::Instant;
use uarm_io::torque::RatedTorque;

/// A link whose other end answers each SYNC at once, in the kernel's frame format both ways.
struct KernelFrames {
    answers: Vec<CanFrame>,
    waiting: VecDeque<CanFrame>,
    now: Instant,
}

impl KernelFrames {
    fn new(nodes: &[NodeId]) -> Self {
        let feedback = DriveFeedback { statusword: Statusword::of(PowerState::OperationEnabled), position: 12_345 };
        let answers = nodes
            .iter()
            .flat_map(|node| [feedback.frame(*node), wire::heartbeat_frame(*node, NmtState::Operational)])
            .map(|frame| to_kernel(&frame))
            .collect();
        Self { answers, waiting: VecDeque::with_capacity(16), now: Instant::default() }
    }
}

fn to_kernel(frame: &Frame) -> CanFrame {
    CanFrame::new(frame.id(), frame.data()).expect("at most eight bytes")
}

fn from_kernel(frame: &CanFrame) -> Option<Frame> {
    <Frame as EmbeddedFrame>::new(EmbeddedFrame::id(frame), EmbeddedFrame::data(frame))
}

impl Link for KernelFrames {
    type Error = Infallible;

    fn send(&mut self, frame: &Frame) -> Result<Instant, Infallible> {
        let encoded = black_box(to_kernel(frame));
        if from_kernel(&encoded).and_then(|frame| Channel::of(frame.id())) == Some(Channel::Sync) {
            self.now = self.now + Duration::from_millis(3);
            self.waiting.extend(&self.answers);
        }
        Ok(self.now)
    }

    fn receive(&mut self, _deadline: Instant) -> Result<Option<Received>, Infallible> {
        let frame = self.waiting.pop_front().and_then(|encoded| from_kernel(&black_box(encoded)));
        Ok(frame.map(|frame| Received { frame, at: self.now }))
    }
}

fn network() -> DriveNetwork<KernelFrames, 3> {
    let nodes = [1, 2, 3].map(|node| NodeId::new(node).expect("a node"));
    let rated_torque = RatedTorque::from_millinewton_metres(200).expect("a torque");
    let drives = nodes.map(|node| DriveConfiguration::new(node, 8000, rated_torque));
    let configuration = NetworkConfiguration::new(drives, Duration::from_millis(3)).expect("a network");
    DriveNetwork::new(KernelFrames::new(&nodes), configuration)
}

fn one_cycle(network: &mut DriveNetwork<KernelFrames, 3>) -> [Option<i32>; 3] {
    let sync_at = network.sync().expect("sent");
    let feedback = network.collect(sync_at + Duration::from_millis(1)).expect("all drives answer");
    network.send_torques(black_box([0, 71, -35])).expect("sent");
    network.housekeeping(sync_at).expect("all drives are well");
    feedback.positions
}

fn frames(criterion: &mut Criterion) {
    let mut network = network();
    criterion.bench_function("one cycle of frames", |bencher| bencher.iter(|| one_cycle(&mut network)));

    let feedback = DriveFeedback { statusword: Statusword::of(PowerState::OperationEnabled), position: -12_345 };
    let payload = feedback.encode();
    criterion.bench_function("decode one feedback", |bencher| {
        bencher.iter(|| DriveFeedback::decode(black_box(&payload)));
    });
}

criterion_group!(benches, frames);
criterion_main!(benches);
