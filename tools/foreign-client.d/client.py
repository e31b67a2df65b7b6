"""A CANopen master that is not ours, against the emulated drives of `uarm plant`.

python-canopen, which shares no code with uarm, reads crates/uarm-io/wire/uarm-drive.eds and boots, configures, enables, moves and
reads the drives. Each check prints one line; the last line counts them. Usage: client.py EDS
"""

import logging
import sys
import threading
import time

import canopen

INTERFACE = "vcan0"
NODES = (1, 2, 3)
MOVED_NODE = 2
PATIENCE = 10.0  # seconds; generous, an answer takes milliseconds
SYNC_PERIOD = 0.005  # seconds
CYCLIC_SYNCHRONOUS_TORQUE = 10
EVERY_SYNC = 1  # transmission types, CiA 301 tables 70 and 72
EVENT_DRIVEN = 255
READ_ONLY = 0x06010002  # SDO abort codes, CiA 301 table 22
NO_SUCH_OBJECT = 0x06020000

passed = 0


def check(what, holds, found=""):
    """Counts a check that holds; ends the program with one that does not."""
    global passed
    if not holds:
        print(f"FAILED {what}: {found}")
        print(f"test result: FAILED. {passed} passed; 1 failed")
        sys.exit(1)
    passed += 1
    print(f"ok     {what}{f': {found}' if found != '' else ''}")


def expect_abort(what, code, access):
    try:
        access()
    except canopen.SdoAbortedError as abort:
        check(what, abort.code == code, f"abort code {abort.code:08X}h")
    else:
        check(what, False, "the drive did not abort")


def boot(node):
    # wait_for_bootup() of the library begins to listen after the command, and misses a drive that answers at once.
    booted = threading.Event()
    node.nmt.add_heartbeat_callback(lambda state: booted.set() if state == 0 else None)
    node.nmt.state = "RESET"
    check(f"node {node.id} boots", booted.wait(PATIENCE))
    node.sdo[0x1017].raw = 20
    state = node.nmt.wait_for_heartbeat(PATIENCE)
    check(f"node {node.id} sends heartbeats", state == "PRE-OPERATIONAL", state)


def read_identity(node):
    device_type = node.sdo[0x1000].raw
    check(f"node {node.id} is a drive", device_type & 0xFFFF == 402, f"device type {device_type:08X}h")
    check(f"node {node.id} knows its encoder", node.sdo[0x608F][1].raw > 0, node.sdo[0x608F][1].raw)
    check(f"node {node.id} knows its rated torque", node.sdo[0x6076].raw > 0, f"{node.sdo[0x6076].raw} mN m")
    expect_abort(f"node {node.id} refuses to write a statusword", READ_ONLY, lambda: node.sdo.download(0x6041, 0, b"\0\0"))
    expect_abort(f"node {node.id} refuses an object it has not", NO_SUCH_OBJECT, lambda: node.sdo.upload(0x2FFF, 0))


def configure(node):
    node.op_mode = "CYCLIC SYNCHRONOUS TORQUE"
    mode = node.sdo[0x6061].raw
    check(f"node {node.id} is in cyclic synchronous torque", mode == CYCLIC_SYNCHRONOUS_TORQUE, mode)
    node.tpdo.read()
    node.rpdo.read()
    map_pdo(node.tpdo[1], EVERY_SYNC, (0x6041, 0x6064))
    map_pdo(node.rpdo[1], EVENT_DRIVEN, (0x6040, 0x6071))
    # What was written is read back from the drive, not from the client's memory.
    mapped = [node.sdo[0x1A00][k].raw for k in range(1, node.sdo[0x1A00][0].raw + 1)]
    check(f"node {node.id} keeps its PDO mapping", mapped == [0x60410010, 0x60640020], [f"{entry:08X}h" for entry in mapped])


def map_pdo(pdo, transmission_type, indices):
    pdo.clear()
    for index in indices:
        pdo.add_variable(index)
    pdo.trans_type = transmission_type
    pdo.enabled = True
    pdo.save()


def enable(network, nodes):
    for node in nodes:
        node.nmt.state = "OPERATIONAL"
        node.nmt.wait_for_heartbeat(PATIENCE)
        node.setup_402_state_machine(read_pdos=False)
    network.sync.start(SYNC_PERIOD)
    for node in nodes:
        node.rpdo[1][0x6071].raw = 0
        node.state = "OPERATION ENABLED"
        check(f"node {node.id} is enabled", node.state == "OPERATION ENABLED", node.state)


def wait_for_sync(node):
    check_time = node.tpdo[1].wait_for_reception(PATIENCE)
    if check_time is None:
        check(f"node {node.id} answers SYNC", False, "no TPDO1")


def move(network, node):
    wait_for_sync(node)
    start = node.tpdo[1][0x6064].raw
    node.rpdo[1][0x6071].raw = 200  # per mille
    node.rpdo[1].transmit()
    end = time.monotonic() + PATIENCE
    while node.tpdo[1][0x6064].raw - start < 100 and time.monotonic() < end:
        wait_for_sync(node)
    moved = node.tpdo[1][0x6064].raw - start
    check(f"node {node.id} moves with its torque", moved >= 100, f"{moved} counts")
    network.sync.stop()
    time.sleep(10 * SYNC_PERIOD)
    # Without SYNC the robot in lockstep stands still, so that both ways of reading must agree.
    latched, read = node.tpdo[1][0x6064].raw, node.sdo[0x6064].raw
    check(f"node {node.id} gives one position by PDO and SDO", latched == read, f"{latched} and {read} counts")
    network.sync.start(SYNC_PERIOD)


def disable(nodes):
    for node in nodes:
        node.rpdo[1][0x6071].raw = 0
        node.state = "SWITCH ON DISABLED"
        check(f"node {node.id} is disabled", node.state == "SWITCH ON DISABLED", node.state)
    before = [node.sdo[0x6064].raw for node in nodes]
    for _ in range(20):
        wait_for_sync(nodes[0])
    after = [node.sdo[0x6064].raw for node in nodes]
    check("brakes hold the joints", before == after, f"{before} and {after} counts")


def main():
    logging.basicConfig(level=logging.ERROR)
    with canopen.Network() as network:
        network.connect(interface="socketcan", channel=INTERFACE)
        nodes = [network.add_node(canopen.BaseNode402(node, sys.argv[1])) for node in NODES]
        for step in (boot, read_identity, configure):
            for node in nodes:
                step(node)
        enable(network, nodes)
        move(network, next(node for node in nodes if node.id == MOVED_NODE))
        disable(nodes)
        network.sync.stop()
    print(f"test result: ok. {passed} passed; 0 failed")


main()
