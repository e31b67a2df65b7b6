//! Frames, cut at each SYNC into cycles: the counts that came, and the torques that went.

use uarm_loop::uarm_io::drive::cia402::{Command, Controlword};
use uarm_loop::uarm_io::drive::wire::{Channel, DriveCommand, DriveFeedback};
use uarm_loop::uarm_io::time::Instant;

use uarm_loop::recording::FrameRecord;

/// What was on the bus of `J` drives from one SYNC to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusCycle<const J: usize> {
    /// When SYNC was sent.
    pub sync_at: Instant,
    /// The number that SYNC had, where it has one.
    pub counter: Option<u8>,
    /// The encoder counts that each drive sent after it.
    pub counts: [Option<i32>; J],
    /// The statusword that each drive sent with them.
    pub statuswords: [u16; J],
    /// The torque that each drive was sent, per mille.
    pub sent: [Option<i16>; J],
    /// Whether a drive was sent a command of any kind: what comes after it is too late for this cycle.
    pub commanded: bool,
    /// Whether a drive was sent another command than a torque, or an NMT command: the loop is over, and the drives are stopped.
    pub stopped: bool,
    /// Whether frames are missing in or before this cycle.
    pub continuity: Continuity,
}

/// Whether all frames are there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Continuity {
    /// All frames since the previous cycle are there.
    Whole,
    /// Some frames are missing in it or before it.
    Broken,
}

impl<const J: usize> BusCycle<J> {
    fn new(sync: &FrameRecord) -> Self {
        Self {
            sync_at: sync.at,
            counter: sync.frame.data().first().copied(),
            counts: [None; J],
            statuswords: [0; J],
            sent: [None; J],
            commanded: false,
            stopped: false,
            continuity: Continuity::Whole,
        }
    }

    /// The counts of all drives, if all answered.
    pub fn all_counts(&self) -> Option<[i32; J]> {
        all(&self.counts)
    }

    /// The torques to all drives, if all were sent.
    pub fn all_sent(&self) -> Option<[i16; J]> {
        all(&self.sent)
    }

    /// As the master takes feedback in: until its first command, and none that came before the SYNC.
    fn take(&mut self, record: &FrameRecord, nodes: [u8; J]) {
        let joint = |node: u8| nodes.iter().position(|each| *each == node);
        match Channel::of(record.frame.id()) {
            Some(Channel::Tpdo1(node)) if !self.commanded && record.at >= self.sync_at => {
                if let (Some(joint), Ok(feedback)) = (joint(node.raw()), DriveFeedback::decode(record.frame.data())) {
                    self.counts[joint] = Some(feedback.position);
                    self.statuswords[joint] = feedback.statusword.bits();
                }
            }
            Some(Channel::Rpdo1(node)) => {
                self.commanded = true;
                if let (Some(joint), Ok(command)) = (joint(node.raw()), DriveCommand::decode(record.frame.data())) {
                    let is_torque = command.controlword == Controlword::of(Command::EnableOperation);
                    self.stopped |= !is_torque;
                    if is_torque && self.sent[joint].is_none() {
                        self.sent[joint] = Some(command.target_torque);
                    }
                }
            }
            Some(Channel::NmtCommand) => self.stopped = true,
            _ => {}
        }
    }
}

/// Cuts `frames`, in the order in which the master sent and received them, into cycles; `nodes` are the drives, joint 1
/// first.
pub fn bus_cycles<const J: usize>(frames: &[FrameRecord], nodes: [u8; J]) -> Vec<BusCycle<J>> {
    let syncs = frames.iter().filter(|record| Channel::of(record.frame.id()) == Some(Channel::Sync));
    // The counter begins again behind its largest number.
    let largest = syncs.filter_map(|sync| sync.frame.data().first().copied()).max().unwrap_or_default();
    let mut cutter = BusCutter::new(nodes, largest);
    let mut cycles: Vec<_> = frames.iter().filter_map(|record| cutter.take(record)).collect();
    cycles.extend(cutter.finish());
    cycles
}

/// Cuts frames that come one by one into cycles.
#[derive(Clone, Debug)]
pub struct BusCutter<const J: usize> {
    nodes: [u8; J],
    /// The largest number that a SYNC has; 1 follows.
    largest: u8,
    expected: Option<u32>,
    is_broken: bool,
    cycle: Option<BusCycle<J>>,
}

impl<const J: usize> BusCutter<J> {
    /// For drives of these `nodes`, joint 1 first, where the counter of SYNC begins again behind `largest`.
    pub const fn new(nodes: [u8; J], largest: u8) -> Self {
        Self { nodes, largest, expected: None, is_broken: false, cycle: None }
    }

    /// Takes the next frame, and gives the cycle that it ends.
    pub fn take(&mut self, record: &FrameRecord) -> Option<BusCycle<J>> {
        self.is_broken |= self.expected.is_some_and(|expected| expected != record.sequence);
        self.expected = Some(record.sequence.wrapping_add(1));
        let mut ended = None;
        if Channel::of(record.frame.id()) == Some(Channel::Sync) {
            let cycle = BusCycle::new(record);
            ended = self.cycle.replace(cycle);
            let numbers = ended.as_ref().and_then(|previous| previous.counter).zip(cycle.counter);
            self.is_broken |= numbers
                .is_some_and(|(previous, counter)| counter != if previous >= self.largest { 1 } else { previous + 1 });
        }
        if let Some(cycle) = &mut self.cycle {
            cycle.take(record, self.nodes);
            if std::mem::take(&mut self.is_broken) {
                cycle.continuity = Continuity::Broken;
            }
        }
        ended
    }

    /// The last cycle.
    pub const fn finish(self) -> Option<BusCycle<J>> {
        self.cycle
    }
}

/// The values, if all are there.
fn all<V: Copy + Default, const J: usize>(values: &[Option<V>; J]) -> Option<[V; J]> {
    let mut all = [V::default(); J];
    for (to, from) in all.iter_mut().zip(values) {
        *to = (*from)?;
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_can::StandardId;
    use uarm_loop::uarm_io::frame::Frame;
    use uarm_loop::uarm_io::link::FrameDirection;

    fn frame(sequence: u32, at: u64, id: u16, data: &[u8]) -> FrameRecord {
        let frame = Frame::new(StandardId::new(id).unwrap(), data).unwrap();
        FrameRecord { sequence, direction: FrameDirection::Sent, frame, at: Instant::from_nanoseconds(at) }
    }

    #[test]
    fn a_cycle_is_what_lies_between_two_syncs() {
        let frames = [
            frame(0, 1, 0x000, &[0x01, 0x00]),
            frame(1, 5, 0x080, &[1]),
            frame(2, 4, 0x181, &[0x37, 0x12, 9, 0, 0, 0]), // before the SYNC: stale
            frame(3, 6, 0x181, &[0x37, 0x12, 1, 0, 0, 0]),
            frame(4, 7, 0x182, &[0x37, 0x12, 0xFE, 0xFF, 0xFF, 0xFF]),
            frame(5, 8, 0x183, &[0x37, 0x12, 3, 0, 0, 0]),
            frame(6, 9, 0x201, &[0x0F, 0x00, 0, 0]),
            frame(7, 9, 0x202, &[0x0F, 0x00, 0xF6, 0xFF]),
            frame(8, 9, 0x203, &[0x0F, 0x00, 7, 0]),
            frame(9, 10, 0x182, &[0x37, 0x12, 99, 0, 0, 0]), // too late for this cycle
            frame(10, 11, 0x202, &[0x02, 0x00, 0, 0]),       // quick stop: no torque of the loop
            frame(12, 15, 0x080, &[2]),
        ];
        let cycles = bus_cycles(&frames, [1, 2, 3]);
        let [first, second] = cycles.as_slice() else { panic!("{cycles:?}") };
        assert_eq!(first.all_counts(), Some([1, -2, 3]));
        assert_eq!(first.all_sent(), Some([0, -10, 7]));
        assert_eq!(first.continuity, Continuity::Whole);
        assert_eq!((first.stopped, second.stopped), (true, false));
        assert_eq!((second.all_counts(), second.continuity), (None, Continuity::Broken), "frame 11 is missing");
        assert_eq!((first.counter, second.counter), (Some(1), Some(2)));
    }

    #[test]
    fn a_sync_that_is_missing_breaks_the_cycles() {
        let syncs = |counters: &[u8]| -> Vec<Continuity> {
            let frames: Vec<_> =
                counters.iter().zip(0..).map(|(counter, at)| frame(at, at.into(), 0x080, &[*counter])).collect();
            bus_cycles(&frames, [1, 2, 3]).iter().map(|cycle| cycle.continuity).collect()
        };
        use Continuity::{Broken, Whole};
        assert_eq!(syncs(&[1, 2, 4, 5]), [Whole, Whole, Broken, Whole]);
        assert_eq!(syncs(&[239, 240, 1, 2]), [Whole; 4]);
        assert_eq!(syncs(&[9, 10, 2]), [Whole, Whole, Broken]);
    }
}
