"""The force-torque unit: where it is, and opening both ways to it."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial

from drivers.ati.links import DatagramLink, TcpTextLink, TextLink, UdpLink
from drivers.ati.settings import ForceSensorSettings
from drivers.ati.setup import free_console
from drivers.ati.stream import ForceStream
from drivers.clock import Clock
from drivers.wire.tap import TappedDatagrams, TappedText, WireTap
from model.errors import ConfigError

NO_UNIT = "none"


def unit_settings(text: str | None, settings: ForceSensorSettings) -> ForceSensorSettings:
    """Return the settings with another address: HOST, HOST:UDP or HOST:UDP:CONSOLE.

    Raises:
        ConfigError: The text makes no sense, or the robot has no force sensors.
    """
    require_sensors(settings)
    if text is None:
        return settings
    host, *ports = text.split(":")
    if not host or len(ports) > 2 or not all(p.isdecimal() and int(p) < 65536 for p in ports):
        raise ConfigError("--force-unit", f"must be HOST, HOST:UDP:CONSOLE or none, not {text!r}")
    settings = replace(settings, address=host)
    if ports:
        settings = replace(settings, udp_port=int(ports[0]), local_port=0)
    if len(ports) == 2:
        settings = replace(settings, console_port=int(ports[1]))
    return settings


def require_sensors(settings: ForceSensorSettings) -> None:
    """Refuse what needs force sensors where the robot has none.

    Raises:
        ConfigError: It has none.
    """
    if not settings.any:
        raise ConfigError(
            "force_sensor",
            "the robot file has no force sensors; with some, it has [force_sensor] and legs.transducer",
        )


def wanted_unit(text: str | None, settings: ForceSensorSettings) -> ForceSensorSettings | None:
    """Return the unit that a robot is to run with, None for a robot without or where it is left out.

    Args:
        text: ``--force-unit``: an address, ``none``, or None for the robot file's.
        settings: The robot file's.

    Raises:
        ConfigError: The address makes no sense, or the robot has no force sensors that it could be of.
    """
    if text == NO_UNIT or (text is None and not settings.any):
        return None
    return unit_settings(text, settings)


def why_no_unit(settings: ForceSensorSettings) -> str:
    """Return in words why a robot runs without its unit."""
    return (
        "left out with --force-unit none" if settings.any else "no force sensors in the robot file"
    )


def check_no_unit(text: str | None) -> None:
    """Refuse the address of a unit where the robot is a virtual one, which brings its own.

    Raises:
        ConfigError: There is an address.
    """
    if text not in {None, NO_UNIT}:
        raise ConfigError(
            "--force-unit",
            f"{text} is not used with virtual hardware, which has a unit of its own; leave it out, or none",
        )


def open_force_links(
    unit: ForceSensorSettings, clock: Clock, tap: WireTap | None = None
) -> tuple[DatagramLink, TextLink]:
    """Open both ways to a force-torque unit; its console is freed first.

    Args:
        unit: Where it is.
        clock: Clock of both.
        tap: Listens in on both, None for nobody.

    Raises:
        ForceStreamError: Nobody answers.
    """
    udp = UdpLink(unit.address, unit.udp_port, unit.local_port, clock)
    datagrams = udp if tap is None else TappedDatagrams(udp, tap, clock)
    free_console(datagrams, clock)
    try:
        console = console_opener(unit)()
        return datagrams, console if tap is None else TappedText(console, tap, clock)
    except BaseException:
        datagrams.close()
        raise


def console_opener(unit: ForceSensorSettings) -> Callable[[], TextLink]:
    """Return what opens the way of text alone."""
    return partial(TcpTextLink, unit.address, unit.console_port)


@contextmanager
def running_stream(unit: ForceSensorSettings, clock: Clock) -> Iterator[ForceStream]:
    """Open the unit by itself, start it, and stop it however the caller leaves.

    Raises:
        ForceStreamError: It cannot be reached or set up.
    """
    links = open_force_links(unit, clock)
    with started(ForceStream(*links, unit, clock, reopen=console_opener(unit))) as stream:
        yield stream


@contextmanager
def started(stream: ForceStream) -> Iterator[ForceStream]:
    """Start a stream, and stop it however the caller leaves.

    Raises:
        ForceStreamError: It cannot be set up.
    """
    try:
        stream.connect()
        yield stream
    finally:
        stream.stop()
        stream.close()
