"""Topics that tell of one cycle agree with each other, number for number."""

from log_file import LogFile

# A latency is a difference of nanoseconds, told in microseconds as a double.
MICROSECOND_NS = 1000
ROUNDING_US = 1e-6


def check(log: LogFile) -> str:
    topics = ("/control", "/joint_states", "/timing", "/drives")
    cycles = list(zip(*map(log.cycles, topics), strict=True))
    previous = None
    for control, joints, timing, drives in cycles:
        tick = control.body.tick
        assert tick == timing.body.tick == drives.body.tick, f"cycle {tick}: other ticks beside it"
        assert previous is None or tick - previous == timing.body.elapsed_ticks, f"cycle {tick} follows {previous}"
        previous = tick
        for message in (control, joints, timing, drives):
            times = message.log_time, message.publish_time
            assert times == (timing.body.scheduled_ns, timing.body.sync_sent_ns), f"cycle {tick}: times {times}"
        check_joints(control.body, joints.body)
        check_timing(timing.body)
    check_fault(log, previous)
    return f"{len(cycles)} cycles: /joint_states is /control, latencies are differences of their instants"


def check_joints(control, joints) -> None:
    found = [(joint.position, joint.velocity, joint.effort) for joint in joints.joints]
    expected = list(zip(control.position, control.velocity, [0.0, *control.torque_applied], strict=True))
    assert found == expected, f"cycle {control.tick}: joint states {found}, control {expected}"
    errors = [q - r for q, r in zip(control.position[1:], control.reference_position, strict=True)]
    assert errors == list(control.tracking_error), f"cycle {control.tick}: tracking error {control.tracking_error}"


def check_timing(timing) -> None:
    names = ("scheduled_ns", "woke_ns", "sync_sent_ns", "counts_in_ns", "torque_out_ns", "done_ns")
    instants = [getattr(timing, name) for name in names]
    assert instants == sorted(instants), f"cycle {timing.tick}: instants {instants}"
    for told, start, end in (
        (timing.wake_up_us, timing.scheduled_ns, timing.woke_ns),
        (timing.feedback_latency_us, timing.sync_sent_ns, timing.counts_in_ns),
        (timing.total_us, timing.scheduled_ns, timing.torque_out_ns),
    ):
        assert abs(told - (end - start) / MICROSECOND_NS) <= ROUNDING_US, f"cycle {timing.tick}: {told} us"


def check_fault(log: LogFile, last_tick: int) -> None:
    told = log.metadata["uarm.end"]["fault"]
    faults = [message.body for message in log.messages["/fault"]] if told else []
    assert [fault.cause for fault in faults] == [told] * bool(told), f"faults {faults}, at the end `{told}`"
    assert all(fault.last_tick == last_tick for fault in faults), f"{faults}, last cycle {last_tick}"
