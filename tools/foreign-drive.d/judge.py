"""What must be so after a trial. Objects and values are those of CiA 301 and CiA 402, and of the robot file; none is uarm's."""

import json
import math

from drive import CONTROLWORD
from power import Power
from trial import END_DEG, FAILURE, NODES, OK, PLAIN

REACHED_DEG = 1.0
ORDER = [Power.SWITCH_ON_DISABLED, Power.READY_TO_SWITCH_ON, Power.SWITCHED_ON, Power.OPERATION_ENABLED]
PDO_PARAMETERS = (*range(0x1400, 0x1600), *range(0x1800, 0x1A00))
IDENTIFIER_AND_OFF = 0x800007FF  # bit 30 of a PDO's identifier is the drive's own
OFF = 0x80000000
PDOS = range(0x181, 0x580)  # identifiers that the predefined connection set gives to PDOs
MASTER, MASTER_TIMEOUT_MS, DRIVE_HEARTBEAT_MS = 127, 200, 50


def configured(node, trial):
    """What a drive must hold in the end, as far as it has the objects. PDO1 in each direction is used, PDO2 is off."""
    # 10 ms are there from the start, as (1, -2).
    value, exponent = (1, -2) if trial.period == 0.01 else (round(trial.period * 1e3), -3)
    return {
        (0x1005, 0): 0x80,
        (0x1014, 0): 0x80 + node,
        (0x1016, 1): MASTER << 16 | MASTER_TIMEOUT_MS,
        (0x1017, 0): DRIVE_HEARTBEAT_MS,
        (0x1019, 0): 240 if trial.sync_length else 0,
        (0x1400, 1): 0x200 + node,
        (0x1400, 2): 255,
        (0x1401, 1): OFF | 0x300 + node,
        (0x1600, 0): 2,
        (0x1600, 1): 0x60400010,
        (0x1600, 2): 0x60710010,
        (0x1800, 1): 0x180 + node,
        (0x1800, 2): 1,
        (0x1801, 1): OFF | 0x280 + node,
        (0x1A00, 0): 2,
        (0x1A00, 1): 0x60410010,
        (0x1A00, 2): 0x60640020,
        (0x6007, 0): 1,
        (0x6060, 0): 10,
        (0x607E, 0): 0,
        (0x6091, 1): 1,
        (0x60C2, 1): value,
        (0x60C2, 2): exponent,
    }


def judge(trial, outcome):
    """What is wrong."""
    for node, (code, said) in outcome.checks.items():
        yield from (f"node {node}, check: {what}" for what in judge_check(trial.trait(node), code, said))
    for drive in outcome.drives:
        yield from (f"node {drive.id} {what}" for what in judge_drive(trial, drive, outcome.torque))
    if outcome.code != trial.exit:
        yield f"exit code {outcome.code}, expected {trial.exit}"
    yield from (f"'{text}' is not in the output" for text in trial.text if text not in outcome.output)


def judge_check(trait, code, said):
    if code != trait.code:
        yield f"exit code {code}, expected {trait.code}"
    try:
        rows = json.loads(said)["rows"]
    except ValueError:
        yield f"no JSON: {said}"
        return
    found = {row["object"].split(" ")[0]: "; ".join(row["remedies"]) for row in rows if row["verdict"] in ("no", "set")}
    if found.keys() != trait.rows.keys():
        yield f"what is wrong stands in {found}, expected {trait.rows}"
    yield from (
        f"{name} has the remedy '{found[name]}', expected '{text}'"
        for name, text in trait.rows.items()
        if text not in found.get(name, text)
    )


def judge_drive(trial, drive, torque):
    seen, trait = drive.seen, trial.trait(drive.id)
    highest = max((ORDER.index(state) for state in seen.states if state in ORDER), default=0)
    yield from seen.errors
    if drive.brake_open:
        yield "its brake is open at the end"
    if drive.torque() != 0:
        yield f"its torque is {drive.torque()} per mille at the end"
    if highest > ORDER.index(trial.power):
        yield f"reached {ORDER[highest].name}"
    if seen.syncs and trial.exit == FAILURE:
        yield f"{seen.syncs} SYNCs, expected none"
    if trait.must_send and not (trait.must_send in seen.emergencies and seen.sent[0x80 + drive.id]):
        yield f"did not send emergency {trait.must_send:04X}h"
    if trial.check or trial.untouched:
        if seen.writes or seen.boots != 1:
            yield f"got {len(seen.writes)} writes and {seen.boots - 1} resets, expected to be read only"
    elif trial.exit == OK:
        yield from judge_run(trial, drive, trait)
        yield from judge_objects(drive, configured(drive.id, trial) | trait.holds)
        if trial.reports_torque:
            yield from judge_torque(trait, seen, torque.get(drive.id))


def judge_run(trial, drive, trait):
    seen, cycles = drive.seen, trial.cycles()
    index = NODES.index(drive.id)
    if seen.boots != 2:
        yield f"booted {seen.boots} times, expected at power-up and after the reset"
    if seen.brake_openings != trait.brake_openings:
        yield f"its brake opened {seen.brake_openings} times"
    if seen.syncs < cycles or seen.rpdos < seen.syncs:
        yield f"{seen.syncs} SYNCs, {seen.rpdos} RPDOs, expected {cycles}"
    if seen.sync_lengths != {trial.sync_length}:
        yield f"SYNCs of {seen.sync_lengths} bytes, expected {trial.sync_length}"
    expected = {0x180 + drive.id} if trait.sends is None else set(trait.sends)
    sent = {identifier: count for identifier, count in seen.sent.items() if identifier in PDOS}
    if sent.keys() != expected or min(sent.values()) < cycles:
        yield f"sent PDOs {sent}, expected {expected}, {cycles} of each"
    if seen.unguarded_syncs:
        yield f"no watchdog was armed at {seen.unguarded_syncs} SYNCs"
    if seen.idle_writes:
        yield f"written though they read so already: {names(seen.idle_writes)}"
    late = [
        (index, subindex)
        for index, subindex, state in seen.writes
        if state not in (Power.SWITCH_ON_DISABLED, Power.FAULT) and index != CONTROLWORD
    ]
    if late:
        yield f"written with power on: {names(late)}"
    written = [(index, subindex) for index, subindex, _ in seen.writes if index != CONTROLWORD]
    if trait.last_write and written[-1] != trait.last_write:
        yield f"written last: {names(written[-1:])}, expected {names([trait.last_write])}"
    if set(seen.emergencies) - set(trait.emergencies):
        yield f"sent emergencies {', '.join(f'{code:04X}h' for code in seen.emergencies)}"
    if (seen.largest_torque > 0) != (drive.id != NODES[0]):
        yield f"largest torque {seen.largest_torque} per mille"
    reached = math.degrees(drive.joint.angle)
    if abs(reached - END_DEG[index]) > REACHED_DEG:
        yield f"reached {reached:.2f} degrees, expected {END_DEG[index]}"


def judge_objects(drive, expected):
    for (index, subindex), value in expected.items():
        if not drive.objects.has(index, subindex):
            continue
        found = drive.objects.stored(index, subindex)
        mask = IDENTIFIER_AND_OFF if index in PDO_PARAMETERS and subindex == 1 else -1
        if found & mask != value & mask:
            yield f"{index:04X}h:{subindex:02X} is {found} ({found:X}h), expected {value} ({value:X}h)"


def judge_torque(trait, seen, logged):
    """A torque acts on reception and is reported with the SYNC after; the log may have it one cycle later."""
    if trait is PLAIN:
        if logged:
            yield "has a torque in the log, and none was asked for"
        return
    sent, reported = logged or ([], [])
    if not any(sent and reported[late:] == sent[:-late] and set(reported[:late]) <= {"", "0"} for late in (1, 2)):
        yield f"the log has the torques {reported}, expected those that were sent, one or two cycles later: {sent}"
    largest = max((abs(int(torque)) for torque in reported if torque), default=0)
    if largest != seen.largest_torque:
        yield f"the largest torque in the log is {largest}, expected {seen.largest_torque} per mille"


def names(objects):
    return ", ".join(f"{index:04X}h:{subindex:02X}" for index, subindex in objects)
