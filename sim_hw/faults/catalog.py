"""All kinds of faults, under the names that a scenario calls them by."""

from types import MappingProxyType

from sim_hw.faults.kinds import Fault
from sim_hw.faults.servo_kinds import (
    BitFlip,
    Brownout,
    DuplicatedReply,
    Echo,
    ForeignReply,
    LateReply,
    LostReply,
    Overheating,
    Overload,
    SilentServo,
    StuckShaft,
    TruncatedReply,
    Unplug,
)
from sim_hw.faults.wnet_kinds import (
    Batching,
    ClockStep,
    ConsoleStall,
    DuplicatePacket,
    LowBattery,
    MaskChange,
    PacketLoss,
    PortChangeStall,
    ReorderedPacket,
    Rollover,
    SampleRate,
    Saturation,
    SilentStop,
    SplitConsole,
)

KINDS: MappingProxyType[str, type[Fault]] = MappingProxyType(
    {
        "lost_reply": LostReply,
        "bit_flip": BitFlip,
        "late_reply": LateReply,
        "truncated_reply": TruncatedReply,
        "duplicated_reply": DuplicatedReply,
        "foreign_reply": ForeignReply,
        "echo": Echo,
        "silent_servo": SilentServo,
        "brownout": Brownout,
        "overheating": Overheating,
        "overload": Overload,
        "stuck_shaft": StuckShaft,
        "unplug": Unplug,
        "packet_loss": PacketLoss,
        "duplicate_packet": DuplicatePacket,
        "reordered_packet": ReorderedPacket,
        "batching": Batching,
        "mask_change": MaskChange,
        "saturation": Saturation,
        "low_battery": LowBattery,
        "clock_step": ClockStep,
        "rollover": Rollover,
        "port_change_stall": PortChangeStall,
        "silent_stop": SilentStop,
        "console_stall": ConsoleStall,
        "split_console": SplitConsole,
        "sample_rate": SampleRate,
    }
)
