"""Starts three foreign drives, lets `uarm run` drive them, and judges both, once for each trait.

Usage: traits.py [TRAIT...]; the environment variable UARM names the program. Each trait prints one line; the last line counts them.
"""

import dataclasses
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import typing

from bus import Bus
from dictionary import merged
from drive import ERROR_RESET, HEARTBEAT_LOST, RPDO_TIMEOUT, Drive, Joint
from power import Power

HERE = pathlib.Path(__file__).parent
ROBOT = HERE.parent.parent / "robots" / "uarm.toml"
INTERFACE = "vcan0"
PATIENCE = 600.0  # seconds; a run takes two, but the time of a guest leaps while it waits for a file
PERIOD = 0.01  # seconds; Python in an emulated machine wants some
NODES = (1, 2, 3)
START_DEG = (0.0, 20.0, 20.0)
END_DEG = (0.0, 30.0, 30.0)
REACHED_DEG = 1.0
CYCLES = 80  # of the task and its hold
OK, FAILURE, KILLED = 0, 1, -9
CONTROLWORD = 0x6040
AFTERWARDS = 0.3  # seconds; longer than any drive bears to hear nothing
ABORT_IS_FAULT = '{ index = 0x6007, subindex = 0, type = "i16", value = 1 }'


@dataclasses.dataclass(frozen=True)
class Trait:
    """What node 2 has of its own, and what must come of it."""

    name: str
    text: tuple = ()  # in what uarm prints
    exit: int = OK
    power: Power = Power.OPERATION_ENABLED  # the furthest state that any drive may reach
    dictionary: str = ""  # what overrides the dictionary that works with everything
    writes: tuple = (ABORT_IS_FAULT,)
    encoder: str = "counts_per_revolution = 16384"
    drive: str = "rated_torque_nm = 0.2"
    joint: str = ""
    gear: float = 1.0
    torque_unit: float = 1e-3  # of 6076h, N m
    brake_openings: int = 1
    emergencies: tuple = (HEARTBEAT_LOST,)  # those that it may send: the master's heartbeat ends before the drive does
    must_send: int | None = None  # an emergency that it must send
    event: typing.Callable = lambda bus, drives, uarm: None  # what happens beside the run


WATCHES_RPDO = 'rated_torque_nm = 0.2, watchdog = "rpdo-timeout", rpdo_timeout_ms = 100'


def refused(name, *text, power=Power.SWITCH_ON_DISABLED, dictionary=None, **others):
    """A trait with which nothing may start; as a rule before any power."""
    dictionary = name if dictionary is None else dictionary
    return Trait(name, text, FAILURE, power, dictionary=dictionary, **others)


def works(name, dictionary=None, **others):
    return Trait(name, dictionary=name if dictionary is None else dictionary, **others)


def reboots(_bus, drives, _uarm):
    """Node 2 loses its supply for a moment while node 3 is being set up."""

    def reboot():
        drives[2].on_write = lambda: None
        drives[1].reboot()

    drives[2].on_write = reboot


def is_enabled(_bus, drives, _uarm):
    """A master that was killed left node 2 enabled."""
    drives[1].enable()


def is_left_alone(_bus, drives, uarm):
    """The master is killed in the middle of the motion."""

    def kill():
        if drives[1].seen.syncs == CYCLES // 2:
            uarm.kill()

    drives[1].on_sync = kill


TRAITS = [
    works("works", dictionary=""),
    works("no-sync-counter"),
    works("no-resolution", encoder='counts_per_revolution = 16384, resolution_object = "absent"'),
    refused("no-resolution-unsaid", "608F", 'resolution_object = "absent"', dictionary="no-resolution"),
    works("whole-milliseconds"),
    works("fixed-interpolation"),
    refused("other-interpolation", "60C2"),
    works("no-interpolation"),
    works("rated-torque-read-only"),
    works("rated-torque-micro", drive='rated_torque_nm = 0.2, rated_torque_unit = "uNm"', torque_unit=1e-6),
    works("no-rated-torque", drive='rated_torque_nm = 0.2, target_torque_of = "stated-torque"'),
    works("gear", drive="rated_torque_nm = 0.004", encoder="counts_per_revolution = 1024", joint="gear_ratio = [50, 1]", gear=50.0),
    refused("no-heartbeat-consumer", "1016"),
    works("rpdo-watchdog", drive=WATCHES_RPDO, emergencies=(RPDO_TIMEOUT, ERROR_RESET)),
    Trait(
        "rpdo-watchdog-killed",
        dictionary="rpdo-watchdog",
        drive=WATCHES_RPDO,
        exit=KILLED,
        must_send=RPDO_TIMEOUT,
        event=is_left_alone,
    ),
    refused("rpdo-watchdog-unsaid", "1016", 'drive.watchdog = "rpdo-timeout"', dictionary="rpdo-watchdog"),
    refused("nothing-on-loss", "6007", dictionary="", writes=()),
    works("tpdos-on"),
    works("identifier-bits"),
    works("fixed-mapping"),
    refused("other-mapping", "1A00"),
    refused("no-torque-mode", "6502"),
    refused("wrong-mode-display", "6061", power=Power.SWITCHED_ON),
    refused("reboots", "boot", dictionary="", event=reboots),
    works("pinned", dictionary="", drive="rated_torque_nm = 0.2, identity = { product = 0x46524742, serial = 1002 }"),
    refused("pinned-other", "1018", dictionary="", drive="rated_torque_nm = 0.2, identity = { serial = 1003 }"),
    works("found-enabled", dictionary="", brake_openings=2, event=is_enabled),
    Trait("killed", exit=KILLED, must_send=HEARTBEAT_LOST, event=is_left_alone),
]


def robot_file(trait):
    """The paper's robot with a mild task, and the joints of `trait`."""
    text = ROBOT.read_text(encoding="utf-8")
    for old, new in (
        ("end_deg = [80.0, 60.0]", f"end_deg = [{END_DEG[1]}, {END_DEG[2]}]"),
        ("duration_s = 3.0", "duration_s = 0.6"),
        ("hold_s = 0.5", "hold_s = 0.2"),
        ("period_us = 3000", f"period_us = {round(PERIOD * 1e6)}"),
        ("controller_timeout_ms = 50", "controller_timeout_ms = 200"),
        ("drive_timeout_ms = 200", "drive_timeout_ms = 400"),
        ("cutoff_rad_per_s = 27.81882", "cutoff_rad_per_s = 100.0"),
        # These joints are wheels of their own, and no arm: the model says nothing of them.
        ('mode = "on"', 'mode = "off"'),
    ):
        if text.count(old) != 1:
            sys.exit(f"{ROBOT}: expected '{old}' once")
        text = text.replace(old, new)
    before, rest = text.split("[[joints]]", 1)
    after = rest[rest.index("# -----") :]
    return before + "".join(joint_text(node, trait if node == 2 else TRAITS[0]) for node in NODES) + after


def joint_text(node, trait):
    role, torque, rate = ("passive", 0.0, 0.0) if node == 1 else ("active", 0.2, 100.0)
    return f"""[[joints]]
name = "joint {node}"
role = "{role}"
node = {node}
{trait.joint}
encoder = {{ {trait.encoder}, counter_bits = 32, direction = "positive", zero_counts = 0 }}
drive = {{ {trait.drive}, writes = [{", ".join(trait.writes)}] }}
limits = {{ torque_nm = {torque}, torque_rate_nm_per_s = {rate}, velocity_deg_per_s = 360.0, minimum_deg = -170.0, maximum_deg = 170.0 }}

"""


def connect(bus, trait, folder):
    drives = []
    for node, angle in zip(NODES, START_DEG):
        special = node == 2
        eds = folder / f"node-{node}.eds"
        names = ["works", trait.dictionary] if special and trait.dictionary else ["works"]
        eds.write_text(merged([HERE / "dictionaries" / f"{name}.eds" for name in names]), encoding="utf-8")
        joint = Joint(math.radians(angle), gear=trait.gear if special else 1.0)
        drives.append(Drive(bus, node, str(eds), joint, PERIOD, trait.torque_unit if special else 1e-3))
    return drives


def run(bus, trait, folder):
    """Runs uarm against the drives; its exit code, what it printed, and the drives as they are then."""
    drives = connect(bus, trait, folder)
    file = folder / "robot.toml"
    file.write_text(robot_file(trait), encoding="utf-8")
    command = [os.environ["UARM"], "run", "--can", INTERFACE, "--robot", file, "--rt", "prefer", "--log", "none"]
    with open(folder / "output", "w+", encoding="utf-8") as output:
        with subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT) as uarm:
            trait.event(bus, drives, uarm)
            end = time.monotonic() + PATIENCE
            while uarm.poll() is None:
                bus.turn(0.02)
                if time.monotonic() > end:
                    uarm.kill()
        end = time.monotonic() + AFTERWARDS
        while time.monotonic() < end:
            bus.turn(AFTERWARDS)
        for drive in drives:
            drive.unplug()
        output.seek(0)
        return uarm.returncode, output.read(), drives


# --- the judge --------------------------------------------------------------------------------------------------------

ORDER = [Power.SWITCH_ON_DISABLED, Power.READY_TO_SWITCH_ON, Power.SWITCHED_ON, Power.OPERATION_ENABLED]


def judge(trait, drive):
    """What is wrong with what a drive saw."""
    seen = drive.seen
    highest = max((ORDER.index(state) for state in seen.states if state in ORDER), default=0)
    yield from seen.errors
    if drive.brake_open:
        yield "its brake is open at the end"
    if drive.torque() != 0:
        yield f"its torque is {drive.torque()} per mille at the end"
    if highest > ORDER.index(trait.power):
        yield f"reached {ORDER[highest].name}"
    if drive.id == 2 and trait.must_send and trait.must_send not in seen.emergencies:
        yield f"did not send emergency {trait.must_send:04X}h"
    if trait.exit == OK:
        yield from judge_run(drive, trait if drive.id == 2 else TRAITS[0])


def judge_run(drive, trait):
    seen = drive.seen
    index = NODES.index(drive.id)
    if seen.boots != 2:
        yield f"booted {seen.boots} times, expected at power-up and after the reset"
    if seen.brake_openings != trait.brake_openings:
        yield f"its brake opened {seen.brake_openings} times"
    if seen.syncs < CYCLES or seen.rpdos < seen.syncs or seen.feedback < CYCLES:
        yield f"{seen.syncs} SYNCs, {seen.rpdos} RPDOs, {seen.feedback} TPDOs, expected {CYCLES}"
    if seen.surplus:
        yield f"sent {seen.surplus} PDOs that nobody asked for"
    if seen.unguarded_syncs:
        yield f"no watchdog was armed at {seen.unguarded_syncs} SYNCs"
    late = [
        f"{index:04X}h:{subindex:02X}"
        for index, subindex, state in seen.writes
        if state is not Power.SWITCH_ON_DISABLED and index != CONTROLWORD
    ]
    if late:
        yield f"written with power on: {', '.join(late)}"
    if set(seen.emergencies) - set(trait.emergencies):
        yield f"sent emergencies {', '.join(f'{code:04X}h' for code in seen.emergencies)}"
    if (seen.largest_torque > 0) != (drive.id != NODES[0]):
        yield f"largest torque {seen.largest_torque} per mille"
    reached = math.degrees(drive.joint.angle)
    if abs(reached - END_DEG[index]) > REACHED_DEG:
        yield f"reached {reached:.2f} degrees, expected {END_DEG[index]}"


def try_trait(bus, trait):
    """Prints the trait's line; true if everything is as expected."""
    with tempfile.TemporaryDirectory() as folder:
        begun = time.monotonic()
        code, output, drives = run(bus, trait, pathlib.Path(folder))
        took = time.monotonic() - begun
    wrong = [f"node {drive.id} {what}" for drive in drives for what in judge(trait, drive)]
    if code != trait.exit:
        wrong.append(f"exit code {code}, expected {trait.exit}")
    wrong += [f"'{text}' is not in the output" for text in trait.text if text not in output]
    seen = drives[1].seen
    print(
        f"{'FAILED' if wrong else 'ok    '} {trait.name}: exit {code}, {seen.syncs} SYNCs, {seen.rpdos} RPDOs, "
        f"largest torque {seen.largest_torque} per mille, {took:.1f} s"
    )
    if wrong:
        print("\n".join(f"       {line}" for line in wrong), output, sep="\n")
    return not wrong


def main():
    names = sys.argv[1:]
    unknown = set(names) - {trait.name for trait in TRAITS}
    if unknown:
        sys.exit(f"no trait {', '.join(sorted(unknown))}; there are {', '.join(trait.name for trait in TRAITS)}")
    bus = Bus(INTERFACE)
    results = [try_trait(bus, trait) for trait in TRAITS if not names or trait.name in names]
    failed = results.count(False)
    print(f"test result: {'FAILED' if failed else 'ok'}. {len(results) - failed} passed; {failed} failed")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
