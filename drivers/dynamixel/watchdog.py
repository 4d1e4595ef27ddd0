"""Proof that the servos' own watchdog stops them: hold still, fall silent, look.

This needs torque on, at the measured positions; nothing is told to move.
"""

from dataclasses import dataclass

from drivers.dynamixel.bus import ServoBus

TRIPPED = -1
# A servo may look at its watchdog a little late.
MARGIN_S = 0.1


@dataclass(frozen=True, slots=True)
class WatchdogProof:
    """What the proof found.

    Attributes:
        tripped: Legs whose watchdog tripped, as it should.
        asleep: Legs whose watchdog did not.
        silent_s: How long the bus was silent [s].
        torque_off: Whether every servo confirmed that its torque is off again.
    """

    tripped: tuple[str, ...]
    asleep: tuple[str, ...]
    silent_s: float
    torque_off: bool


def prove_watchdog(bus: ServoBus) -> WatchdogProof:
    """Switch torque on where the shafts stand, say nothing for longer than the watchdog, look.

    Args:
        bus: The bus, connected and configured; torque is off again afterwards, whatever happens.

    Raises:
        BusError: Torque does not go on, or a servo does not answer.
    """
    tripped: list[str] = []
    asleep: list[str] = []
    silent_s = bus.settings.watchdog_s + MARGIN_S
    off = False
    try:
        bus.torque_on()
        bus.clock.sleep_until_ns(bus.clock.now_ns() + round(silent_s * 1e9))
        for servo in bus.servos():
            state = servo.read("bus_watchdog")
            (tripped if state == TRIPPED else asleep).append(servo.leg)
    finally:
        off = bus.torque_off()
    return WatchdogProof(tuple(tripped), tuple(asleep), silent_s, off)
