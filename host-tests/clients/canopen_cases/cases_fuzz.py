"""Random frames: invalid frames change nothing, and no frame stops the sensor."""

import random

from gemac.harness import EXTENDED

from . import protocol as p
from .runner import Context
from .session import Session, initiate

SEED = 2101
COUNT = 2000


def invalid_frames(context: Context) -> None:
    """2000 frames that must change nothing."""
    generator = random.Random(SEED)
    for way, state in ((p.ENTER_PRE_OPERATIONAL, p.PRE_OPERATIONAL), (p.START, p.OPERATIONAL)):
        with context.session() as session:
            before = session.snapshot()
            session.nmt(way)
            for number in range(COUNT):
                send_invalid(session, generator)
                if number % 50 == 0:
                    session.tester.collect_until_quiet(0.01)
            session.resynchronise()
            session.check_state(f"state {state}: {COUNT} invalid frames, then the state", state)
            session.report.equal(f"state {state}: {COUNT} invalid frames, then all values", before, session.snapshot())
            session.report.equal(f"state {state}: no error", (0, 0), (session.get(0x1001), session.get(0x1003)))


def send_invalid(session: Session, generator: random.Random) -> None:
    """Sends a frame that must change nothing."""
    kind = generator.randrange(8)
    data = generator.randbytes(8)
    length = generator.randrange(9)
    mine = p.SDO_REQUEST + session.node
    if kind == 0:
        identifier = generator.randrange(1, 0x800)
        if identifier not in (mine, p.SYNC):
            session.send(identifier, data[:length])
    elif kind == 1:
        session.send(EXTENDED | generator.choice([generator.randrange(1 << 29), 0, p.SYNC, mine]), data[:length])
    elif kind == 2:
        guarded = (p.ERROR_CONTROL + session.node, p.TPDO0 + session.node, p.TPDO1 + session.node)
        identifier = generator.randrange(0x800)
        if identifier not in guarded:
            session.send(identifier, remote=True, dlc=length)
    elif kind == 3:
        session.send(p.NMT, bytes([data[0], generator.choice([n for n in range(1, 256) if n != session.node])]))
    elif kind == 4:
        command = generator.choice([c for c in range(256) if c not in (p.START, p.STOP, 0x80, 0x81, 0x82)])
        session.send(p.NMT, bytes([command, generator.choice([0, session.node])]))
    elif kind == 5:
        session.send(mine, data[: generator.randrange(8)])
    elif kind == 6:
        # Uploads, segments without a download, blocks and aborts.
        command = generator.choice([c for c in range(256) if c >> 5 != 1])
        session.send(mine, bytes([command]) + data[1:])
    else:
        index = generator.choice([i for i in range(0x1000, 0x7000) if i not in p.LISTED])
        session.send(mine, initiate(0x23, index, data[0], data[1:5]))


def random_frames(context: Context) -> None:
    """2000 frames of any kind; then the factory reset restores all values."""
    generator = random.Random(SEED + 1)
    with context.session(store=context.store()) as session:
        for _ in range(COUNT):
            send_random(session, generator)
        session.nmt(p.ENTER_PRE_OPERATIONAL, 0)
        session.resynchronise()
        running = session.sensor.running
        session.report.verdict(running, f"{COUNT} random frames: the process", "runs", "runs" if running else "ended")
        session.put(0x1017, 0, 0)
        session.collect(0.1)
        session.report.equal("the sensor still answers", 0x4019A, session.get(0x1000))
        session.put(0x207F, 0, 1)
        session.download(0x1011, 1, p.LOAD)
        session.report.equal("reset: boot-up", True, session.reset())
        expected = {str(entry): entry.expected().hex() for entry in p.STEADY if entry.expected() is not None}
        session.put(0x6000, 0, 10)
        found = session.snapshot()
        differ = {key: found[key] for key, value in expected.items() if found[key] != value}
        session.report.equal("all values are the factory values", {}, differ)


def send_random(session: Session, generator: random.Random) -> None:
    """Sends any frame except those that change node-ID or bit rate or reset the sensor."""
    length = generator.randrange(9)
    data = generator.randbytes(length)
    kind = generator.randrange(4)
    if kind == 0:
        session.send(generator.randrange(0x800), data, remote=False)
    elif kind == 1:
        session.send(generator.randrange(0x800), remote=True, dlc=length)
    elif kind == 2:
        entry = generator.choice(p.OBJECTS)
        if entry.index not in (0x2000, 0x2001, 0x2002, 0x3000):
            command = generator.choice([0x2F, 0x2B, 0x27, 0x23, 0x22, 0x21, 0x20, 0x40])
            session.send(p.SDO_REQUEST + session.node, initiate(command, entry.index, entry.sub, generator.randbytes(4)))
    else:
        session.send(p.SDO_REQUEST + session.node, generator.randbytes(8))


GROUPS = (invalid_frames, random_frames)
