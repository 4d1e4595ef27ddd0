"""How an MJCF or URDF comes in as a kind of machine."""

from gap.machine_kinds import MachineKind
from gap.machines.mujoco.correction import corrected_text, left_by_text
from gap.machines.mujoco.machine import make_machine

MJCF = MachineKind(
    make_machine,
    apply=corrected_text,
    left=left_by_text,
    no_propose=(
        "does not say which runs it could make: let it move slowly and fast, and with another load, and "
        "diagnose all runs together"
    ),
)
