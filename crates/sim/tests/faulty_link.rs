//! The unreliable link: reliable at rate zero, the same faults for the same seed, and every fault of its own kind.

mod support;

use std::time::Duration;
use support::{Master, lockstep, robot};
use uarm_io::frame::Frame;
use uarm_io::link::{FrameDirection, Link, ObservedLink};
use uarm_io::time::Instant;
use uarm_sim::{DemPlant, EmulatedRobot, FaultRates, FaultyLink, InProcessLink, VirtualClock};

type Faulty = FaultyLink<InProcessLink<EmulatedRobot<DemPlant>, VirtualClock>, VirtualClock>;

fn faulty(rates: FaultRates, seed: u64) -> Master<Faulty> {
    let clock = VirtualClock::new();
    let reliable = FaultRates::default();
    let inner = InProcessLink::new(robot(lockstep()), clock.clone());
    let mut master = Master::on(FaultyLink::new(inner, clock.clone(), reliable, seed).unwrap(), clock);
    master.enable();
    master.received();
    master.link.set_rates(rates).unwrap();
    master
}

/// What the master hears over 100 cycles.
fn heard(master: &mut Master<Faulty>) -> Vec<(Frame, Instant)> {
    let mut heard = Vec::new();
    for _ in 0..100 {
        master.send(uarm_io::drive::wire::sync_frame(1));
        heard.extend(master.listen(support::PERIOD));
        master.heartbeat();
    }
    heard
}

#[test]
fn at_rate_zero_it_is_the_link_inside() {
    let clock = VirtualClock::new();
    let mut plain = Master::on(InProcessLink::new(robot(lockstep()), clock.clone()), clock);
    plain.enable();
    plain.received();
    let mut expected = Vec::new();
    for _ in 0..100 {
        plain.send(uarm_io::drive::wire::sync_frame(1));
        expected.extend(plain.listen(support::PERIOD));
        plain.heartbeat();
    }
    assert_eq!(heard(&mut faulty(FaultRates::default(), 1)), expected);
    assert_eq!(expected.len(), 300);
}

#[test]
fn the_seed_decides() {
    let rates = FaultRates {
        loss: 0.05,
        duplication: 0.05,
        corruption: 0.05,
        delay: 0.2,
        longest_delay: Duration::from_millis(2),
    };
    let once = heard(&mut faulty(rates, 42));
    assert_eq!(once, heard(&mut faulty(rates, 42)));
    assert_ne!(once, heard(&mut faulty(rates, 43)));
}

#[test]
fn loss_loses() {
    let mut master = faulty(FaultRates { loss: 1.0, ..FaultRates::default() }, 7);
    assert_eq!(heard(&mut master), []);
    // 100 SYNCs and heartbeats did not reach the drives, which then have fallen into fault: one emergency each.
    assert_eq!(master.link.counts().lost, 200 + 3);
    assert_eq!(master.link.inner().robot().brakes(), [uarm_sim::Brake::Engaged; 3]);
}

#[test]
fn duplicates_come_twice() {
    let mut master = faulty(FaultRates { duplication: 1.0, ..FaultRates::default() }, 7);
    master.send(uarm_io::drive::wire::sync_frame(1));
    let heard = master.listen(Duration::from_millis(1));
    // Two SYNCs, three drives, each answer twice.
    assert_eq!(heard.len(), 12);
    assert_eq!(master.link.counts().duplicated, 1 + 6);
}

#[test]
fn corruption_flips_one_bit() {
    let mut right = faulty(FaultRates::default(), 7);
    let mut wrong = faulty(FaultRates { corruption: 1.0, ..FaultRates::default() }, 7);
    let feedback = |master: &mut Master<Faulty>| {
        master.send(uarm_io::drive::wire::sync_frame(1));
        master.listen(Duration::from_millis(1))
    };
    let (right, wrong) = (feedback(&mut right), feedback(&mut wrong));
    assert_eq!(right.len(), 3);
    for ((right, _), (wrong, _)) in right.iter().zip(&wrong) {
        assert_eq!(right.id(), wrong.id());
        let bits = right.data().iter().zip(wrong.data()).map(|(one, other)| (one ^ other).count_ones());
        assert_eq!(bits.sum::<u32>(), 1);
    }
}

#[test]
fn delayed_frames_come_late_and_out_of_order() {
    let rates = FaultRates { delay: 0.5, longest_delay: Duration::from_millis(2), ..FaultRates::default() };
    let mut master = faulty(rates, 7);
    let heard = heard(&mut master);
    assert!(heard.len() >= 297, "nothing is lost; the last may still be on their way: {}", heard.len());
    assert!(heard.is_sorted_by_key(|(_, at)| *at), "time does not run backwards");
    let ids: Vec<_> = heard.iter().map(|(frame, _)| frame.id().as_raw()).collect();
    assert!(ids.chunks(3).any(|chunk| !chunk.is_sorted()), "some overtake others");
    assert!(master.link.counts().delayed > 100);
}

#[test]
fn rates_are_probabilities() {
    let clock = VirtualClock::new();
    let inner = InProcessLink::new(robot(lockstep()), clock.clone());
    let rates = FaultRates { corruption: 1.5, ..FaultRates::default() };
    let error = FaultyLink::new(inner, clock, rates, 0).unwrap_err();
    assert_eq!(error.to_string(), "the probability of corruption is 1.5, expected 0 to 1");
}

#[test]
fn an_observer_sees_both_directions() {
    let clock = VirtualClock::new();
    let mut seen = Vec::new();
    let inner = InProcessLink::new(robot(lockstep()), clock.clone());
    let observer = |direction, frame: &Frame, _| seen.push((direction, frame.id().as_raw()));
    let mut link = ObservedLink::new(inner, observer);
    while link.receive(Instant::default()).unwrap().is_some() {}
    link.send(&uarm_io::drive::wire::sync_frame(1)).unwrap();
    let boot_ups = [0x701, 0x702, 0x703].map(|id| (FrameDirection::Received, id));
    assert_eq!(seen[..3], boot_ups);
    assert_eq!(seen[3..], [(FrameDirection::Sent, 0x80)]);
}
