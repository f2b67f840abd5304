"""Life guarding, for checks that need an error (section 11.1.1)."""

from gemac.harness import Frame

from . import protocol as p
from .session import Session

GUARD_TIME = 10  # ms


def lose_master(session: Session, set_up: bool = True) -> Frame | None:
    """Guards once and then no more; returns the emergency message of the life guarding time-out."""
    if set_up:
        session.put(0x100C, 0, GUARD_TIME)
        session.put(0x100D, 0, 2)
    session.guard()
    return session.wait(lambda frame: frame.id == p.EMCY + session.node and frame.data[:2] == p.encode(p.LIFE_GUARD, 2))
