"""All effects there are, in the order of the stages."""

from sim_hw.twin import (
    body as effects_body,
)
from sim_hw.twin import (
    contact as effects_contact,
)
from sim_hw.twin import (
    sensor_effects as effects_sensing,
)
from sim_hw.twin.effects import STAGES, EffectKind

_ALL = (*effects_body.KINDS, *effects_contact.KINDS, *effects_sensing.KINDS)
EFFECTS: tuple[EffectKind, ...] = tuple(
    sorted(_ALL, key=lambda kind: (not kind.catalogued, STAGES.index(kind.stage)))
)
