"""Random frames: invalid frames change nothing, and no frame stops the sensor."""

import random

from gemac.harness import EXTENDED

from . import protocol as p
from .runner import Context
from .session import Session

SEED = 80360
COUNT = 2000


def invalid_frames(context: Context) -> None:
    """Frames that must change nothing, in three states."""
    generator = random.Random(SEED)
    with context.session() as session:
        for choice in (0x01, 0x03, 0x53):
            session.connect(choice)
            for instance, bits in ((p.C_POLL, 0x02), (p.C_COS, 0x30)):
                if choice & bits:
                    session.rate(instance, 0)
            before = snapshot(session)
            for number in range(COUNT):
                send_invalid(session, generator)
                if number % 50 == 0:
                    session.tester.collect_until_quiet(0.01)
            settle(session)
            session.report.equal(f"choice {choice:02X}h, {COUNT} invalid frames: nothing has changed", before, snapshot(session))
            session.report.equal(f"choice {choice:02X}h: release", "0ACC", session.release(choice))


def snapshot(session: Session) -> dict[str, object]:
    """All that can be read and is constant."""
    found = session.angles()
    for kind, instance, attributes in (
        (1, 1, range(1, 8)),
        (3, 1, range(1, 6)),
        (5, 1, (1, 4, 5, 7, 8, 9, 12)),
        (5, 2, (1, 9)),
        (5, 4, (1, 9)),
    ):
        found |= {f"{kind}/{instance}/{n}": session.get(kind, instance, n) for n in attributes}
    return found


def settle(session: Session) -> None:
    """Waits for the answers to all frames before, and drops them."""
    session.tester.collect_until_quiet(0.1)
    session.others.clear()


def send_invalid(session: Session, generator: random.Random) -> None:
    """Sends a frame that must change nothing."""
    kind = generator.randrange(8)
    data = generator.randbytes(8)
    length = generator.randrange(9)
    send = session.tester.send
    if kind == 0:
        mine = {session.id(message) for message in range(8)}
        identifier = generator.choice([n for n in range(0x800) if n not in mine])
        send(identifier, data[:length])
    elif kind == 1:
        identifier = generator.choice([generator.randrange(1 << 29), *(session.id(n) << 18 for n in range(8))])
        send(EXTENDED | identifier, data[:length])
    elif kind == 2:
        send(session.id(generator.randrange(8)), remote=True, dlc=length)
    elif kind == 3:
        # Of another master.
        header = generator.choice([n for n in range(64) if n != p.MASTER]) | generator.choice([0, 0x40, 0x80, 0xC0])
        session.send(p.EXPLICIT, f"{header:02X}{data[:length][1:].hex()}")
    elif kind == 4:
        # Responses and services that do not exist.
        service = generator.choice([n for n in range(256) if n not in (p.RESET, p.SET, p.ALLOCATE, p.RELEASE)])
        session.send(p.EXPLICIT, f"0A{service:02X}{data[:6].hex()}")
    elif kind == 5:
        # Sets of classes that do not exist, or with bytes too many.
        if generator.randrange(2):
            session.send(p.EXPLICIT, f"0A10{generator.choice([0, 6, 7, 0x64, 0xFE]):02X}{data[:5].hex()}")
        else:
            session.send(p.EXPLICIT, f"0A106501{data[0]:02X}{data[1:4].hex()}")
    elif kind == 6:
        # On the port: services that are refused, allocations of others.
        service = generator.choice([n for n in range(128) if n not in (p.ALLOCATE, p.RELEASE)])
        other = generator.choice([n for n in range(64) if n != p.MASTER])
        session.send(
            p.PORT,
            generator.choice(
                [
                    f"0A{service:02X}{data[:5].hex()}",
                    f"{other:02X}4B0301{data[0]:02X}{other:02X}",
                    f"{other:02X}4C0301{data[0]:02X}",
                ]
            ),
        )
    else:
        # Fragments without a first one; a poll with data.
        if generator.randrange(2):
            session.send(
                p.EXPLICIT, f"8A{generator.choice([0x40, 0x80, 0xC0]) | generator.randrange(64):02X}{data[:length][2:].hex()}"
            )
        else:
            session.send(p.POLL, data[: max(1, length)].hex())


def random_frames(context: Context) -> None:
    """Frames of any kind; then a factory reset restores all values."""
    generator = random.Random(SEED + 1)
    with context.session(store=context.store()) as session:
        session.connect(0x53, poll=0, cos=100)
        for number in range(2 * COUNT):
            send_random(session, generator)
            if number % 100 == 0:
                session.tester.collect_until_quiet(0.01, 0.2)
        settle_random(session)
        session.report.equal("the process runs", True, session.sensor.running)
        session.report.equal("the sensor still answers", True, session.wait_online() is not None)
        session.power_cycle()
        session.connect()
        session.report.equal("still its identity", session.subject.name.encode().hex().upper(), session.get(p.IDENTITY, 1, 7)[2:])
        session.expect("factory reset", "0A05010101", "0A85")
        session.sleep(0.05)
        session.wait_online()
        session.connect(3, poll=0)
        expected = {str(entry): entry.factory for entry in p.ATTRIBUTES if entry.factory is not None}
        session.report.equal("all values are the factory values", expected, session.angles())
        session.sleep(0.3)
        session.report.equal("poll", session.words(session.subject.long), session.poll())


def settle_random(session: Session) -> None:
    """Ends cyclic messages and drops all answers."""
    session.tester.collect_until_quiet(0.1, 1.0)
    session.others.clear()


def send_random(session: Session, generator: random.Random) -> None:
    """Sends any frame except those that change MAC ID or baud rate, reset the sensor or put it off-line."""
    length = generator.randrange(9)
    data = generator.randbytes(length)
    kind = generator.randrange(5)
    send = session.tester.send
    if kind == 0:
        identifier = generator.choice([n for n in range(0x800) if n not in (session.id(p.DUPLICATE), session.id(p.EXPLICIT))])
        send(identifier, data)
    elif kind == 1:
        send(generator.randrange(0x800), remote=True, dlc=length)
    elif kind == 2:
        attribute = generator.choice(p.ATTRIBUTES)
        value = generator.randbytes(min(3, generator.choice([attribute.size, 0, 1, 2, 3])))
        session.send(p.EXPLICIT, session.body(p.SET, p.ANGLE, 1, f"{attribute.id:02X}{value.hex()}"))
    elif kind == 3:
        choice = generator.choice([1, 3, 0x11, 0x51, 0x53, 0x23, generator.randrange(256)])
        service = generator.choice(["4B", "4C"])
        session.send(p.PORT, f"0A{service}0301{choice:02X}" + ("0A" if service == "4B" else ""))
    else:
        instance, attribute = generator.choice([1, 2, 4]), generator.choice([9, 12, 17])
        session.send(p.EXPLICIT, session.body(p.SET, p.CONNECTION, instance, f"{attribute:02X}{data[:2].hex()}"))


GROUPS = (invalid_frames, random_frames)
