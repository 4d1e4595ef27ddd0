"""The force-torque unit's part of the pre-flight list."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from drivers.ati.calibration import Calibration, parse_cal
from drivers.ati.console import Console
from drivers.ati.links import DatagramLink, TextLink
from drivers.ati.packets import Led, battery_led, unix_ns
from drivers.ati.settings import ForceSensorSettings
from drivers.ati.stream import ForceStream, StreamCounters
from drivers.ati.unit_state import UnitState
from drivers.clock import Clock
from model.errors import ForceStreamError
from model.values.arrays import BoolArray
from model.values.readings import ForceRecord
from robot.bringup.preflight.finding import Finding, about, failed, passed, skipped, warned
from robot.console.table import number_text

LOOK_NS = 20_000_000
# Radio packets and a rate that the unit rounds: five per cent is as configured.
RATE_TOLERANCE = 0.05
LOSS_LIMIT = 0.01
OFFSET_LIMIT_S = 1.0
SPREAD_LIMIT_S = 0.05

Links = Callable[[], tuple[DatagramLink, TextLink]]


@dataclass(frozen=True, slots=True)
class Received:
    """What came during the look.

    Attributes:
        records: The records in order.
        counters: Losses and repeats meanwhile.
        seconds: How long it was listened for.
    """

    records: tuple[ForceRecord, ...]
    counters: StreamCounters
    seconds: float


def force_findings(
    open_links: Links,
    settings: ForceSensorSettings,
    clock: Clock,
    *,
    seconds: float,
    unix_offset_ns: int,
) -> Iterator[Finding]:
    """Look at the unit, one finding after the other; it is stopped and closed afterwards.

    Args:
        open_links: Opens both ways to the unit.
        settings: Transducers and rate.
        clock: Clock of both ways.
        seconds: How long to listen.
        unix_offset_ns: UNIX time less the clock's.
    """
    try:
        datagrams, text = open_links()
    except ForceStreamError as error:
        yield failed("force unit", str(error), "switch it on, or check without: --force-unit none")
        return
    stream = ForceStream(datagrams, text, settings, clock)
    try:
        yield passed("force unit", f"console answers at {settings.address}")
        findings, usable = calibration_findings(Console(text, clock), settings)
        yield from findings
        if not usable:
            yield skipped("force stream", "first fix the failures above")
            return
        stream.connect()
        if stream.unit_state is not None:
            yield unit_finding(stream.unit_state, settings)
        yield from stream_findings(_listen(stream, clock, seconds), settings, unix_offset_ns)
    except ForceStreamError as error:
        yield failed("force stream", str(error), "switch the unit off and on")
    finally:
        stream.stop()
        stream.close()


def calibration_findings(
    console: Console, settings: ForceSensorSettings
) -> tuple[list[Finding], bool]:
    """Ask each transducer for its calibration; also return whether forces can be had of all."""
    good: list[Calibration] = []
    bad: dict[str, list[str]] = {}  # legs by what went wrong
    raw: dict[str, str] = {}
    for leg, number in zip(settings.names, settings.transducers, strict=True):
        if number == 0:
            continue
        try:
            console.query(f"TRANS {number}")
            calibration = parse_cal(console.query("CAL"), int(number))
        except ForceStreamError as error:
            bad.setdefault(str(error), []).append(leg)
            continue
        good.append(calibration)
        if not calibration.mult_on:
            raw[leg] = f"transducer {number} ({leg})"
    findings = [_units(good, bad)]
    if raw:
        advice = "on the unit's console: TRANS n, CAL MULT ON, then SAVEALL"
        found = f"{', '.join(raw.values())} send raw gage counts"
        findings.append(about(raw, failed("matrix (MULT)", found, advice)))
    elif good:
        findings.append(passed("matrix (MULT)", "on"))
    return findings, not bad and not raw


def _units(good: list[Calibration], bad: dict[str, list[str]]) -> Finding:
    if bad:
        found = "; ".join(f"{', '.join(legs)}: {text}" for text, legs in bad.items())
        if not good and len(bad) > 1:  # they share one console, and what follows comes of the first
            found = f"{next(iter(bad))} (so no leg could be asked)"
        legs = [leg for some in bad.values() for leg in some]
        return about(
            legs, failed("force units", found, "check TRANS and CAL on the unit's console")
        )
    never = [str(c.transducer) for c in good if not c.calibrated]
    if never:
        return warned(
            "force units",
            f"transducer {', '.join(never)} has the date of an empty calibration",
            "load its calibration",
        )
    scales = sorted({f"{c.counts_per_n:.10g} per N, {c.counts_per_nm:.10g} per N m" for c in good})
    return passed("force units", f"counts: {'; '.join(scales)}" if scales else "no transducer")


def unit_finding(state: UnitState, settings: ForceSensorSettings) -> Finding:
    """Judge what in the unit changes forces and is in no record. Pure."""
    lines = state.warnings(settings)
    if lines:
        return warned("unit settings", f"{state.text}. {'; '.join(lines)}", "set the unit as usual")
    return passed("unit settings", state.text)


def _listen(stream: ForceStream, clock: Clock, seconds: float) -> Received:
    began_ns = clock.now_ns()
    records = list(stream.read())
    while (now_ns := clock.now_ns()) - began_ns < seconds * 1e9:
        clock.sleep_until_ns(now_ns + LOOK_NS)
        records += stream.read()
    stream.take_faults()
    return Received(tuple(records), stream.counters, (clock.now_ns() - began_ns) * 1e-9)


def stream_findings(
    received: Received, settings: ForceSensorSettings, unix_offset_ns: int
) -> list[Finding]:
    """Judge a few seconds of the stream. Pure."""
    if len(received.records) < 2:
        return [
            failed(
                "force stream",
                f"{len(received.records)} records in {received.seconds:.1f} s",
                "switch the unit off and on; is its radio in reach?",
            )
        ]
    return [
        _rate(received, settings),
        _loss(received),
        _clock_offset(received, unix_offset_ns),
        _transducers(received, settings),
        _saturation(received, settings),
        _battery(received),
    ]


def _rate(received: Received, settings: ForceSensorSettings) -> Finding:
    """Judge the rate by the unit's own stamps: it does not depend on how often we look."""
    first, last = received.records[0], received.records[-1]
    samples = (last.sequence - first.sequence) % 2**32
    ticks = (last.device_ticks - first.device_ticks) % 2**32
    rate_hz = samples / (ticks / 4096) if ticks else float("nan")
    found = f"{rate_hz:.1f} Hz, {settings.rate_hz} Hz wanted"
    if abs(rate_hz - settings.rate_hz) <= RATE_TOLERANCE * settings.rate_hz:
        return passed("packet rate", found)
    return failed("packet rate", found, "check RATE on the unit's console, and its oversampling")


def _loss(received: Received) -> Finding:
    c = received.counters
    share = c.missing / max(1, c.missing + c.records)
    found = (
        f"{c.missing} of {c.missing + c.records} lost ({share:.1%}), {c.duplicate} twice, "
        f"{c.late} late, {c.malformed} malformed, in {received.seconds:.1f} s"
    )
    if share > LOSS_LIMIT or c.malformed:
        return failed("radio", found, "bring unit and access point closer, or change the channel")
    if c.missing or c.late:
        return warned("radio", found, "a few are lost: keep the unit in sight of its access point")
    return passed("radio", found)


def _clock_offset(received: Received, unix_offset_ns: int) -> Finding:
    host_ns = np.array([record.t_ns + unix_offset_ns for record in received.records])
    device_ns = [
        unix_ns(record.device_ticks, int(host))
        for record, host in zip(received.records, host_ns, strict=True)
    ]
    offset_s = (host_ns - np.array(device_ns)) * 1e-9
    middle = float(np.median(offset_s))
    spread = float(np.quantile(offset_s, 0.95) - np.quantile(offset_s, 0.05))
    evenly = f"90 % of the records within {spread * 1e3:.1f} ms"
    found = f"host minus unit {number_text(middle, 3)} s, {evenly}"
    if spread > SPREAD_LIMIT_S:
        return warned("clock offset", found, "records come in bursts: is the radio busy?")
    if abs(middle) > OFFSET_LIMIT_S:
        words = "the unit's clock is not set, and nothing needs it (records are stamped on arrival)"
        return passed("clock offset", f"{words}; {evenly}")
    return passed("clock offset", found)


def _transducers(received: Received, settings: ForceSensorSettings) -> Finding:
    always = np.logical_and.reduce([record.present for record in received.records])
    if absent := _used_where(~always, settings):
        found = f"not in the records: {', '.join(absent.values())}"
        advice = "switch them on with XPWR on the unit's console"
        return about(absent, failed("transducers", found, advice))
    return passed("transducers", f"all {np.count_nonzero(settings.transducers)} in every record")


def _used_where(holds: BoolArray, settings: ForceSensorSettings) -> dict[str, str]:
    """Name the transducers of legs for which something holds, by leg."""
    numbers = zip(settings.names, settings.transducers.tolist(), strict=True)
    return {leg: f"{number} ({leg})" for leg, number in numbers if number and holds[number - 1]}


def _saturation(received: Received, settings: ForceSensorSettings) -> Finding:
    ever = np.logical_or.reduce([record.saturated for record in received.records])
    if bad := _used_where(ever, settings):
        found = f"transducer {', '.join(bad.values())}"
        return about(bad, failed("saturation", found, "unload it; if it stays, it is damaged"))
    return passed("saturation", "none")


def _battery(received: Received) -> Finding:
    """Judge the battery light; it may blink, so every record counts."""
    colours = {battery_led(int(record.status[0])) for record in received.records}
    level = f"level byte {received.records[-1].battery}"
    if Led.RED in colours:
        return failed("battery light", f"red, {level}", "charge or change the unit's battery")
    if Led.ORANGE in colours:
        return warned("battery light", f"orange, {level}", "charge the unit's battery soon")
    if Led.GREEN in colours:
        return passed("battery light", f"green, {level}")
    return warned("battery light", f"off, {level}", "is there a battery in the unit?")
