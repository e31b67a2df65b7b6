"""One CAN socket and one timetable for all nodes of this process, served by one thread.

durand asks for a network and a scheduler and brings some that run threads of their own; these do not, so that what the drives do
depends on the frames and on nothing else.
"""

import contextlib
import sched
import select
import socket
import struct
import time

from durand.network import NetworkABC
from durand.scheduler import AbstractScheduler, set_scheduler

FRAME = struct.Struct("<IB3x8s")  # struct can_frame
ERROR_OR_REMOTE_OR_EXTENDED = 0xE0000000


class Bus(AbstractScheduler):
    """Frames come in order, and each goes to all ports before the next is read."""

    def __init__(self, interface):
        self._socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self._socket.bind((interface,))
        self._timetable = sched.scheduler(time.monotonic, time.sleep)
        self.ports = []
        set_scheduler(self)

    def send(self, identifier, data):
        self._socket.send(FRAME.pack(identifier, len(data), bytes(data)))

    def turn(self, longest):
        """Serves what is due, and waits for a frame for `longest` seconds at most."""
        next_timer = self._timetable.run(blocking=False)
        wait = longest if next_timer is None else min(longest, max(next_timer, 0))
        if not select.select([self._socket], [], [], wait)[0]:
            return
        identifier, length, data = FRAME.unpack(self._socket.recv(FRAME.size))
        if not identifier & ERROR_OR_REMOTE_OR_EXTENDED:
            for port in list(self.ports):
                port.receive(identifier, data[:length])

    # What durand wants of a scheduler.

    def add(self, delay, callback, args=(), kwargs=None):
        return self._timetable.enter(delay, 0, callback, args, kwargs or {})

    def cancel(self, entry):
        with contextlib.suppress(ValueError):  # it has been served
            self._timetable.cancel(entry)

    @property
    def lock(self):
        return contextlib.nullcontext()


class Port(NetworkABC):
    """Where one node is connected to the bus.

    `tap(identifier, data)` sees each frame before the node does, and keeps it from the node by returning True;
    `sent(identifier)` is told what the node sends.
    """

    def __init__(self, bus, tap, sent):
        self._bus, self._tap, self._sent = bus, tap, sent
        self._subscriptions = {}
        bus.ports.append(self)

    def receive(self, identifier, data):
        if not self._tap(identifier, data) and identifier in self._subscriptions:
            self._subscriptions[identifier](identifier, data)

    def unplug(self):
        self._bus.ports.remove(self)

    # What durand wants of a network.

    def add_subscription(self, cob_id, callback):
        self._subscriptions[cob_id] = callback

    def remove_subscription(self, cob_id, callback=None):
        self._subscriptions.pop(cob_id, None)

    def send(self, cob_id, msg):
        self._sent(cob_id & 0x7FF)
        self._bus.send(cob_id & 0x7FF, msg)
