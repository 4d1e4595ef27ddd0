"""A weightless mass that the body tows: inertia for the walk, no load for the legs.

It slides on its own over the ground, on three springs between it and the body (along, across, about the
vertical), and knows nothing of feet. How large a mass takes a given time to follow is not worked out but
measured, by a pull test of this very plant.
"""

import numpy as np

from model.values.arrays import FloatArray

# The hitch: natural frequency of the body on it [rad/s], and its damping, share of critical; assumed. Stiff
# against the legs, or the mass would swing on it.
HITCH_RAD_S = 350.0
HITCH_DAMPING = 0.2
# The pull test: speeds between which a heavy sledge is braked by sliding feet [m/s], and its mass in
# masses of the robot. Slow enough that springs follow at once.
TEST_FROM_M_S, TEST_TO_M_S = 0.03, 0.01
TEST_SLIP_M_S = TEST_FROM_M_S - TEST_TO_M_S
TEST_MASSES = 30.0
TEST_LONGEST_S = 30.0
TEST_HOLD = 5.0  # duty for each rad that a shaft is turned, as servos hold them


class Ballast:
    """The mass, and the hitch between it and the body.

    Args:
        mass: Of the ballast [kg].
        radius: It is a ring so large [m].
        robot: Mass of the robot [kg], and its inertia about the vertical [kg m^2]; they size the hitch.
        dt_s: Step.
    """

    def __init__(self, mass: float, radius: float, robot: tuple[float, float], dt_s: float) -> None:
        self._inertia = np.array([mass, mass, mass * radius**2])
        own = np.array([robot[0], robot[0], robot[1]])
        self._stiffness = own * HITCH_RAD_S**2
        self._damping = 2 * HITCH_DAMPING * own * HITCH_RAD_S
        self._dt_s = dt_s
        self._place: FloatArray | None = None
        self.rate: FloatArray = np.zeros(3)

    def pull(self, place: FloatArray, rate: FloatArray) -> FloatArray:
        """Advance by one step and return force and torque on the body, x, y, yaw in the world, (3,).

        Args:
            place: Of the body, x, y [m] and yaw [rad], (3,).
            rate: Its rate, (3,).
        """
        if self._place is None:
            self._place = place.copy()
        apart = self._place - place
        apart[2] = (apart[2] + np.pi) % (2 * np.pi) - np.pi
        force: FloatArray = self._stiffness * apart + self._damping * (self.rate - rate)
        self.rate = self.rate - self._dt_s * force / self._inertia
        self._place = self._place + self._dt_s * self.rate
        return force
