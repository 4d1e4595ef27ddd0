"""Setting the force-torque unit up over its console: rate, and what each transducer's counts mean."""

from drivers.ati.calibration import Calibration, parse_cal
from drivers.ati.console import Console
from drivers.ati.links import DatagramLink
from drivers.ati.packets import UnitCommand, build_command
from drivers.ati.settings import ForceSensorSettings
from drivers.ati.unit_state import set_rate
from drivers.clock import Clock
from model.errors import ForceStreamError

RESETS = 3
RESET_PAUSE_S = 0.2


def free_console(datagrams: DatagramLink, clock: Clock) -> None:
    """Free a console that a dead program still holds; three times, as radio loses packets."""
    for _ in range(RESETS):
        datagrams.send(build_command(UnitCommand.RESET_CONSOLE))
        clock.sleep_until_ns(clock.now_ns() + round(RESET_PAUSE_S * 1e9))


def set_up(
    console: Console,
    settings: ForceSensorSettings,
    before: tuple[Calibration | None, ...] | None = None,
) -> tuple[Calibration | None, ...]:
    """Set rate and oversampling, read every transducer's calibration, switch transmission on.

    Args:
        console: The unit's console.
        settings: Transducers, rate, in-situ calibration.
        before: What the transducers were earlier in the run, None at its beginning.

    Returns:
        Calibration of each leg's transducer, None for a leg without one.

    Raises:
        ForceStreamError: It does not answer, a transducer sends raw gage counts or counts in a unit
            that we do not know, or it is not the transducer that the in-situ calibration was made of
            or that was there before.
    """
    set_rate(console, settings.rate_hz, settings.oversampling)
    console.query("T OFF")
    calibrations = tuple(
        _read_calibration(console, leg, number) if number else None
        for leg, number in zip(settings.names, settings.transducers.tolist(), strict=True)
    )
    check_serials(calibrations, settings)
    if before is not None and list(map(_meaning, calibrations)) != list(map(_meaning, before)):
        raise ForceStreamError(
            "the force-torque unit came back with other transducers or units: start again"
        )
    console.query("T ON")
    return calibrations


def _meaning(calibration: Calibration | None) -> tuple[str, float, float]:
    """What makes counts mean the same as before."""
    if calibration is None:
        return "", 0.0, 0.0
    return calibration.serial, calibration.counts_per_n, calibration.counts_per_nm


def _read_calibration(console: Console, leg: str, number: int) -> Calibration:
    console.query(f"TRANS {number}")
    calibration = parse_cal(console.query("CAL"), number)
    if not calibration.mult_on:
        raise ForceStreamError(
            f"transducer {number} ({leg}) sends raw gage counts: switch its matrix on with "
            f"TRANS {number} and CAL MULT ON, then SAVEALL, on the unit's console"
        )
    return calibration


def check_serials(
    calibrations: tuple[Calibration | None, ...], settings: ForceSensorSettings
) -> None:
    """Refuse an in-situ calibration that was made of other transducers.

    Raises:
        ForceStreamError: A serial number differs.
    """
    if settings.calibration is None:
        return
    legs = zip(settings.names, calibrations, settings.calibration.serials, strict=True)
    for leg, calibration, serial in legs:
        if calibration is not None and serial and serial != calibration.serial:
            raise ForceStreamError(
                f"the calibration file is of transducer {serial!r} on leg {leg}, but "
                f"{calibration.serial!r} is there: calibrate again (bigant force calibrate) or name "
                "another file"
            )
