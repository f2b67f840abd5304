"""A master that vanishes in each state: when another one can allocate everything."""

from . import protocol as p
from .cases_timeouts import LONG, timed
from .runner import Context
from .session import Refused, Session


def vanishes(context: Context, name: str, choice: int, expected: float | None, prepare) -> None:
    """A master that sends nothing more; the time until another one can allocate everything."""
    with context.session() as session:
        if session.allocate(choice) != "0ACB00":
            raise Refused(name)
        since = session.now()
        since = prepare(session) or since
        at = session.until_free((expected or 13) + 3, step=0.05)
        if expected is None:
            session.report.equal(f"{name}: never free", None, at)
        else:
            timed(session, f"{name}: free for another master", expected, since, at)
            session.expect("the new master is served", "0B0E030105", "0B8E010B")
            session.report.equal("no answer to a poll", None, session.poll(timeout=0.1))
            session.others.clear()
            session.report.equal("no production", [], [str(frame) for frame in session.produced(0.3)])


def vanishes_configuring(context: Context) -> None:
    """All connections allocated, no rate set: 10 s."""
    vanishes(context, "configuring", 0x13, LONG, lambda session: None)


def vanishes_polling(context: Context) -> None:
    """Poll established: both run out."""

    def prepare(session: Session) -> float:
        session.rate(p.C_POLL, 1000)
        asked = session.now()
        for _ in range(3):
            session.poll()
            session.sleep(0.2)
        return asked

    vanishes(context, "polling", 0x03, LONG, prepare)


def vanishes_polling_slowly(context: Context) -> None:
    """The poll connection outlives the explicit one."""

    def prepare(session: Session) -> float:
        session.rate(p.C_POLL, 600)
        session.rate(p.C_EXPLICIT, 100)
        session.poll()
        return session.now()

    vanishes(context, "polling, short explicit rate", 0x03, 2.4, prepare)


def vanishes_unpolled(context: Context) -> None:
    """Poll established but never polled, explicit gone early: the 10 s of the first poll."""

    def prepare(session: Session) -> float:
        session.rate(p.C_EXPLICIT, 500)
        session.rate(p.C_POLL, 100)
        return session.now()

    vanishes(context, "never polled", 0x03, LONG, prepare)


def vanishes_with_rate_zero(context: Context) -> None:
    """Explicit with rate 0 and poll configuring: never."""

    def prepare(session: Session) -> None:
        session.rate(p.C_EXPLICIT, 0)

    vanishes(context, "explicit rate 0", 0x03, None, prepare)


def vanishes_suppressed(context: Context) -> None:
    """COS that only produces: it goes on, and the owner stays."""

    def prepare(session: Session) -> None:
        session.rate(p.C_COS, 200)
        session.rate(p.C_EXPLICIT, 100)

    vanishes(context, "COS, acknowledge suppressed", 0x51, None, prepare)


def vanishes_fragmented(context: Context) -> None:
    """In the middle of a fragmented request."""

    def prepare(session: Session) -> float:
        session.ask("8A00106501")
        return session.now()

    vanishes(context, "fragmented request", 0x01, LONG, prepare)


GROUPS = (
    vanishes_configuring,
    vanishes_polling,
    vanishes_polling_slowly,
    vanishes_unpolled,
    vanishes_with_rate_zero,
    vanishes_suppressed,
    vanishes_fragmented,
)
