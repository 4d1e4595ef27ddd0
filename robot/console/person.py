"""What a program asks of the person beside the robot: may I, please do, what do you see.

``TerminalPerson`` asks on a terminal. A virtual robot brings a person of its own (``robot.virtual.hung``).
Torque is off whenever a question waits for its answer; what a hand does while shafts hold or a sensor is
read is only announced, and noticed by itself.
"""

import enum
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

# What eyes may see of a leg that was turned.
FORWARD, BACKWARD = "forward", "backward"
NOTHING = "none"


class Consent(enum.Enum):
    """Answer to "may I?"."""

    YES = "y"
    SKIP = "s"
    QUIT = "q"


class Hand(enum.Enum):
    """What hands are asked to do."""

    SET_MID_STANCE = enum.auto()  # turn every shaft to mid-stance
    TURN_ONCE = enum.auto()  # turn one shaft by a whole turn
    PULL_CABLE = enum.auto()
    PLUG_CABLE = enum.auto()
    PRESS_UP = enum.auto()
    PRESS_FORWARD = enum.auto()
    PRESS_LEFT = enum.auto()
    LET_GO = enum.auto()
    PUT_DOWN = enum.auto()  # on the floor, room in front of it
    WATCH = enum.auto()  # hands off, look


class Sight(enum.Enum):
    """What eyes are asked for."""

    WHICH_LEG = enum.auto()  # which leg moved
    WHICH_DIRECTION = enum.auto()  # which way its foot moved


@dataclass(frozen=True, slots=True)
class Work:
    """Something to do by hand.

    Attributes:
        hand: What.
        words: The same for a person.
        leg: Name of the leg, empty for none.
    """

    hand: Hand
    words: str
    leg: str = ""


class Person(Protocol):
    """Whoever stands beside the robot."""

    def allows(self, question: str, *, moves: bool) -> Consent:
        """Answer whether a step may be done; ``moves`` says that it needs torque."""
        ...

    def does(self, work: Work) -> None:
        """Do something, and come back when it is done."""
        ...

    def begins(self, work: Work) -> None:
        """Hear what to do next, while the program goes on and watches."""
        ...

    def meanwhile(self, elapsed_s: float) -> None:
        """Called again and again while the program watches; must not wait."""
        ...

    def sees(self, sight: Sight, question: str, choices: Sequence[str]) -> str:
        """Return one of the choices."""
        ...


class TerminalPerson:
    """A person at a terminal.

    Args:
        yes: Whether steps in which nothing moves are done without a question.
        hands: On a virtual robot, whoever does by hand what this person is asked to do, and sees it.
    """

    def __init__(self, *, yes: bool, hands: Person | None = None) -> None:
        self._yes = yes
        self._hands = hands

    def allows(self, question: str, *, moves: bool) -> Consent:
        """Ask; without a terminal nothing that moves is done."""
        if self._yes and not moves:
            return Consent.YES
        if not sys.stdin.isatty():
            print("skipped: nobody is there to be asked" + ("" if moves else "; add --yes"))
            return Consent.SKIP
        answers = {"y": Consent.YES, "yes": Consent.YES, "s": Consent.SKIP, "skip": Consent.SKIP,
                   "q": Consent.QUIT, "quit": Consent.QUIT}  # fmt: skip
        while True:
            word = self._input(f"{question} [y / skip / quit] ").lower()
            if word in answers:
                return answers[word]
            print("please answer y, skip or quit")

    def does(self, work: Work) -> None:
        """Ask for it, and wait for the return key."""
        self._input(f"  > {work.words}, then press return: ")
        if self._hands is not None:
            self._hands.does(work)

    def begins(self, work: Work) -> None:
        """Say it."""
        print(f"  > {work.words}", flush=True)
        if self._hands is not None:
            self._hands.begins(work)

    def meanwhile(self, elapsed_s: float) -> None:
        """Nothing is to be done: the person is at it."""
        if self._hands is not None:
            self._hands.meanwhile(elapsed_s)

    def sees(self, sight: Sight, question: str, choices: Sequence[str]) -> str:
        """Ask until one of the choices is typed."""
        if self._hands is not None:
            print(f"  (you see: {self._hands.sees(sight, question, choices)})")
        known = {choice.lower(): choice for choice in choices}
        while True:
            word = self._input(f"  > {question} [{' / '.join(choices)}] ").lower()
            if word in known:
                return known[word]
            print(f"  please answer one of: {', '.join(choices)}")

    @staticmethod
    def _input(prompt: str) -> str:
        try:
            return input(prompt).strip()
        except EOFError:  # the terminal went away
            raise KeyboardInterrupt from None
