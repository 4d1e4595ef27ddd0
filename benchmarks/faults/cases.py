"""The cases of the fault matrix: each kind of fault, how the run has to end, and the devices' other sides.

``benchmarks.faults.matrix`` runs them; ``benchmarks.faults.soak`` takes the flipped assumptions from here,
too.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from model.values.faults import FaultKind, StopReason

NOTHING = frozenset[FaultKind]()
SILENT = frozenset({FaultKind.SERVO_SILENT})
BROUGHT_BACK = frozenset({FaultKind.SERVO_DOWN, FaultKind.RECOVERING, FaultKind.SERVO_RECOVERED})
# Each assumption about the devices the other way round; see ``sim_hw.assumed``.
FLIPPED = {
    "reads across gaps give an error": '[servo]\nreserved = "error"\n',
    "firmware 44": "[servo]\nfirmware = 44\n",
    "a servo takes 0.5 ms to answer": "[servo]\nprocessing_s = 0.0005\n",
    "a servo restarts in 0.1 s": "[servo]\nrestart_s = 0.1\n",
    "a servo restarts in 0.8 s": "[servo]\nrestart_s = 0.8\n",
    "a watchdog hears only its own id": '[servo]\nwatchdog_hears = "own"\n',
    "a damaged request is answered": "[servo]\nanswers_bad_crc = true\n",
    "the goal becomes here at torque on": '[servo]\ngoal_at_torque_on = "here"\n',
    "a mode change keeps the gains": '[servo]\ngains_at_mode_change = "kept"\n',
    "commands to the unit are sent back": "[force_unit]\nacknowledges = true\n",
    "a start sets the sequence back": "[force_unit]\nsequence_restarts = true\n",
    "unknown status bits are set": "[force_unit]\nextra_status = 0xC0C0F000\n",
    "the unit's rate is not exact": "[force_unit]\nadc_clock_hz = 1000000\n",
    "no greeting": "[force_unit]\nbanner = false\n",
    "blank lines before prompts": "[force_unit]\nblank_line = true\n",
    "the adapter waits 1 ms": "[adapter]\nlatency_timer_s = 0.001\n",
    "the adapter waits 16 ms": "[adapter]\nlatency_timer_s = 0.016\n",
}
# All of them, several at once: one run of each set meets each of them.
TOGETHER = (
    (
        "reads across gaps give an error", "firmware 44", "a servo takes 0.5 ms to answer",
        "a servo restarts in 0.1 s", "commands to the unit are sent back",
        "a start sets the sequence back", "the adapter waits 1 ms",
    ),
    (
        "a watchdog hears only its own id", "a damaged request is answered",
        "the goal becomes here at torque on", "a mode change keeps the gains",
        "a servo restarts in 0.8 s", "unknown status bits are set",
        "the unit's rate is not exact", "no greeting", "blank lines before prompts",
    ),
    ("the adapter waits 16 ms",),  # too slow to walk: a run of it ends early
)  # fmt: skip


def assumed(together: Sequence[str]) -> str:
    """Return one scenario, TOML, of several assumptions of ``FLIPPED``."""
    tables: dict[str, list[str]] = {}
    for words in together:
        table, key = FLIPPED[words].splitlines()
        tables.setdefault(table, []).append(key)
    return "".join("\n".join([table, *keys, ""]) for table, keys in tables.items())


@dataclass(frozen=True, slots=True)
class Case:
    """One fault.

    Attributes:
        kind: Its name in the catalogue.
        what: The same for a person.
        keys: Keys of its table, TOML.
        reason: Why the run has to end; COMPLETED if the robot has to walk on.
        reported: Fault kinds that have to be in the ticks.
        recovery: Whether the robot file allows recovery.
        power: Whether the fault begins with the devices instead of during the walk.
        refused: Words of the error if the run must not even begin.
    """

    kind: str
    what: str
    keys: str = ""
    reason: StopReason = StopReason.COMPLETED
    reported: frozenset[FaultKind] = NOTHING
    recovery: bool = False
    power: bool = False
    refused: str = ""


def _kinds(*kinds: FaultKind) -> frozenset[FaultKind]:
    return frozenset(kinds)


CASES = (
    Case("lost_request", "1 of 20 requests lost", "rate = 0.05", reported=SILENT),
    Case("damaged_request", "1 of 20 requests with a bit inverted", "rate = 0.05", reported=SILENT),
    Case("late_request", "1 of 20 requests 5 ms late", "rate = 0.05", reported=SILENT),
    Case("truncated_request", "1 of 20 requests cut in half", "rate = 0.05", reported=SILENT),
    Case("lost_reply", "1 of 20 replies lost", "rate = 0.05", reported=SILENT),
    Case("bit_flip", "1 of 20 replies with a bit inverted", "rate = 0.05", reported=SILENT),
    Case("late_reply", "1 of 20 replies 30 ms late", "rate = 0.05", reported=SILENT),
    Case("truncated_reply", "1 of 20 replies cut in half", "rate = 0.05", reported=SILENT),
    Case("duplicated_reply", "every reply twice"),
    Case("foreign_reply", "a foreign status before every reply"),
    Case("echo", "every request echoed"),
    Case(
        "silent_servo", "servo 3 silent for 30 ms", "servo = 3\nduration_s = 0.03", reported=SILENT
    ),
    Case(
        "silent_servo",
        "servo 3 silent for good",
        "servo = 3",
        StopReason.SERVO_LOST,
        SILENT,
    ),
    Case(
        "silent_servo",
        "servo 3 silent for good, those behind it wait for it",
        "servo = 3\nchain_breaks = true",
        StopReason.SERVO_LOST,
        SILENT,
    ),
    Case(
        "silent_servo",
        "servo 3 silent for 0.5 s, recovery allowed: its watchdog trips",
        "servo = 3\nduration_s = 0.5",
        reported=SILENT | BROUGHT_BACK,
        recovery=True,
    ),
    Case(
        "brownout",
        "servo 4 without power for 0.2 s",
        "servo = 4\nduration_s = 0.2",
        StopReason.SERVO_LOST,
        SILENT,
    ),
    Case(
        "brownout",
        "servo 4 without power for 0.2 s, recovery allowed",
        "servo = 4\nduration_s = 0.2",
        reported=BROUGHT_BACK,
        recovery=True,
    ),
    Case(
        "brownout",
        "servo 4 without power for 20 ms",
        "servo = 4\nduration_s = 0.02",
        StopReason.SERVO_LOST,
        SILENT,
    ),
    Case(
        "overheating",
        "motor 5 at 75 C",
        "servo = 5\ntemperature_c = 75.0",
        StopReason.SERVO_FAULT,
        _kinds(FaultKind.SERVO_HOT),
    ),
    Case(
        "overheating",
        "motor 5 at 85 C: the servo shuts down",
        "servo = 5",
        StopReason.SERVO_FAULT,
        _kinds(FaultKind.SERVO_ALERT),
    ),
    Case(
        "overload",
        "motor 6 draws 5.2 A",
        "servo = 6",
        StopReason.SERVO_FAULT,
        _kinds(FaultKind.SERVO_CURRENT),
    ),
    Case(
        "stuck_shaft",
        "shaft 1 jammed",
        "servo = 1",
        StopReason.SERVO_FAULT,
        _kinds(FaultKind.SERVO_STALLED),
    ),
    Case("unplug", "USB cable pulled", "", StopReason.LINK_LOST, _kinds(FaultKind.LINK_LOST)),
    Case(
        "packet_loss", "1 of 10 datagrams lost", "rate = 0.1", reported=_kinds(FaultKind.FORCE_GAP)
    ),
    Case("duplicate_packet", "every datagram twice"),
    Case(
        "reordered_packet",
        "1 of 5 datagrams behind the next",
        "rate = 0.2",
        reported=_kinds(FaultKind.FORCE_GAP),
    ),
    Case("batching", "three records in a datagram"),
    Case(
        "mask_change",
        "transducers 2 and 5 vanish",
        "transducers = [2, 5]",
        reported=_kinds(FaultKind.FORCE_ABSENT),
    ),
    Case(
        "saturation",
        "transducer 5 saturated",
        "transducer = 5",
        reported=_kinds(FaultKind.FORCE_SATURATED),
    ),
    Case("low_battery", "battery low", reported=_kinds(FaultKind.FORCE_BATTERY)),
    Case("clock_step", "clock of the unit jumps by an hour", "step_s = 3600.0"),
    Case("rollover", "stamps of the unit wrap"),
    Case(
        "silent_stop",
        "stream stops for 0.2 s",
        "duration_s = 0.2",
        reported=_kinds(FaultKind.FORCE_GAP),
    ),
    Case(
        "silent_stop",
        "stream stops for good",
        "",
        StopReason.FORCE_LOST,
        _kinds(FaultKind.FORCE_SILENT),
    ),
    Case(
        "port_change_stall",
        "unit bound to another port",
        "stored_port = 50000",
        power=True,
        refused="sends no data",
    ),
    Case("console_stall", "console prints nothing", power=True, refused="did not answer"),
    Case("split_console", "console prints in pieces", "gap_s = 0.01", power=True),
    Case("sample_rate", "unit samples 20 % too fast", "percent = 20.0"),
)
