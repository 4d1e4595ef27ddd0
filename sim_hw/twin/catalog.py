"""All effects there are, in the order of the stages."""

from sim_hw.twin import body, contact, sensor_effects
from sim_hw.twin.effects import STAGES, EffectKind

_ALL = (*body.KINDS, *contact.KINDS, *sensor_effects.KINDS)
EFFECTS: tuple[EffectKind, ...] = tuple(
    sorted(_ALL, key=lambda kind: (not kind.catalogued, STAGES.index(kind.stage)))
)
