"""Steps 4 to 6 and 9: one leg turned, torque on and off, the watchdog, the cable pulled while it holds."""

from collections.abc import Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass

import numpy as np

from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.checked_servo import CheckedServo
from drivers.dynamixel.image import GAINS, read_gains
from drivers.dynamixel.units import TICKS_PER_TURN
from drivers.dynamixel.unknowns import NUDGE_TICKS, gains_at_mode_change, goal_at_torque_on
from drivers.dynamixel.watchdog import TRIPPED, prove_watchdog
from gaits.plan import Hold
from model.errors import BusError, ConnectionLost
from robot.bringup.first_day.curve import turning_curves
from robot.bringup.first_day.day import Day
from robot.bringup.mapping.jog import MID_STANCE, Jog, jog_findings, jog_leg
from robot.bringup.mapping.motion import GatedShafts, JogTrack, limp_afterwards
from robot.bringup.preflight.finding import failed, passed, skipped, warned
from robot.console.person import Hand, Work

JOG_DEG = 10.0
HOLD_S = 1.0
# A shaft that is switched on where it stands moves by less.
JUMP_TICKS = 10
# Twice the watchdog's time: whoever hears nothing has tripped by then.
PING_FOR = 2.0
PING_PERIOD_NS = 20_000_000
CABLE_PATIENCE_S = 60.0
PLUG_LOOK_NS = 200_000_000
PLUG_TRIES = 100


def legs(day: Day) -> None:
    """Step 4: every leg in turn by ten degrees and back."""
    day.person.does(Work(Hand.SET_MID_STANCE, MID_STANCE))
    port = day.wires().port
    if not port.openPort():
        raise BusError(f"{port.name} cannot be opened", port=port.name)
    jogs: list[Jog] = []

    def keep(leg: str, track: JogTrack) -> None:
        day.curves.extend(turning_curves([leg], track.t_ns, track.angle_rad, track.goal_rad))

    with ExitStack() as stack:
        stack.callback(port.closePort)
        for leg in range(len(day.config.servo_bus.names)):
            jogs.append(jog_leg(port, day.config, leg, JOG_DEG, day.person, keep))
            day.heard()
    day.note(*jog_findings(jogs, day.config.servo_bus))


@dataclass(frozen=True, slots=True)
class _Registers:
    """What torque might change, of one servo."""

    goal: int
    position: int
    mode: int
    gains: tuple[int, ...]


def _read(servo: CheckedServo) -> _Registers:
    return _Registers(
        goal=servo.read_run("goal_position", "realtime_tick")["goal_position"],
        position=servo.read_run("present_velocity", "present_position")["present_position"],
        mode=servo.read("operating_mode"),
        gains=read_gains(servo),
    )


def torque(day: Day) -> None:
    """Step 5: goal, position and gains before torque, with it, and after it."""
    bus = day.bus()
    bus.connect()
    with closing(bus):
        servos = bus.servos()
        before = [_read(servo) for servo in servos]
        bus.configure()
        with limp_afterwards(bus):
            _settle_unknowns(day, servos[0])
        ready = [_read(servo) for servo in servos]
        with limp_afterwards(bus):
            shafts = GatedShafts(bus, day.config)
            on = []
            for servo in servos:  # goals in between: a watchdog may hear nothing but those
                on.append(_read(servo))
                shafts.follow(Hold(shafts.angle_rad), 0.0)
            track = shafts.follow(Hold(shafts.angle_rad), HOLD_S)
        after = [_read(servo) for servo in servos]
    day.curves.extend(
        turning_curves(bus.settings.names, track.t_ns, track.angle_rad, track.goal_rad)
    )
    moved = np.degrees(np.abs(track.angle_rad - track.goal_rad)).max(axis=0)
    day.heard()
    for k, servo in enumerate(servos):
        one, two, three, four = before[k], ready[k], on[k], after[k]
        found = (
            f"goal {one.goal} before, {three.goal} with torque, {four.goal} after; position "
            f"{one.position}, {three.position}, {four.position}; {moved[k]:.2f} deg off while holding"
        )
        jumped = abs(three.position - two.position)
        if jumped > JUMP_TICKS or abs(three.goal - two.position) > JUMP_TICKS:
            advice = "do not walk: it moves when torque goes on; keep this step's log"
            day.note(failed(servo.leg, f"{found}; jumped by {jumped} ticks", advice))
        else:
            day.note(passed(servo.leg, found))
    _gain_findings(day, servos, before, ready, on)
    stale = [s.leg for s, one in zip(servos, before, strict=True)
             if abs(one.goal - one.position) > JUMP_TICKS]  # fmt: skip
    if stale:
        found = (
            f"without torque it stays where it was ({', '.join(stale)}), wherever the shaft goes"
        )
    else:
        found = "equals the position without torque (turn a shaft by hand and repeat to be sure)"
    day.note(passed("goal register", found))


def _settle_unknowns(day: Day, servo: CheckedServo) -> None:
    """Find out of one servo what the manual does not say about torque, goals and modes."""
    goal = goal_at_torque_on(servo)
    how = f"{servo.who}: a goal {NUDGE_TICKS} ticks beside the shaft, torque on, goal read back"
    day.settled("servo", "goal_at_torque_on", goal, how)
    words = {"kept": "is kept: it would turn to an old one", "here": "becomes the position"}
    day.note(passed("goal at torque on", f"{words[goal]}; a new one is always written before"))
    gains = gains_at_mode_change(servo)
    how = f"{servo.who}: position_p_gain one up, mode 3 and back to 4, gain read back"
    day.settled("servo", "gains_at_mode_change", gains, how)
    words = {"kept": "keeps the gains", "reset": "resets the gains"}
    day.note(passed("change of mode", words[gains]))


def _gain_findings(
    day: Day,
    servos: Sequence[CheckedServo],
    before: Sequence[_Registers],
    ready: Sequence[_Registers],
    on: Sequence[_Registers],
) -> None:
    def lines(first: Sequence[_Registers], second: Sequence[_Registers]) -> str:
        return "; ".join(
            f"{servo.leg} {name} {was} to {now}"
            for servo, one, two in zip(servos, first, second, strict=True)
            for name, was, now in zip(GAINS, one.gains, two.gains, strict=True)
            if was != now
        )

    switched = [
        s.leg for s, one, two in zip(servos, before, ready, strict=True) if one.mode != two.mode
    ]
    if switched:
        found = lines(before, ready) or "no gain changed"
        day.note(passed("mode set", f"mode of {', '.join(switched)} set to 4: {found}"))
    changed = lines(ready, on)
    if changed:
        advice = "torque must not change gains: keep this step's log"
        day.note(failed("gains", changed, advice))
    else:
        models = [model.name for model in day.config.servo_bus.models]
        sets = {(name, one.gains) for name, one in zip(models, on, strict=True)}
        gains = "; ".join(
            (f"{name}: " if len(set(models)) > 1 else "")
            + ", ".join(f"{n} {v}" for n, v in zip(GAINS, values, strict=True))
            for name, values in sorted(sets)
        )
        same = len(sets) == len(set(models))
        word = "the same on all" if len(sets) == 1 else "as before on each"
        day.note((passed if same else warned)(
            "gains", f"{word}: {gains}", *([] if same else ["are they meant to differ?"])
        ))  # fmt: skip


def watchdog(day: Day) -> None:
    """Step 6: fall silent and see each servo stop; then speak to one, and see who stays awake."""
    bus = day.bus()
    bus.connect()
    with closing(bus):
        bus.configure()
        with limp_afterwards(bus):
            proof = prove_watchdog(bus)
        if proof.asleep:
            found = f"did not trip in {proof.silent_s:.2f} s of silence: {', '.join(proof.asleep)}"
            day.note(failed("silence", found, "do not walk; update their firmware"))
            return
        found = f"all {len(proof.tripped)} tripped within {proof.silent_s:.2f} s"
        day.note(passed("silence", found))
        bus.configure()
        with limp_afterwards(bus):
            GatedShafts(bus, day.config)
            states = _ping_one(bus)
    one, *others = states
    names = bus.settings.names
    spoken = f"pings to id {int(bus.settings.ids[0])} ({names[0]}) only, {PING_FOR:g} x its time"
    if one == TRIPPED:
        day.note(failed("pings", f"{names[0]} tripped in spite of {spoken}", "keep this log"))
    elif not others:
        day.note(skipped("pings", "there is one servo only"))
    elif len({state == TRIPPED for state in others}) == 1:
        hears = "own" if others[0] == TRIPPED else "all"
        day.settled("servo", "watchdog_hears", hears, f"{spoken}; the others " + (
            "tripped" if hears == "own" else "did not trip"
        ))  # fmt: skip
        words = {"own": "instructions to its own id only", "all": "instructions to any id"}
        day.note(passed("pings", f"a watchdog hears {words[hears]}"))
    else:
        awake = [n for n, s in zip(names[1:], others, strict=True) if s != TRIPPED]
        found = f"{', '.join(awake)} stayed awake and others did not, with {spoken}"
        day.note(warned("pings", found, "have they different firmware? see step 2"))


def _ping_one(bus: ServoBus) -> list[int]:
    """Speak to the first servo only for longer than the watchdog; return all watchdogs."""
    clock, servos = bus.clock, bus.servos()
    end_ns = clock.now_ns() + round(PING_FOR * bus.settings.watchdog_s * 1e9)
    while clock.now_ns() < end_ns:
        servos[0].answers()
        clock.sleep_until_ns(clock.now_ns() + PING_PERIOD_NS)
    return [servo.read("bus_watchdog") for servo in servos]


def cable(day: Day) -> None:
    """Step 9: hold, have the cable pulled and put back, and see what the servos did."""
    bus = day.bus()
    bus.connect()
    with closing(bus):
        bus.configure()
        with limp_afterwards(bus):
            shafts = GatedShafts(bus, day.config)
            before = [servo.read("present_position") for servo in bus.servos()]
            words = f"pull the USB cable of the servo bus now, within {CABLE_PATIENCE_S:.0f} s"
            day.person.begins(Work(Hand.PULL_CABLE, words))
            try:
                shafts.follow(Hold(shafts.angle_rad), CABLE_PATIENCE_S, day.person.meanwhile)
            except ConnectionLost as error:
                found = str(error)
            else:
                day.note(skipped("cable", f"not pulled within {CABLE_PATIENCE_S:.0f} s"))
                return
            day.note(passed("cable", found))
            bus.close()
            day.person.does(Work(Hand.PLUG_CABLE, "plug the cable in again"))
            _reopen(bus)
            servos = bus.servos()
            states = [servo.read("bus_watchdog") for servo in servos]
            torques = [servo.read("torque_enable") for servo in servos]
            after = [servo.read("present_position") for servo in servos]
    awake = [s.leg for s, state in zip(servos, states, strict=True) if state != TRIPPED]
    moved = max(abs(a - b) for a, b in zip(after, before, strict=True)) * 360 / TICKS_PER_TURN
    held = ", ".join(s.leg for s, on in zip(servos, torques, strict=True) if on)
    if awake:
        found = f"did not trip: {', '.join(awake)}"
        day.note(failed("servos", found, "do not walk: they go on without a computer"))
    else:
        found = f"all tripped; torque still on: {held or 'none'}; moved by {moved:.1f} deg at most"
        day.note(passed("servos", found))


def _reopen(bus: ServoBus) -> None:
    """Open the port again; it takes the system a while to have it back.

    Raises:
        BusError: It does not come back.
    """
    for left in reversed(range(PLUG_TRIES)):
        try:
            bus.open()
            if bus.read().valid.all():
                return
        except BusError:
            bus.close()
            if not left:
                raise
        bus.clock.sleep_until_ns(bus.clock.now_ns() + PLUG_LOOK_NS)
    raise BusError("the port is back and not all servos answer")
