"""The force-torque unit by itself, for the commands that need no servos."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from drivers.ati.links import TcpTextLink
from drivers.ati.settings import ForceSensorSettings
from drivers.ati.stream import ForceStream
from drivers.clock import Clock
from model.errors import ConfigError
from robot.run.hardware import open_force_links

NO_UNIT = "none"


def unit_settings(text: str | None, settings: ForceSensorSettings) -> ForceSensorSettings:
    """Return the settings with another address: HOST, HOST:UDP or HOST:UDP:CONSOLE.

    Raises:
        ConfigError: The text makes no sense.
    """
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


@contextmanager
def running_stream(settings: ForceSensorSettings, clock: Clock) -> Iterator[ForceStream]:
    """Open the unit and start it; it is always told to stop on exit.

    Raises:
        ForceStreamError: It cannot be reached or set up.
    """

    def console() -> TcpTextLink:
        return TcpTextLink(settings.address, settings.console_port)

    stream = ForceStream(*open_force_links(settings, clock), settings, clock, reopen=console)
    try:
        stream.connect()
        yield stream
    finally:
        stream.stop()
        stream.close()
