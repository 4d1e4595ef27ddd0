"""The thirteen steps of the first day, in their order."""

from collections.abc import Callable
from dataclasses import dataclass

from robot.bringup.first_day.day import Day
from robot.bringup.first_day.holding import cable, legs, torque, watchdog
from robot.bringup.first_day.listening import ids, listen
from robot.bringup.first_day.memory import registers
from robot.bringup.first_day.restarts import loop, reboots
from robot.bringup.first_day.sensing import console, feet
from robot.bringup.first_day.walking import floor_walk, hung_walk


@dataclass(frozen=True, slots=True)
class DayStep:
    """One step.

    Attributes:
        number: From 1.
        key: Short name.
        title: What is found out.
        words: What it does, for the person who is asked.
        moves: Whether it needs torque.
        run: Does it.
        needs: Numbers of steps that must have passed with this robot file.
        own_log: Whether it writes the log itself, ticks and bytes.
        writes: Whether it changes anything in a device: nothing is done with --yes alone.
        maps: Whether it proves ids, signs and zeros: it counts only while the robot file has the same.
    """

    number: int
    key: str
    title: str
    words: str
    moves: bool
    run: Callable[[Day], None]
    needs: tuple[int, ...] = ()
    own_log: bool = False
    writes: bool = False
    maps: bool = False


STEPS = (
    DayStep(1, "listen", "who talks unasked",
         "Opens both devices and sends nothing for 3 s.", False, listen),
    DayStep(2, "ids", "who answers to which id",
         "Pings everybody, each id of the robot file and one that nobody has; times the answers.",
         False, ids),
    DayStep(3, "registers", "what the servos keep",
         "Reads every register of each servo and compares it with the robot file and the factory; "
         "reads the gaps between them.", False, registers),
    DayStep(4, "legs", "each leg by 10 degrees",
         "TURNS each leg by 10 degrees and back, one at a time, feet in the air; asks what you saw.",
         True, legs, (2,), maps=True),
    DayStep(5, "torque", "torque on and off",
         "HOLDS all legs where they are for a second; compares goal, position and gains before, "
         "with and after torque.", True, torque, (2, 3)),
    DayStep(6, "watchdog", "the servos' own stop",
         "HOLDS twice: once it falls silent until every servo has stopped by itself, once it speaks to "
         "one servo only.", True, watchdog, (2, 3)),
    DayStep(7, "reboot", "how long a servo is away",
         "Reboots each servo several times, torque off; one shaft is turned by hand before.",
         False, reboots, (2,), writes=True),
    DayStep(8, "loop", "how late this computer is",
         "Runs the loop without torque, 10 minutes unless --seconds says otherwise.",
         False, loop, (2,), own_log=True),
    DayStep(9, "cable", "the cable pulled while it holds",
         "HOLDS; you pull the USB cable and plug it in again. The servos must stop by themselves.",
         True, cable, (5, 6)),
    DayStep(10, "feet", "each foot pressed",
         "Reads the force unit, torque off; you press each foot up, forward and to the robot's left.",
         False, feet, writes=True),
    DayStep(11, "console", "the force unit's settings",
         "Reads VERSIONS, RATE, XPWR, FILTER, BIAS and CAL; sets nothing.", False, console),
    DayStep(12, "hung", "one cycle in the air",
         "WALKS one cycle of the first gait with the feet in the air, at the gait's slowest.",
         True, hung_walk, (4, 5, 6), own_log=True),
    DayStep(13, "floor", "one cycle on the floor",
         "You put the robot on the FLOOR; it WALKS one cycle of the first gait there.",
         True, floor_walk, (4, 5, 6, 10, 12), own_log=True),
)  # fmt: skip
