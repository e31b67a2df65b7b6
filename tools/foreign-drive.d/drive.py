"""A CiA 402 servo drive on durand, a CANopen stack that shares no code with uarm.

The stack brings NMT, SDO server, PDOs, SYNC, emergencies and the heartbeat; this file adds what makes a drive of a node: the power
state machine, the brake, the torque mode, the joint, the watch on the master's heartbeat, and the standard's abort codes. What
the drive knows and allows is in its EDS.
"""

import collections
import dataclasses
import math

from durand import Node
from durand.node import NodeCapabilities
from durand.services.nmt import StateEnum
from durand.services.sdo.server import SDODomainAbort

import power
from bus import Port
from dictionary import Dictionary, FIRST_PROFILE_OBJECT
from power import Power

CYCLIC_SYNCHRONOUS_TORQUE = 10
CONTROLWORD = 0x6040
BRAKE_TIME = 0.02  # seconds from "enable operation" to an open brake
PDO_OFF = 1 << 31
NO_REMOTE_REQUEST = 1 << 30
IDENTIFIER = 0x7FF

# SDO abort codes, CiA 301 table 22.
SUB_INDEX_0_NOT_ZERO = 0x06010003
CANNOT_BE_MAPPED = 0x06040041
TOO_LONG_FOR_A_PDO = 0x06040042
VALUE_OUT_OF_RANGE = 0x06090030
NOT_IN_THIS_STATE = 0x08000022

# Emergencies, CiA 301 table 26.
ERROR_RESET = 0x0000
UNDER_VOLTAGE = 0x3220
OVERHEATED = 0x4210
HEARTBEAT_LOST = 0x8130
SYNC_LENGTH = 0x8240
RPDO_TIMEOUT = 0x8250
GENERIC, COMMUNICATION = 1 << 0, 1 << 4  # bits of the error register


@dataclasses.dataclass
class Joint:
    """An inertia with viscous friction, and a brake that holds it."""

    angle: float  # rad
    inertia: float = 0.02  # kg m^2
    friction: float = 0.02  # N m s
    gear: float = 1.0  # motor revolutions per revolution of the joint
    velocity: float = 0.0

    def advance(self, torque, braked, period):
        """Moves for `period` seconds with a constant torque at the motor: the exact solution."""
        if braked:
            self.velocity = 0.0
            return
        final = torque * self.gear / self.friction
        rate = self.friction / self.inertia
        decay = math.exp(-rate * period)
        self.angle += final * period + (self.velocity - final) * (1 - decay) / rate
        self.velocity = final + (self.velocity - final) * decay


@dataclasses.dataclass
class Seen:
    """What the drive saw; its judge reads it."""

    states: list = dataclasses.field(default_factory=list)
    writes: list = dataclasses.field(default_factory=list)  # (index, sub-index, power state)
    errors: list = dataclasses.field(default_factory=list)
    emergencies: list = dataclasses.field(default_factory=list)
    boots: int = 0
    syncs: int = 0
    rpdos: int = 0
    heartbeats: int = 0
    brake_openings: int = 0
    largest_torque: int = 0  # per mille, while the brake was open
    sent: collections.Counter = dataclasses.field(default_factory=collections.Counter)  # frames, by identifier
    idle_writes: list = dataclasses.field(default_factory=list)  # (index, sub-index) of what read so already
    sync_lengths: set = dataclasses.field(default_factory=set)
    unguarded_syncs: int = 0  # SYNCs with an open brake and no watchdog that would close it


@dataclasses.dataclass(frozen=True)
class Maker:
    """What no dictionary tells of a drive."""

    torque_unit: float = 1e-3  # of 6076h, N m
    torque_delay: float = 0.0  # until a torque is there, periods
    command_rpdo: int = 1  # the RPDO that its master uses
    modes: int = 0x3A9  # that it takes, if it does not list them in 6502h
    mode_resets: tuple = ()  # objects that have their defaults again when 6060h is written


class Drive:
    def __init__(self, bus, node, eds, joint, period, maker):
        self.id, self.eds, self.joint, self.seen = node, eds, joint, Seen()
        self._bus, self._period, self._maker = bus, period, maker
        self._port = None
        self._timers = {}
        self._last_torque = 0
        # What else happens when it has booted, when an object is about to be written by SDO, at each SYNC, and in a new power state.
        self.on_boot = self.on_write = self.on_sync = self.on_state = lambda: None
        self.brake_open = False
        self.state = Power.SWITCH_ON_DISABLED
        self._boot({})

    # --- start and reset ------------------------------------------------------------------------------------------

    def _boot(self, kept):
        """A new node sends its boot-up message and has forgotten everything but `kept`."""
        if self._port:
            self.unplug()
        self._controlword = 0
        self._watched = None
        self.seen.boots += 1
        self.objects = Dictionary(self.eds, self.id)
        self._port = Port(self._bus, self._tap, self._count)
        pdos = {"rpdos": self.objects.pdos(0x1400), "tpdos": self.objects.pdos(0x1800)}
        self.node = Node(self._port, self.id, self.objects, NodeCapabilities(sdo_servers=1, **pdos))
        self.node.sync.callbacks.add(self._checked(self._on_sync))
        self._keep_identifiers()
        self._load(kept)
        self._react()
        self._show()
        self.objects.write(0x6064, 0, self.counts())
        self.on_boot()

    def _keep_identifiers(self):
        """The stack gives its first four PDOs the predefined identifiers at each NMT start; these keep those that were written."""

        def follow(pdo):
            def enter(state):
                if state == StateEnum.OPERATIONAL:
                    pdo._activate_mapping()
                else:
                    pdo._deactivate_mapping()

            return enter

        for pdo in self.node.rpdo + self.node.tpdo:
            self.node.nmt.state_callbacks.remove(pdo._update_nmt_state)
            self.node.nmt.state_callbacks.add(follow(pdo))

    def _load(self, kept):
        for (index, subindex), value in self.objects.defaults.items():
            if index < FIRST_PROFILE_OBJECT or (index, subindex) not in kept:
                self.objects.write(index, subindex, value)
        for multiplexor, value in kept.items():
            self.objects.write(*multiplexor, value)
        for first, mapping in ((0x1400, 0x1600), (0x1800, 0x1A00)):
            for number in range(self.objects.pdos(first)):
                for index, subindex in ((first + number, 1), (first + number, 2), (mapping + number, 0)):
                    value = self.objects.defaults[(index, subindex)]
                    self.objects.write(index, subindex, value, downloaded=True)

    def unplug(self):
        """Takes the node off the bus, silently."""
        for timer in list(self._timers):
            self._stop_timer(timer)
        self.objects.write(0x1017, 0, 0)
        self._port.unplug()

    def reboot(self):
        """What a drop of the supply does."""
        self._enter(Power.SWITCH_ON_DISABLED)
        self._boot({})

    def _reset_communication(self):
        """6007h = 0, no action, also keeps the power on, and no reset ends a fault."""
        if self._abort_option() != 0 and self.state is not Power.FAULT:
            self._enter(Power.SWITCH_ON_DISABLED)
        kept = {name: self._value(*name) for name in self.objects.defaults if name[0] >= FIRST_PROFILE_OBJECT}
        self._boot(kept)

    # --- frames ---------------------------------------------------------------------------------------------------

    def _tap(self, identifier, data):
        """Sees each frame before the stack does."""
        if identifier == 0 and data[1] in (0, self.id):
            return self._on_nmt(data[0])
        if identifier == 0x80:
            self.seen.sync_lengths.add(len(data))
            if len(data) != (1 if self._counts_syncs() else 0):
                self.emergency(SYNC_LENGTH, GENERIC | COMMUNICATION)
                return True
        if identifier == 0x600 + self.id and data[0] >> 5 == 1:
            self._on_download(int.from_bytes(data[1:3], "little"), data[3], data[4:])
        if identifier == self._rpdo_identifier() and self.node.nmt.state == StateEnum.OPERATIONAL:
            self._on_rpdo()
        if self._watched and identifier == 0x700 + self._watched[0]:
            self.seen.heartbeats += 1
            self._start_timer("heartbeat", self._watched[1], self._heartbeat_lost)
        return False

    def _on_nmt(self, command):
        RESET_NODE, RESET_COMMUNICATION = 0x81, 0x82
        if command == RESET_NODE:
            self.reboot()
        elif command == RESET_COMMUNICATION:
            self._reset_communication()
        return command in (RESET_NODE, RESET_COMMUNICATION)

    def _on_download(self, index, subindex, data):
        """Expedited, as all objects here are: four bytes at most, of which the first hold the value."""
        self.seen.writes.append((index, subindex, self.state))
        if self.objects.has(index, subindex) and index != CONTROLWORD:
            found = self.objects.lookup(index, subindex).pack(self._value(index, subindex))
            if data[: len(found)] == found:
                self.seen.idle_writes.append((index, subindex))
        self.on_write()

    def _count(self, identifier):
        self.seen.sent[identifier] += 1

    def _rpdo(self):
        """The index of the communication parameters of the RPDO that carries commands."""
        return 0x1400 + self._maker.command_rpdo - 1

    def _rpdo_identifier(self):
        identifier = self._value(self._rpdo(), 1)
        return None if identifier & PDO_OFF else identifier & IDENTIFIER

    def _counts_syncs(self):
        return self.objects.has(0x1019) and self._value(0x1019) != 0

    # --- what the objects do --------------------------------------------------------------------------------------

    def _react(self):
        """Connects the objects to the drive, after their defaults are in place."""
        objects = self.objects
        self._on_change(0x6040, 0, self._on_controlword)
        self._on_change(0x6060, 0, self._on_mode)
        self._on_change(0x1016, 1, self._on_consumer_heartbeat)
        self._guard(0x1019, 0, lambda value: None if value == 0 or 2 <= value <= 240 else VALUE_OUT_OF_RANGE)
        self._guard(0x6060, 0, self._refuses_mode)
        self._guard(0x6076, 0, lambda _: NOT_IN_THIS_STATE if self.state is Power.OPERATION_ENABLED else None)
        for first, mapping in ((0x1400, 0x1600), (0x1800, 0x1A00)):
            for number in range(objects.pdos(first)):
                self._guard_pdo(first + number, mapping + number)

    def _guard_pdo(self, parameters, mapping):
        """The order of CiA 301: off, count 0, entries, count, on."""

        def identifier(value):
            found = self._value(parameters, 1)
            both_on = not (value | found) & PDO_OFF
            return VALUE_OUT_OF_RANGE if both_on and (value ^ found) & IDENTIFIER else None

        def count(value):
            if not self._value(parameters, 1) & PDO_OFF:
                return NOT_IN_THIS_STATE
            entries = [self._value(mapping, k) for k in range(1, value + 1)]
            if any((entry >> 16, entry >> 8 & 0xFF) not in self.objects.mappable for entry in entries):
                return CANNOT_BE_MAPPED
            return TOO_LONG_FOR_A_PDO if sum(entry & 0xFF for entry in entries) > 64 else None

        self._guard(parameters, 1, identifier)
        self._guard(mapping, 0, count)
        for subindex in range(1, 9):
            self._guard(mapping, subindex, lambda _: SUB_INDEX_0_NOT_ZERO if self._value(mapping, 0) else None)
        # Whether remote requests are answered is the drive's own: the bit reads as it came from its maker.
        no_remote = self.objects.defaults[(parameters, 1)] & NO_REMOTE_REQUEST
        objects = self.objects
        objects.set_read_callback(parameters, 1, lambda: objects.stored(parameters, 1) & ~NO_REMOTE_REQUEST | no_remote)

    def _on_change(self, index, subindex, react):
        if self.objects.has(index, subindex):
            self.objects.update_callbacks[(index, subindex)].add(self._checked(react))

    def _guard(self, index, subindex, refuses):
        """Lets `refuses` give the abort code for a value."""

        def check(value):
            code = refuses(value)
            if code is not None:
                raise SDODomainAbort(code, (index, subindex))

        if self.objects.has(index, subindex):
            self.objects.validate_callbacks[(index, subindex)].add(check)

    def _checked(self, function):
        """The stack swallows what its callbacks raise; the judge must know."""

        def call(*arguments):
            try:
                function(*arguments)
            except Exception as error:
                self.seen.errors.append(f"{function.__name__}: {error!r}")
                raise

        return call

    def _value(self, index, subindex=0):
        return self.objects.read(index, subindex)

    def _refuses_mode(self, mode):
        modes = self._value(0x6502) if self.objects.has(0x6502) else self._maker.modes
        known = modes >> (mode - 1) & 1 if mode > 0 else mode == 0
        return None if known else VALUE_OUT_OF_RANGE

    def _on_mode(self, mode):
        for multiplexor in self._maker.mode_resets:
            self.objects.write(*multiplexor, self.objects.defaults[multiplexor])
        if self.objects.lookup(0x6061).access != "const":
            self.objects.write(0x6061, 0, mode)

    # --- power ----------------------------------------------------------------------------------------------------

    def _on_controlword(self, controlword):
        rising = controlword & ~self._controlword
        self._controlword = controlword
        if self.state is Power.FAULT:
            if rising & power.FAULT_RESET:
                self.emergency(ERROR_RESET, 0)
                self._enter(Power.SWITCH_ON_DISABLED)
            return
        stays = self.objects.has(0x605A) and self._value(0x605A) >= 5
        wanted = power.after(self.state, power.command(controlword), stays)
        if wanted is not Power.OPERATION_ENABLED or self.state is Power.OPERATION_ENABLED:
            self._stop_timer("brake")
            self._enter(wanted)
        elif "brake" not in self._timers:
            self._enter(Power.SWITCHED_ON)
            self._start_timer("brake", BRAKE_TIME, lambda: self._enter(Power.OPERATION_ENABLED))

    def _enter(self, state):
        if state is self.state:
            return
        self.state = state
        self.seen.states.append(state)
        open_before, self.brake_open = self.brake_open, state is Power.OPERATION_ENABLED
        self.seen.brake_openings += self.brake_open and not open_before
        self._show()
        self.on_state()

    def _show(self):
        self.objects.write(0x6041, 0, self.state.statusword())

    def enable(self):
        """As a master leaves a drive that it enabled before it was killed."""
        self._enter(Power.OPERATION_ENABLED)

    def fail(self):
        """As a fault of the last run leaves a drive."""
        self._enter(Power.FAULT)

    # --- cycle ----------------------------------------------------------------------------------------------------

    def torque(self):
        """Per mille of the rated torque that the motor gives now."""
        follows = self.state is Power.OPERATION_ENABLED and self._value(0x6061) == CYCLIC_SYNCHRONOUS_TORQUE
        limit = self._value(0x6072) if self.objects.has(0x6072) else 1000
        return max(-limit, min(limit, self._value(0x6071))) if follows else 0

    def rated_torque(self):
        """N m, of the motor."""
        return self._value(0x6076) * self._maker.torque_unit if self.objects.has(0x6076) else 0.2

    def counts(self):
        """Motor counts: what 6064h reads."""
        resolution = 16384
        if self.objects.has(0x608F, 1):
            resolution = self._value(0x608F, 1) / self._value(0x608F, 2)
        return round(self.joint.angle * self.joint.gear / (2 * math.pi) * resolution)

    def _on_sync(self):
        self.on_sync()
        self.seen.syncs += 1
        self.seen.unguarded_syncs += self.brake_open and not self.armed()
        torque = self.torque()
        self.seen.largest_torque = max(self.seen.largest_torque, abs(torque))
        late, self._last_torque = self._last_torque, torque
        for per_mille, part in ((late, self._maker.torque_delay), (torque, 1 - self._maker.torque_delay)):
            self.joint.advance(per_mille * 1e-3 * self.rated_torque(), not self.brake_open, self._period * part)
        self.objects.write(0x6064, 0, self.counts())
        if self.objects.has(0x6077):
            self.objects.write(0x6077, 0, torque)

    def _on_rpdo(self):
        self.seen.rpdos += 1
        timeout = self._value(self._rpdo(), 5) if self.objects.has(self._rpdo(), 5) else 0
        if timeout:
            self._start_timer("rpdo", timeout * 1e-3, self._rpdo_late)

    # --- watchdogs ------------------------------------------------------------------------------------------------

    def _on_consumer_heartbeat(self, entry):
        producer, milliseconds = entry >> 16 & 0xFF, entry & 0xFFFF
        self._stop_timer("heartbeat")
        self._watched = (producer, milliseconds * 1e-3) if milliseconds else None

    def _abort_option(self):
        """6007h; a drive without it takes the loss of its master for a fault."""
        return self._value(0x6007) if self.objects.has(0x6007) else 1

    def armed(self):
        """True if a watchdog would brake this drive now."""
        return "heartbeat" in self._timers and self._abort_option() != 0 or "rpdo" in self._timers

    def _heartbeat_lost(self):
        self.emergency(HEARTBEAT_LOST, GENERIC | COMMUNICATION)
        reactions = {1: Power.FAULT, 2: Power.SWITCH_ON_DISABLED, 3: Power.SWITCH_ON_DISABLED}
        self._enter(reactions.get(self._abort_option(), self.state))

    def _rpdo_late(self):
        self.emergency(RPDO_TIMEOUT, GENERIC | COMMUNICATION)
        self._enter(Power.FAULT)

    def emergency(self, code, register):
        self.seen.emergencies.append(code)
        self.node.emcy.set(code, register)

    # --- timers ---------------------------------------------------------------------------------------------------

    def _start_timer(self, name, delay, act):
        self._stop_timer(name)

        def due():
            del self._timers[name]
            act()

        self._timers[name] = self._bus.add(delay, due)

    def _stop_timer(self, name):
        if name in self._timers:
            self._bus.cancel(self._timers.pop(name))
