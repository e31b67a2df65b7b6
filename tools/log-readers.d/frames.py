"""What cantools decodes from the frames, with the DBC that is attached to the log, is what the typed topics say."""

import cantools
from log_file import LogFile

SYNC = "SYNC"


def check(log: LogFile) -> str:
    database = cantools.database.load_string(log.attachments["uarm.dbc"].data.decode(), "dbc")
    frames = sorted(log.messages["/can/frames"], key=lambda message: message.sequence)
    sequences = [message.sequence for message in frames]
    assert sequences == list(range(len(frames))), "frames are missing, or there twice"
    drives = log.cycles("/drives")
    by_cycle = split(database, frames)
    # The cycle in which a run fails has a SYNC, but comes to no record.
    failed = 1 if log.metadata["uarm.end"]["fault"] else 0
    assert len(by_cycle) == len(drives) + failed, f"{len(by_cycle)} SYNCs, {len(drives)} cycles"
    for said, states in zip(by_cycle[: len(drives)], drives, strict=True):
        for number, drive in enumerate(states.body.drives, 1):
            feedback, command = said[f"Joint{number}_Feedback"], said[f"Joint{number}_Command"]
            decoded = feedback["Statusword"], feedback["Position"], command["TargetTorque"]
            typed = drive.statusword, drive.counts, drive.torque_sent
            assert decoded == typed, f"cycle {states.body.tick}, drive {number}: frames {decoded}, /drives {typed}"
    decoded = sum(frame.body.id in identifiers(database) for frame in frames)
    return f"{len(frames)} frames, {decoded} decoded by cantools: {len(drives)} cycles are those of /drives"


def identifiers(database) -> set:
    return {message.frame_id for message in database.messages}


def split(database, frames) -> list:
    """From each SYNC to the next: the first message of each name. What follows the last cycle's is the stop."""
    known, cycles = identifiers(database), []
    for frame in frames:
        if frame.body.id not in known:  # SDO, which a DBC cannot describe
            continue
        name = database.get_message_by_frame_id(frame.body.id).name
        values = database.decode_message(frame.body.id, frame.body.data, decode_choices=False)
        if name == SYNC:
            cycles.append({})
        elif cycles:
            cycles[-1].setdefault(name, values)
    return cycles
