"""The table ``[estimator]`` of a robot file, all of which may be left out: older files load as ever.

Its keys are the settings of ``model.estimator.settings`` (meaning, units and defaults stand there) and
the three below. Without the table the estimator runs in every tick with its defaults.
"""

from dataclasses import dataclass, field, fields

from model.errors import ConfigError, ModelError
from model.estimator.settings import EstimatorSettings
from model.parameters.toml_table import Table
from model.quasistatic.frames import FrictionLaw


@dataclass(frozen=True, slots=True)
class EstimatorConfig:
    """The estimator inside the loop.

    Attributes:
        enabled: Whether it runs.
        memory: How late an absolute pose may be [s]. The ticks since then are done again within one, each
            for a fifth of a millisecond, so a long memory costs deadlines.
        pose_port: UDP port on which absolute poses are received; 0 for none.
        settings: Noise, gates and limits.
    """

    enabled: bool = True
    memory: float = 0.15
    pose_port: int = 0
    settings: EstimatorSettings = field(default_factory=EstimatorSettings)


def read_estimator(table: Table, legs: int) -> EstimatorConfig:
    """Read the table.

    Args:
        table: ``[estimator]``, empty if there is none.
        legs: Number of legs.

    Raises:
        ConfigError: A key is unknown or makes no sense.
    """
    usual = EstimatorConfig()
    given: dict[str, object] = {}
    for one in fields(EstimatorSettings):
        if not table.has(one.name):
            continue
        if one.name == "law":
            given[one.name] = FrictionLaw(table.word(one.name, [law.value for law in FrictionLaw]))
        elif isinstance(one.default, bool):
            given[one.name] = table.flag(one.name)
        elif isinstance(one.default, int):
            given[one.name] = table.integer(one.name, minimum=1, maximum=100_000)
        else:
            given[one.name] = table.number(one.name, minimum=0)
    try:
        settings = EstimatorSettings(**given)  # type: ignore[arg-type]
    except ModelError as error:
        raise ConfigError("estimator", str(error)) from error
    enabled = table.flag("enabled", otherwise=legs >= 2)
    if enabled and legs < 2:
        raise ConfigError(table.name("enabled"), "needs at least two legs; set it to false")
    port = table.integer("pose_port", minimum=0, maximum=65535, otherwise=usual.pose_port)
    memory = table.number("memory", minimum=0, maximum=0.5, otherwise=usual.memory)
    return EstimatorConfig(enabled, memory, port, settings)
