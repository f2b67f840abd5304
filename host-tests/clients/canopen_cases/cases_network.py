"""Boot-up and NMT (sections 7.2, 7.3 and 11.2; CiA 301, 7.3.2)."""

from gemac.harness import Frame, EXTENDED

from . import protocol as p
from .runner import Context
from .session import Session, initiate

DEVICE_TYPE = initiate(0x40, 0x1000, 0)
# Every command and the state after it, from any state. After a reset the sensor sends the boot-up message.
COMMANDS = {
    p.START: p.OPERATIONAL,
    p.STOP: p.STOPPED,
    p.ENTER_PRE_OPERATIONAL: p.PRE_OPERATIONAL,
    p.RESET_NODE: p.PRE_OPERATIONAL,
    p.RESET_COMMUNICATION: p.PRE_OPERATIONAL,
}
RESETS = (p.RESET_NODE, p.RESET_COMMUNICATION)
WAYS = {p.START: p.OPERATIONAL, p.STOP: p.STOPPED, p.ENTER_PRE_OPERATIONAL: p.PRE_OPERATIONAL}


def boot_up(context: Context) -> None:
    """The first frame and the state after power-up and resets."""
    with context.session() as session:
        session.report.equal("power-up: the boot-up message is the first frame", [], [str(f) for f in session.others])
        session.quiet("power-up: no other frames", 0.5)
        session.check_state("power-up: pre-operational", p.PRE_OPERATIONAL)
        for command, name in ((p.RESET_NODE, "reset node"), (p.RESET_COMMUNICATION, "reset communication")):
            session.nmt(command)
            frames = [str(frame) for frame in session.collect(0.5)]
            session.report.equal(f"{name}: one boot-up message", [str(Frame(0x70A, b"\x00"))], frames)
            session.check_state(f"{name}: pre-operational", p.PRE_OPERATIONAL)
            session.nmt(command, 0)
            session.report.equal(f"{name} of all nodes: boot-up", True, session.wait_boot_up())


def transitions(context: Context) -> None:
    """Every command in every state, to the own node-ID and to all nodes."""
    with context.session() as session:
        for way, before in WAYS.items():
            for command, after in COMMANDS.items():
                for node in (session.node, 0):
                    session.nmt(way)
                    name = f"state {before}, command {command}, node {node}"
                    session.nmt(command, node)
                    if command in RESETS and not session.wait_boot_up():
                        session.report.verdict(False, name, "boot-up", "none")
                    session.check_state(name, after)


def ignored_commands(context: Context) -> None:
    """Unknown commands, commands for other nodes, and frames that are not NMT frames change nothing in any state."""
    with context.session() as session:
        for way, state in WAYS.items():
            session.nmt(way)
            for command in (0x00, 0x03, 0x04, 0x05, 0x7F, 0x83, 0xFF):
                session.nmt(command)
                session.nmt(command, 0)
            session.check_state(f"state {state}: unknown commands", state)
            for command in COMMANDS:
                for node in (1, session.node + 1, 127, 128 + session.node, 255):
                    session.nmt(command, node)
            session.check_state(f"state {state}: commands for other nodes", state)
            for command in COMMANDS:
                session.send(p.NMT)
                session.send(p.NMT, bytes([command]))
                session.send(p.NMT | EXTENDED, bytes([command, session.node]))
                session.send(p.NMT, remote=True, dlc=2)
                session.send(p.NMT | EXTENDED, remote=True, dlc=2)
            session.check_state(f"state {state}: short, 29-bit and remote frames", state)
        session.quiet("none of them is answered")


def services(context: Context) -> None:
    """The services in each state (CiA 301, table 38)."""
    with context.session() as session:
        answers = {p.PRE_OPERATIONAL: True, p.OPERATIONAL: True, p.STOPPED: False}
        pdos = {p.PRE_OPERATIONAL: False, p.OPERATIONAL: True, p.STOPPED: False}
        for way, state in WAYS.items():
            session.nmt(way)
            session.check_state(f"state {state}: node guarding is answered", state)
            answer = session.sdo(DEVICE_TYPE, 0.3)
            session.report.equal(f"state {state}: SDO is answered", answers[state], answer is not None)
            session.send(p.SYNC)
            frames = session.collect(0.15, p.TPDO0)
            session.report.equal(f"state {state}: PDO after SYNC", pdos[state], len(frames) == 1)
            session.send(p.TPDO0 + session.node, remote=True, dlc=4)
            frames = session.collect(0.15, p.TPDO0)
            session.report.equal(f"state {state}: PDO after RTR", pdos[state], len(frames) == 1)
        session.nmt(p.ENTER_PRE_OPERATIONAL)
        session.put(0x1017, 0, 20)
        session.nmt(p.STOP)
        frames = session.collect(0.3, p.ERROR_CONTROL)
        beats = [frame for frame in frames if frame.data == bytes([p.STOPPED])]
        session.report.within("stopped: the heartbeat continues, frames in 0.3 s", 10, 17, len(beats))


def resets_restore(context: Context) -> None:
    """Reset communication restores the communication profile, reset node restores all objects."""
    with context.session() as session:
        def change() -> None:
            session.put(0x1800, 2, 7)
            session.put(0x2043, 0, 4)

        change()
        session.report.equal("reset communication: boot-up", True, session.reset(p.RESET_COMMUNICATION))
        session.reads("reset communication: 1800h:02h as saved", 0x1800, 2, 1)
        session.reads("reset communication: 2043h does not change", 0x2043, 0, 4)
        change()
        session.report.equal("reset node: boot-up", True, session.reset(p.RESET_NODE))
        session.reads("reset node: 1800h:02h as saved", 0x1800, 2, 1)
        session.reads("reset node: 2043h as saved", 0x2043, 0, 2)


def start_up(context: Context) -> None:
    """1F80h: slave, NMT start of all nodes, autostart (section 7.3, J4)."""
    for value, state, wanted in (
        (0, p.PRE_OPERATIONAL, []),
        (2, p.OPERATIONAL, [Frame(p.NMT, b"\x01\x00")]),
        (8, p.OPERATIONAL, []),
    ):
        with context.session(store=context.store(f"memory{value}")) as session:
            for refused in (1, 3, 4, 0xA, 0x80000000):
                if value == 0:
                    session.refused(f"1F80h = {refused}", p.RANGE, session.put, 0x1F80, 0, refused)
            session.accepted(f"1F80h = {value}", 0x1F80, 0, value)
            session.check_state(f"1F80h = {value}: no effect before the next start", p.PRE_OPERATIONAL)
            session.download(0x1010, 1, p.SAVE)
            session.power_cycle()
            frames = [frame for frame in session.others + session.collect(0.4) if frame.id == p.NMT]
            session.report.equal(f"1F80h = {value}: NMT frames at the start", wanted, frames)
            session.check_state(f"1F80h = {value}: state after power-up", state)
            session.nmt(p.ENTER_PRE_OPERATIONAL)
            session.check_state(f"1F80h = {value}: NMT commands still work", p.PRE_OPERATIONAL)
            started_all(session, value, state, wanted)


def started_all(session: Session, value: int, state: int, wanted: list[Frame]) -> None:
    """The same checks after reset node."""
    session.nmt(p.RESET_NODE)
    session.wait_boot_up()
    frames = [frame for frame in session.collect(0.4) if frame.id == p.NMT]
    session.report.equal(f"1F80h = {value}: NMT frames after reset node", wanted, frames)
    session.check_state(f"1F80h = {value}: state after reset node", state)


GROUPS = (boot_up, transitions, ignored_commands, services, resets_restore, start_up)
