"""All effects there are, in the order of the stages."""

from sim_hw import effects_body, effects_contact, effects_sensing
from sim_hw.effects import STAGES, EffectKind

_ALL = (*effects_body.KINDS, *effects_contact.KINDS, *effects_sensing.KINDS)
EFFECTS: tuple[EffectKind, ...] = tuple(
    sorted(_ALL, key=lambda kind: (not kind.catalogued, STAGES.index(kind.stage)))
)
