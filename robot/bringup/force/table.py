"""What ``bigant force watch`` shows: the newest readings and the state of the stream, as lines. Pure."""

from dataclasses import dataclass

import numpy as np

from drivers.ati.clock import ClockEstimate
from drivers.ati.packets import Led
from drivers.ati.stream import StreamCounters
from model.values.arrays import FloatArray, IntArray
from model.values.readings import ForceRecord
from robot.console.table import number_text

UNIT_LEDS = (("WLAN", 6), ("power", 8), ("battery", 10))


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """The stream at a moment; N legs.

    Attributes:
        seconds: Since the beginning.
        names: Leg names.
        transducers: Transducer of each leg, 0 for none, (N,).
        record: The newest record, None before the first.
        wrench: What the transducers read, bias or calibration subtracted, (N, 6) [N, N m].
        age_ns: Of each leg's last sound sample, (N,), -1: never.
        rate_hz: Packets a second since the last snapshot.
        counters: What happened so far.
        clock: The unit's clock against ours.
        repair_error: Why reconnecting failed last.
    """

    seconds: float
    names: tuple[str, ...]
    transducers: IntArray
    record: ForceRecord | None
    wrench: FloatArray
    age_ns: IntArray
    rate_hz: float
    counters: StreamCounters
    clock: ClockEstimate | None
    repair_error: str


def snapshot_json(shot: Snapshot) -> object:
    """Return a snapshot as JSON can hold it; what is not known is null."""
    legs = [
        {
            "leg": name,
            "transducer": int(shot.transducers[leg]) or None,
            "age_ms": shot.age_ns[leg] * 1e-6 if shot.age_ns[leg] >= 0 else None,
            "force_n": shot.wrench[leg, :3],
            "moment_nm": shot.wrench[leg, 3:],
        }
        for leg, name in enumerate(shot.names)
    ]
    return {
        "seconds": shot.seconds,
        "packets_per_s": shot.rate_hz,
        "legs": legs,
        "counters": shot.counters,
        "clock": shot.clock,
        "repair_error": shot.repair_error,
    }


def led(status: IntArray, number: int) -> str:
    """Return the colour of a transducer's LED, 1 to 6."""
    half, place = divmod(number - 1, 3)
    return Led(int(status[half]) >> 2 * place & 3).name.lower()


def unit_led(status: IntArray, place: int) -> str:
    """Return the colour of one of the unit's own LEDs."""
    return Led(int(status[0]) >> place & 3).name.lower()


def bridge_low(status: IntArray, number: int) -> bool:
    """Whether a transducer's bridge voltage is low."""
    half, place = divmod(number - 1, 3)
    return bool(int(status[half]) >> 27 + place & 1)


def leg_lines(shot: Snapshot) -> list[str]:
    """Return a heading and a line a leg, narrow enough for 80 columns."""
    heads = ("Fx N", "Fy N", "Fz N", "Tx N m", "Ty N m", "Tz N m")
    lines = ["leg T" + "".join(f"{head:>8}" for head in heads) + " age ms  state"]
    for leg, name in enumerate(shot.names):
        number = int(shot.transducers[leg])
        digits = (2, 2, 2, 3, 3, 3)
        cells = [number_text(v, d, 8) for v, d in zip(shot.wrench[leg], digits, strict=True)]
        age = number_text(shot.age_ns[leg] * 1e-6 if shot.age_ns[leg] >= 0 else np.nan, 0, 7)
        lines.append(f"{name:<3} {number or '-'}{''.join(cells)}{age}  {_state(shot, number)}")
    return lines


def _state(shot: Snapshot, number: int) -> str:
    if number == 0:
        return "no transducer"
    if shot.record is None or not shot.record.present[number - 1]:
        return "not in the packets"
    words = [f"LED {led(shot.record.status, number)}"]
    words += ["SATURATED"] if shot.record.saturated[number - 1] else []
    words += ["BRIDGE LOW"] if bridge_low(shot.record.status, number) else []
    return ", ".join(words)


def stream_lines(shot: Snapshot) -> list[str]:
    """Return the state of the stream: losses, lights, clock."""
    c = shot.counters
    lines = [
        f"packets {shot.rate_hz:.1f} /s   records {c.records}   lost {c.missing}   "
        f"duplicate {c.duplicate}   late {c.late}   malformed {c.malformed}   "
        f"saturated {c.saturated}   restarts {c.restarts}   set up again {c.repairs}"
    ]
    if shot.record is not None:
        leds = "   ".join(f"{n} {unit_led(shot.record.status, at)}" for n, at in UNIT_LEDS)
        lines.append(
            f"unit LEDs  {leds}   battery byte 0x{shot.record.battery:02x} (no unit known)"
        )
    if shot.clock is not None:
        drift = (
            "not known yet" if np.isnan(shot.clock.drift_ppm) else f"{shot.clock.drift_ppm:.1f} ppm"
        )
        lines.append(
            f"clock  host (monotonic) minus unit {shot.clock.offset_ns * 1e-9:.4f} s   drift {drift}   "
            f"jitter {shot.clock.jitter_ns * 1e-6:.2f} ms   steps {shot.clock.steps}   "
            f"rollovers {shot.clock.rollovers}"
        )
    if shot.repair_error:
        lines.append(f"reconnecting: {shot.repair_error}")
    return lines


def one_line(shot: Snapshot) -> str:
    """Return a snapshot as one line, for an output that is no terminal."""
    force = " ".join(
        f"{name} {number_text(value, 2)}"
        for name, value in zip(shot.names, shot.wrench[:, 2], strict=True)
    )
    c = shot.counters
    offset = "-" if shot.clock is None else f"{shot.clock.offset_ns * 1e-9:.4f} s"
    return (
        f"{shot.seconds:7.1f} s  {shot.rate_hz:6.1f} /s  Fz N  {force}  lost {c.missing} "
        f"duplicate {c.duplicate} late {c.late} saturated {c.saturated}  clock offset {offset}"
    )
