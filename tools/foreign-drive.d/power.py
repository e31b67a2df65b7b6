"""The power state machine of CiA 402-2 as the standard draws it: states, their statuswords, and where a controlword leads."""

import enum


class Power(enum.Enum):
    """A state; its value is what the statusword's bits 0-3, 5 and 6 say."""

    NOT_READY_TO_SWITCH_ON = 0x00
    SWITCH_ON_DISABLED = 0x40
    READY_TO_SWITCH_ON = 0x21
    SWITCHED_ON = 0x23
    OPERATION_ENABLED = 0x27
    QUICK_STOP_ACTIVE = 0x07
    FAULT = 0x08

    def statusword(self):
        VOLTAGE_ENABLED, REMOTE, FOLLOWS_TARGET = 1 << 4, 1 << 9, 1 << 12
        follows = FOLLOWS_TARGET if self is Power.OPERATION_ENABLED else 0
        return self.value | VOLTAGE_ENABLED | REMOTE | follows


class Command(enum.Enum):
    DISABLE_VOLTAGE = enum.auto()
    QUICK_STOP = enum.auto()
    SHUTDOWN = enum.auto()
    SWITCH_ON = enum.auto()
    ENABLE_OPERATION = enum.auto()


FAULT_RESET = 1 << 7


def command(controlword):
    """What bits 0 to 3 say; bit 7, the fault reset, counts only when it rises."""
    switch_on, voltage, no_quick_stop, enable = (bool(controlword >> bit & 1) for bit in range(4))
    if not voltage:
        return Command.DISABLE_VOLTAGE
    if not no_quick_stop:
        return Command.QUICK_STOP
    if not switch_on:
        return Command.SHUTDOWN
    return Command.ENABLE_OPERATION if enable else Command.SWITCH_ON


def after(state, order, quick_stop_stays):
    """The state that `order` leads to; `quick_stop_stays` as 605Ah says."""
    quick_stop = Power.QUICK_STOP_ACTIVE if quick_stop_stays else Power.SWITCH_ON_DISABLED
    table = {
        Power.SWITCH_ON_DISABLED: {Command.SHUTDOWN: Power.READY_TO_SWITCH_ON},
        Power.READY_TO_SWITCH_ON: {
            Command.SWITCH_ON: Power.SWITCHED_ON,
            Command.ENABLE_OPERATION: Power.OPERATION_ENABLED,
            Command.QUICK_STOP: Power.SWITCH_ON_DISABLED,
            Command.DISABLE_VOLTAGE: Power.SWITCH_ON_DISABLED,
        },
        Power.SWITCHED_ON: {
            Command.ENABLE_OPERATION: Power.OPERATION_ENABLED,
            Command.SHUTDOWN: Power.READY_TO_SWITCH_ON,
            Command.QUICK_STOP: Power.SWITCH_ON_DISABLED,
            Command.DISABLE_VOLTAGE: Power.SWITCH_ON_DISABLED,
        },
        Power.OPERATION_ENABLED: {
            Command.SWITCH_ON: Power.SWITCHED_ON,
            Command.SHUTDOWN: Power.READY_TO_SWITCH_ON,
            Command.QUICK_STOP: quick_stop,
            Command.DISABLE_VOLTAGE: Power.SWITCH_ON_DISABLED,
        },
        Power.QUICK_STOP_ACTIVE: {
            Command.ENABLE_OPERATION: Power.OPERATION_ENABLED,
            Command.DISABLE_VOLTAGE: Power.SWITCH_ON_DISABLED,
        },
    }
    return table.get(state, {}).get(order, state)
