"""The traits of bought drives, which of them are tried together, and what must come of it.

Usage: traits.py [TRAIT...]; the environment variable UARM names the program. Each trial prints one line; the last line counts them.
"""

import sys
import time

from bus import Bus
from drive import ERROR_RESET, HEARTBEAT_LOST, OVERHEATED, RPDO_TIMEOUT, UNDER_VOLTAGE, Maker
from judge import judge
from power import Power
from trial import (
    ABORT_IS_FAULT,
    CANNOT,
    FAILURE,
    INTERFACE,
    KILLED,
    PLAIN,
    WORKS_WITH,
    Trait,
    Trial,
    nothing,
    tried,
)

WATCHES_RPDO = 'rated_torque_nm = 0.2, watchdog = "rpdo-timeout", rpdo_timeout_ms = 100'
MAKERS_LINES = 'counts_per_revolution = 16384, resolution_object = {{ index = 0x3010, subindex = 4, equals = {} }}'
LIMIT = '{{ index = 0x6072, subindex = 0, type = "u16", value = 900{} }}'
OF_CURRENT = 'rated_torque_nm = 0.2, target_torque_of = "rated-current", rated_current_ma = {}'


def refused(name, *text, power=Power.SWITCH_ON_DISABLED, event=nothing, **trait):
    """A trial in which nothing may start; as a rule before any power."""
    return Trial((Trait(name, **trait),), text, FAILURE, power, event=event)


# --- what happens beside a run ----------------------------------------------------------------------------------------


def reboots(drives, _uarm):
    """Node 2 loses its supply for a moment while node 3 is being set up."""

    def reboot():
        drives[2].on_write = nothing
        drives[1].reboot()

    drives[2].on_write = reboot


def is_left_alone(drives, uarm):
    """The master is killed in the middle of the motion."""
    CYCLE = 40

    def kill():
        if drives[1].seen.syncs == CYCLE:
            uarm.kill()

    drives[1].on_sync = kill


def alarms_in_set_up(*codes):
    """Emergencies between the first SDO to the drive and its enabling."""

    def prepare(drive):
        def alarm():
            drive.on_write = nothing
            for code in codes:
                drive.emergency(code, 0)

        drive.on_write = alarm

    return prepare


def alarms_at_boot(drive):
    """As a drive that reports what ended the last run."""
    drive.on_boot = lambda: drive.emergency(UNDER_VOLTAGE, 0)


def alarms_when_enabled(drive):
    """Between the enabling and the first SYNC; it stays enabled."""

    def alarm():
        if drive.brake_open:
            drive.emergency(OVERHEATED, 0)

    drive.on_state = alarm


# --- the table --------------------------------------------------------------------------------------------------------

NO_SYNC_COUNTER = Trait("no-sync-counter", holds={(0x1019, 0): 0})
NO_RESOLUTION = Trait("no-resolution", encoder='counts_per_revolution = 16384, resolution_object = "absent"')
WHOLE_MILLISECONDS = Trait("whole-milliseconds", holds={(0x60C2, 1): 10, (0x60C2, 2): -3})
FIXED_INTERPOLATION = Trait("fixed-interpolation", holds={(0x60C2, 1): 10, (0x60C2, 2): -3})
FIXED_EXPONENT = Trait("fixed-exponent", holds={(0x60C2, 1): 100, (0x60C2, 2): -4})
NO_INTERPOLATION = Trait("no-interpolation")
RATED_TORQUE_READ_ONLY = Trait("rated-torque-read-only")
RATED_TORQUE_MICRO = Trait(
    "rated-torque-micro", drive='rated_torque_nm = 0.2, rated_torque_unit = "uNm"', maker=Maker(torque_unit=1e-6)
)
NO_RATED_TORQUE = Trait("no-rated-torque", drive='rated_torque_nm = 0.2, target_torque_of = "stated-torque"')
RATED_CURRENT = Trait("rated-current", drive=OF_CURRENT.format(3000))
OWN_LIMIT = Trait("own-limit", holds={(0x6072, 0): 500})
RESOLUTION_OBJECT = Trait("resolution-object", encoder=MAKERS_LINES.format(4096))
GEAR = Trait(
    "gear",
    drive="rated_torque_nm = 0.004",
    encoder="counts_per_revolution = 1024",
    joint="gear_ratio = [50, 1]",
    gear=50.0,
)
GEAR_INSIDE = Trait(
    "gear-inside",
    code=WORKS_WITH,
    rows={"6091h:01": 'drive.writes: { index = 0x6091, subindex = 1, type = "u32", value = 1 }'},
)
FEED_UNIT = Trait(
    "feed-unit",
    code=WORKS_WITH,
    rows={"6092h:01": 'drive.writes: { index = 0x6092, subindex = 1, type = "u32", value = 1 }'},
    holds={(0x6092, 1): 1},
)
TURNED = Trait(
    "turned",
    code=WORKS_WITH,
    rows={"607Eh:00": 'drive.writes: { index = 0x607E, subindex = 0, type = "u8", value = 0 }'},
)
AT_SYNC = Trait("at-sync", drive='rated_torque_nm = 0.2, torque_applies = "at-sync"', holds={(0x1400, 2): 1})
AT_SYNC_SLOW = Trait("at-sync-slow", dictionary="at-sync", drive=AT_SYNC.drive)
LATE_TORQUE = Trait(
    "late-torque", dictionary="", drive="rated_torque_nm = 0.2, torque_delay_us = 1000", maker=Maker(torque_delay=0.2)
)
TPDOS_ON = Trait("tpdos-on")
IDENTIFIER_BITS = Trait("identifier-bits")
FIXED_MAPPING = Trait("fixed-mapping")
OTHER_PDOS = Trait(
    "other-pdos",
    dictionary="tpdos-on other-pdos",
    drive="rated_torque_nm = 0.2, pdo = { rpdo = 2, rpdo_id = 0x331, tpdo = 3, tpdo_id = 0x1F2, "
    "torque_tpdo = 2, torque_tpdo_id = 0x1FA, keep_tpdos = [4] }",
    maker=Maker(command_rpdo=2),
    sends=(0x1F2, 0x1FA, 0x482),
    holds={
        (0x1400, 1): 0x80000202,
        (0x1401, 1): 0x331,
        (0x1401, 2): 255,
        (0x1600, 0): 1,
        (0x1600, 2): 0,
        (0x1601, 0): 2,
        (0x1601, 1): 0x60400010,
        (0x1601, 2): 0x60710010,
        (0x1800, 1): 0x80000182,
        (0x1800, 2): 255,
        (0x1801, 1): 0x1FA,
        (0x1801, 2): 1,
        (0x1802, 1): 0x1F2,
        (0x1802, 2): 1,
        (0x1803, 1): 0x482,
        (0x1A00, 0): 1,
        (0x1A00, 2): 0,
        (0x1A01, 0): 1,
        (0x1A01, 1): 0x60770010,
        (0x1A02, 0): 2,
        (0x1A02, 1): 0x60410010,
        (0x1A02, 2): 0x60640020,
    },
)
TORQUE_FEEDBACK = Trait(
    "torque-feedback",
    dictionary="",
    drive="rated_torque_nm = 0.2, pdo = { torque_tpdo = 2 }",
    sends=(0x183, 0x283),
    holds={(0x1801, 1): 0x283, (0x1801, 2): 1, (0x1A01, 0): 1, (0x1A01, 1): 0x60770010},
)
WRITTEN_AFTER = Trait(
    "written-after",
    dictionary="",
    maker=Maker(mode_resets=((0x6072, 0),)),
    writes=(ABORT_IS_FAULT, LIMIT.format(', when = "after"')),
    holds={(0x6072, 0): 900},
    last_write=(0x6072, 0),
)
NO_ABORT_OPTION = Trait(
    "no-abort-option", drive='rated_torque_nm = 0.2, without_6007h = "tried with the arm in a jig"', writes=()
)
NO_MODE_LIST = Trait("no-mode-list")
FIXED_SYNC_COUNTER = Trait("fixed-sync-counter")
FIXED_HEARTBEAT = Trait("fixed-heartbeat")
RPDO_WATCHDOG = Trait("rpdo-watchdog", drive=WATCHES_RPDO, emergencies=(RPDO_TIMEOUT, ERROR_RESET))
PINNED = Trait(
    "pinned", dictionary="", drive="rated_torque_nm = 0.2, identity = { product = 0x46524742, serial = 1003 }"
)
# A master that was killed left it enabled.
FOUND_ENABLED = Trait("found-enabled", dictionary="", brake_openings=2, prepare=lambda drive: drive.enable())
FOUND_IN_FAULT = Trait(
    "found-in-fault", dictionary="", prepare=lambda drive: drive.fail(), emergencies=(ERROR_RESET, HEARTBEAT_LOST)
)
ALARM_OVER = Trait(
    "alarm-over",
    dictionary="",
    prepare=alarms_in_set_up(OVERHEATED, ERROR_RESET),
    emergencies=(OVERHEATED, ERROR_RESET, HEARTBEAT_LOST),
    must_send=OVERHEATED,
)
ALARM_AT_BOOT = Trait(
    "alarm-at-boot",
    dictionary="",
    prepare=alarms_at_boot,
    emergencies=(UNDER_VOLTAGE, HEARTBEAT_LOST),
    must_send=UNDER_VOLTAGE,
)

TRIALS = [
    Trial((PLAIN,), ("torque 6072h 1000 (3E8h), current 6073h 1000 (3E8h)",)),
    # Drives with which a run works.
    Trial((NO_SYNC_COUNTER, NO_RESOLUTION), sync_length=0),
    Trial((WHOLE_MILLISECONDS, FIXED_INTERPOLATION)),
    Trial((NO_INTERPOLATION, RATED_TORQUE_READ_ONLY)),
    Trial((RATED_TORQUE_MICRO, NO_RATED_TORQUE)),
    Trial((GEAR, IDENTIFIER_BITS)),
    Trial((TPDOS_ON, FIXED_MAPPING)),
    Trial((RPDO_WATCHDOG, PINNED)),
    Trial((FOUND_ENABLED, FOUND_IN_FAULT)),
    Trial((AT_SYNC, LATE_TORQUE), period=0.005),
    Trial((OTHER_PDOS, TORQUE_FEEDBACK), reports_torque=True),
    Trial((RESOLUTION_OBJECT, RATED_CURRENT, FIXED_HEARTBEAT)),
    Trial(
        (WRITTEN_AFTER, NO_ABORT_OPTION, NO_MODE_LIST),
        ("joint 3: 6007h need not be set, as the robot file says: tried with the arm in a jig", "node 1: 6502h:00"),
    ),
    Trial(
        (FIXED_EXPONENT, OWN_LIMIT, FIXED_SYNC_COUNTER),
        (
            "node 3: its own limits, per mille of the rated: torque 6072h 500 (1F4h), current 6073h 700 (2BCh)",
            "the drive cuts torque below the robot file's limit",
        ),
        sync_length=0,
    ),
    Trial((ALARM_OVER, ALARM_AT_BOOT), bus='sync_counter = "off"', sync_length=0),
    Trial((GEAR_INSIDE, FEED_UNIT, TURNED), as_printed=True),
    # Drives whose master is killed.
    Trial(
        (Trait("rpdo-watchdog-killed", dictionary="rpdo-watchdog", drive=WATCHES_RPDO, must_send=RPDO_TIMEOUT),),
        exit=KILLED,
        event=is_left_alone,
    ),
    Trial((Trait("killed", dictionary="", must_send=HEARTBEAT_LOST),), exit=KILLED, event=is_left_alone),
    # Drives with which nothing starts, and what is said of them.
    refused("no-resolution-unsaid", "608F", 'resolution_object = "absent"', dictionary="no-resolution"),
    refused("gear-inside-unsaid", "node 2: 6091h:01", "drive.writes", dictionary="gear-inside"),
    refused("other-interpolation", "60C2"),
    refused("other-exponent", "60C2h:01", "control.period_us"),
    refused("other-heartbeat", "1017h:00", "drive_heartbeat_ms"),
    refused("no-heartbeat-consumer", "1016"),
    refused("rpdo-watchdog-unsaid", "1016", 'drive.watchdog = "rpdo-timeout"', dictionary="rpdo-watchdog"),
    refused("nothing-on-loss", "6007", dictionary="", writes=()),
    refused("other-mapping", "1A00"),
    refused("other-pdos-unsaid", "1803h:01", "drive.pdo.keep_tpdos = [4]", dictionary=OTHER_PDOS.dictionary),
    refused("at-sync-unsaid", "1400h:02", 'drive.torque_applies = "at-sync"', dictionary="at-sync"),
    # A cycle of 10 ms more is too late for the loop.
    Trial((AT_SYNC_SLOW, AT_SYNC_SLOW), ("would swing up",), FAILURE, Power.SWITCH_ON_DISABLED, untouched=True),
    refused(
        "written-before",
        "6072h:00",
        'when = "after"',
        dictionary="",
        maker=WRITTEN_AFTER.maker,
        writes=(ABORT_IS_FAULT, LIMIT.format("")),
    ),
    refused("no-torque-mode", "6502"),
    refused("mode-not-taken", "6060h:00", dictionary="no-mode-list", maker=Maker(modes=0x1A9)),
    refused("wrong-mode-display", "6061", power=Power.SWITCHED_ON),
    refused("pinned-other", "1018", dictionary="", drive="rated_torque_nm = 0.2, identity = { serial = 1003 }"),
    refused("reboots", "boot", dictionary="", event=reboots),
    refused("alarm-in-set-up", "4210h", dictionary="", power=Power.SWITCHED_ON, prepare=alarms_in_set_up(OVERHEATED)),
    # Brakes are open when it comes, and no SYNC follows.
    refused("alarm-enabled", "4210h", dictionary="", power=Power.OPERATION_ENABLED, prepare=alarms_when_enabled),
    # Drives that `uarm drive check` judges.
    Trial(
        (
            Trait(
                "rated-torque-micro-unsaid",
                dictionary="rated-torque-micro",
                code=WORKS_WITH,
                rows={"6076h:00": 'drive.rated_torque_unit = "uNm"'},
            ),
            Trait(
                "no-rated-torque-unsaid",
                dictionary="no-rated-torque",
                code=WORKS_WITH,
                rows={"6076h:00": 'drive.target_torque_of = "stated-torque"'},
            ),
            Trait(
                "no-abort-option-unsaid",
                dictionary="no-abort-option",
                writes=(),
                code=WORKS_WITH,
                rows={"6007h:00": "drive.without_6007h"},
            ),
        ),
        check=True,
    ),
    Trial(
        (
            Trait(
                "resolution-object-other",
                dictionary="resolution-object",
                encoder=MAKERS_LINES.format(8192),
                code=CANNOT,
                rows={"3010h:04": "one of them is wrong"},
            ),
            Trait(
                "no-sync-counter-wanted",
                dictionary="no-sync-counter",
                code=CANNOT,
                rows={"1019h:00": '[bus] sync_counter = "auto"'},
            ),
            Trait(
                "rated-current-other",
                dictionary="rated-current",
                drive=OF_CURRENT.format(2000),
                code=WORKS_WITH,
                rows={"6075h:00": "rated_current_ma = 3000"},
            ),
        ),
        bus='sync_counter = "on"',
        check=True,
    ),
]


def try_out(bus, trial):
    """Prints the trial's line; true if everything is as expected."""
    begun = time.monotonic()
    with tried(bus, trial) as outcome:
        took = time.monotonic() - begun
        wrong = list(judge(trial, outcome))
        seen = outcome.drives[1].seen
        print(
            f"{'FAILED' if wrong else 'ok    '} {trial.name}: exit {outcome.code}, {seen.syncs} SYNCs, {seen.rpdos} RPDOs, "
            f"largest torque {seen.largest_torque} per mille, {took:.1f} s"
        )
        if wrong:
            print("\n".join(f"       {line}" for line in wrong), outcome.output, sep="\n")
    return not wrong


def main():
    names = set(sys.argv[1:])
    known = [trait.name for trial in TRIALS for trait in trial.traits]
    unknown = names - set(known)
    if unknown:
        sys.exit(f"no trait {', '.join(sorted(unknown))}; there are {', '.join(known)}")
    bus = Bus(INTERFACE)
    chosen = [trial for trial in TRIALS if not names or names & {trait.name for trait in trial.traits}]
    results = [try_out(bus, trial) for trial in chosen]
    failed = results.count(False)
    print(f"test result: {'FAILED' if failed else 'ok'}. {len(results) - failed} passed; {failed} failed")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
