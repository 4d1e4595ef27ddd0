"""The table ``[imu]`` of a robot file, which may be left out: where an IMU's lines come from, its mounting.

Its noise is among the settings of ``[estimator]`` (``gyro_sd``, ``tilt_sd`` and their biases).
"""

from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np

from model.errors import ConfigError
from model.parameters.toml_table import Table
from model.values.arrays import FloatArray, readonly

AS_THE_BODY = (0.0, 0.0, 0.0)
STEEPEST = 0.9  # least share of the IMU's z axis along the body's: the yaw rate is about it
LONGEST_STALE_S = 2.0


@dataclass(frozen=True, slots=True)
class ImuConfig:
    """An IMU.

    Attributes:
        udp_port: UDP port on which its lines are received; 0 for none.
        port: Serial port of its lines, empty for none.
        baud_rate: Of that port.
        mounting: Roll, pitch and yaw that turn the body's axes into the IMU's [rad].
        stale_after: Readings older than this are not used [s].
    """

    udp_port: int = 0
    port: str = ""
    baud_rate: int = 115_200
    mounting: tuple[float, float, float] = AS_THE_BODY
    stale_after: float = 0.2

    @property
    def any(self) -> bool:
        """Whether the robot has one."""
        return bool(self.udp_port or self.port)

    @property
    def to_body(self) -> FloatArray | None:
        """Turns a vector in the IMU's axes into the body's, (3, 3); None where they are the same."""
        if self.mounting == AS_THE_BODY:
            return None
        (cr, cp, cy), (sr, sp, sy) = map(cos, self.mounting), map(sin, self.mounting)
        rows = [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
        return readonly(np.array(rows))


NO_IMU = ImuConfig()


def read_imu(table: Table) -> ImuConfig:
    """Read the table.

    Args:
        table: ``[imu]``, empty if there is none.

    Raises:
        ConfigError: A key is unknown or makes no sense.
    """
    udp_port = table.integer("udp_port", minimum=0, maximum=65535, otherwise=NO_IMU.udp_port)
    port = table.maybe_text("port")
    if udp_port and port:
        raise ConfigError(table.name("port"), "and udp_port exclude each other; keep one")
    mounting = AS_THE_BODY
    if table.has("mounting"):
        roll, pitch, yaw = table.numbers("mounting", (3,)).tolist()
        mounting = (roll, pitch, yaw)
        if max(map(abs, mounting)) > 2 * pi:
            raise ConfigError(table.name("mounting"), "must be in rad: roll, pitch, yaw")
    config = ImuConfig(
        udp_port,
        port,
        table.integer("baud_rate", minimum=1200, maximum=4_000_000, otherwise=NO_IMU.baud_rate),
        mounting,
        table.number("stale_after", above=0, maximum=LONGEST_STALE_S, otherwise=NO_IMU.stale_after),
    )
    to_body = config.to_body
    if to_body is not None and abs(to_body[2, 2]) < STEEPEST:
        raise ConfigError(
            table.name("mounting"),
            "must leave the IMU's z axis upright or upside down, to 25 degrees",
        )
    return config
