"""What is tried: traits of drives, the robot file that goes with them, and `uarm` beside three drives on one bus."""

import contextlib
import csv
import dataclasses
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import typing

from dictionary import merged
from drive import HEARTBEAT_LOST, Drive, Joint, Maker
from power import Power

HERE = pathlib.Path(__file__).parent
ROBOT = HERE.parent.parent / "robots" / "uarm.toml"
INTERFACE = "vcan0"
PATIENCE = 600.0  # seconds; a run takes two, but the time of a guest leaps while it waits for a file
AFTERWARDS = 0.3  # seconds; longer than any drive bears to hear nothing
NODES = (1, 2, 3)
START_DEG = (0.0, 20.0, 20.0)
END_DEG = (0.0, 30.0, 30.0)
TASK, HOLD = 0.6, 0.2  # seconds
WORKS, WORKS_WITH, CANNOT = 0, 3, 1  # exit codes of `uarm drive check`
OK, FAILURE, KILLED = 0, 1, -9
ABORT_IS_FAULT = '{ index = 0x6007, subindex = 0, type = "i16", value = 1 }'


def nothing(*_):
    pass


@dataclasses.dataclass(frozen=True)
class Trait:
    """What one drive has of its own, what the robot file says of it, and what must come of it in that drive."""

    name: str
    dictionary: str | None = None  # what overrides the dictionary that works with everything; None: the one of this name
    maker: Maker = Maker()
    gear: float = 1.0
    prepare: typing.Callable = nothing  # is given the drive, before uarm starts
    # The robot file.
    writes: tuple = (ABORT_IS_FAULT,)
    encoder: str = "counts_per_revolution = 16384"
    drive: str = "rated_torque_nm = 0.2"
    joint: str = ""
    # What is expected of a run.
    holds: dict = dataclasses.field(default_factory=dict)  # (index, sub-index): value in the end, where it is not every drive's
    sends: tuple | None = None  # identifiers of its PDOs, each sent at each SYNC; None: that of TPDO1
    last_write: tuple | None = None  # the object that is written last by SDO
    brake_openings: int = 1
    emergencies: tuple = (HEARTBEAT_LOST,)  # those that it may send: the master's heartbeat ends before the drive does
    must_send: int | None = None  # an emergency that it must send
    # What `uarm drive check` must say.
    code: int = WORKS
    rows: dict = dataclasses.field(default_factory=dict)  # object: what is in its remedy, for all that is not as it should be

    def files(self):
        own = self.name if self.dictionary is None else self.dictionary
        return tuple(HERE / "dictionaries" / f"{name}.eds" for name in ["works", *own.split()])


PLAIN = Trait("works", dictionary="")


@dataclasses.dataclass(frozen=True)
class Trial:
    """Drives with traits on one bus, what is done with them, and what must come of it."""

    traits: tuple = ()  # of the nodes 2, 3 and 1, in this order; the others work
    text: tuple = ()  # in what uarm prints
    exit: int = OK
    power: Power = Power.OPERATION_ENABLED  # the furthest state that any drive may reach
    untouched: bool = False  # no drive may be reset or written to
    period: float = 0.01  # seconds; Python in an emulated machine wants some
    sync_length: int = 1  # bytes of a SYNC
    bus: str = ""  # more keys of [bus]
    event: typing.Callable = nothing  # is given the drives and the process, when this has started
    check: bool = False  # `uarm drive check` for each trait, in place of a run
    as_printed: bool = False  # the same first, and then a run with the entries that it prints
    reports_torque: bool = False  # the drives' torque must be in the log

    @property
    def name(self):
        return " ".join(trait.name for trait in self.traits)

    def trait(self, node):
        return dict(zip((2, 3, 1), self.traits)).get(node, PLAIN)

    def cycles(self):
        """Of the task and its hold."""
        return round((TASK + HOLD) / self.period)


# --- the robot file ---------------------------------------------------------------------------------------------------


def robot_file(trial, entries):
    """The paper's robot with a mild task, and the joints of the trial: as `entries` has them, else as the traits say."""
    text = ROBOT.read_text(encoding="utf-8")
    for old, new in (
        ("end_deg = [80.0, 60.0]", f"end_deg = [{END_DEG[1]}, {END_DEG[2]}]"),
        ("duration_s = 3.0", f"duration_s = {TASK}"),
        ("hold_s = 0.5", f"hold_s = {HOLD}"),
        ("period_us = 3000", f"period_us = {round(trial.period * 1e6)}"),
        ("controller_timeout_ms = 50", f"controller_timeout_ms = 200\n{trial.bus}"),
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
    return before + "".join(entries.get(node) or entry(node, trial.trait(node)) for node in NODES) + after


def entry(node, trait):
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


# --- uarm and the drives ----------------------------------------------------------------------------------------------


@dataclasses.dataclass
class Outcome:
    """What came of a trial."""

    drives: list
    code: int = OK
    output: str = ""
    checks: dict = dataclasses.field(default_factory=dict)  # node: exit code, what was printed
    torque: dict = dataclasses.field(default_factory=dict)  # node: from the log, sent and reported, per mille


class Bench:
    """Three drives on a bus, and a folder."""

    def __init__(self, bus, trial, folder):
        self._bus, self._trial, self._folder = bus, trial, folder
        self.drives = [self._drive(node, angle) for node, angle in zip(NODES, START_DEG)]

    def _drive(self, node, angle):
        trait = self._trial.trait(node)
        joint = Joint(math.radians(angle), gear=trait.gear)
        drive = Drive(self._bus, node, merged(trait.files()), joint, self._trial.period, trait.maker)
        trait.prepare(drive)
        return drive

    def uarm(self, *arguments, event=nothing):
        """Runs uarm beside the drives; its exit code, and what it printed."""
        with open(self._folder / "output", "w+", encoding="utf-8") as output:
            command = [os.environ["UARM"], *arguments]
            with subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT) as uarm:
                event(self.drives, uarm)
                end = time.monotonic() + PATIENCE
                while uarm.poll() is None:
                    self._bus.turn(0.02)
                    if time.monotonic() > end:
                        uarm.kill()
            output.seek(0)
            return uarm.returncode, output.read()

    def write_robot(self, entries):
        file = self._folder / "robot.toml"
        file.write_text(robot_file(self._trial, entries), encoding="utf-8")
        return file

    def check(self, file):
        """Of each drive with a trait, what `uarm drive check` says."""
        said = {}
        for node in [node for node in NODES if self._trial.trait(node) is not PLAIN]:
            arguments = ("drive", "check", "--can", INTERFACE, "--node", str(node), "--robot", file, "--json")
            said[node] = self.uarm(*arguments)
        return said

    def end(self):
        end = time.monotonic() + AFTERWARDS
        while time.monotonic() < end:
            self._bus.turn(AFTERWARDS)

    def reported_torque(self, log):
        """Of each joint that reports its torque, what was sent to it and what it reported."""
        file = self._folder / "run.csv"
        code, output = self.uarm("show", log, "--csv", file)
        if code != OK:
            return {}
        with open(file, encoding="utf-8") as text:
            rows = list(csv.DictReader(text))
        column = lambda name: [row[name] for row in rows]
        return {
            node: (column(f"torque_sent_{node}_per_mille"), column(f"torque_actual_{node}_per_mille"))
            for node in NODES
            if f"torque_actual_{node}_per_mille" in rows[0]
        }


@contextlib.contextmanager
def tried(bus, trial):
    """The outcome of a trial, with the drives still there."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        bench = Bench(bus, trial, folder)
        outcome = Outcome(bench.drives)
        file = bench.write_robot({})
        if trial.check or trial.as_printed:
            outcome.checks = bench.check(file)
        if not trial.check:
            if trial.as_printed:
                file = bench.write_robot({node: json.loads(said)["joint"] for node, (_, said) in outcome.checks.items()})
            log = folder / "run.mcap" if trial.reports_torque else "none"
            arguments = ("run", "--can", INTERFACE, "--robot", file, "--rt", "prefer", "--log", log)
            outcome.code, outcome.output = bench.uarm(*arguments, event=trial.event)
            bench.end()
            if trial.reports_torque:
                outcome.torque = bench.reported_torque(log)
        yield outcome
        for drive in bench.drives:
            drive.unplug()
