"""The catalogue of ``sliding_body``."""

from dataclasses import replace

from gap.interfaces import Effect, Parameter, Scope

STAGES = ("support", "friction", "sensing")


def _effect(
    name: str, stage: str, parameters: tuple[Parameter, ...], physics: str, remedy: str
) -> Effect:
    by_forces = stage == "friction"
    return Effect(name, stage, parameters, (Scope.ALL,), physics, remedy, by_forces=by_forces)


CATALOGUE = (
    replace(_effect("coulomb_friction", "friction", (Parameter("mu", "", 0.2, 0.0, 2.0, 0.2),),
            "Friction does not grow with speed: mu times the weight, against the motion.",
            "Use Coulomb's law in the simulator."), law=True),
    _effect("speed_dependence", "friction", (Parameter("per_m_s", "s/m", 0.0, -2.0, 10.0, 0.5),),
            "The coefficient of friction changes with speed, by this share for each m/s.",
            "Measure friction at two speeds."),
    _effect("friction_level", "friction", (Parameter("ratio", "", 1.0, 0.05, 10.0, 0.4),),
            "The law is right, its coefficient is not.",
            "Measure mu by tilting the surface."),
    _effect("ground_slope", "support",
            tuple(Parameter(n, "", 0.0, -0.2, 0.2, 0.02) for n in ("slope_x", "slope_y")),
            "The ground rises along the world's x or y, and gravity pulls downhill.",
            "Level the surface, or measure its slope."),
    _effect("pose_delay", "sensing", (Parameter("delay_s", "s", 0.0, 0.0, 0.1, 0.01),),
            "Poses are stamped later than they were taken.",
            "Check the camera's clock."),
)  # fmt: skip
