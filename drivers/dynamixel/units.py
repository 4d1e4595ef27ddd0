"""What a count is worth: the same in every servo of the MX(2.0) and X series, the current apart.

Source: ROBOTIS e-manual, control tables of the MX(2.0), XL, XC, XM and XH series; the unit of the current
is in ``drivers.dynamixel.catalog``.
"""

import math
from types import MappingProxyType

TICKS_PER_TURN = 4096
TICK_RAD = 2 * math.pi / TICKS_PER_TURN
# 1 count a 64 ms is 0.228882 rpm; the manual rounds to 0.229 and its acceleration unit needs this.
VELOCITY_UNIT_RAD_S = TICK_RAD / 0.064
DUTY_FULL = 885
LOAD_UNIT = 0.001  # of the largest torque, where a servo has a load and no current
VOLTAGE_UNIT_V = 0.1
WATCHDOG_UNIT_S = 0.02
RETURN_DELAY_UNIT_S = 2e-6
EXTENDED_POSITION_LIMIT = 1_048_575
# Rates in the order of their codes, from 0.
BAUD_RATES_BY_CODE = (
    9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000,
)  # fmt: skip
BAUD_CODES = MappingProxyType({rate: code for code, rate in enumerate(BAUD_RATES_BY_CODE)})
