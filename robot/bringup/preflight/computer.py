"""What of a computer decides whether it can drive the robot, looked at without any hardware.

Each check is a pure judgement of facts; ``machine_facts`` and ``host_settings`` gather them.
"""

import ctypes.util
import grp
import os
import platform
import resource
import shutil
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from model.kernel_cache import kernel_folder
from record.log.header import NOT_INSTALLED, version_of
from robot.bringup.preflight.finding import Finding, failed, passed, skipped, warned
from robot.console.installed import how_to_install

# Who may open serial ports: Debian and its kin, Arch and its kin.
PORT_GROUPS = ("dialout", "uucp")
EXTRAS = (
    ("foxglove", "foxglove-sdk", "view", "bigant view"),
    ("rerun", "rerun-sdk", "rerun", "bigant view --save FILE.rrd"),
    ("rosbags", "rosbags", "bags", "bigant import of a ROS 2 bag"),
    ("shtab", "shtab", "completion", "bigant completion"),
)
# The priority that real-time programs of a robot commonly run at; anything from 1 up is enough.
WANTED_RTPRIO = 50
LIMITS_FILE = "/etc/security/limits.d/bigant.conf"
UNLIMITED = resource.RLIM_INFINITY
CPUS = Path("/sys/devices/system/cpu")
LOG_FOLDER = Path("runs")
GB = 1e9
# A log grows by well under 1 GB an hour at 100 Hz.
LEAST_FREE_GB = 0.5
ENOUGH_FREE_GB = 5.0
PYTHONS = ((3, 11), (3, 13))
SLOW = "install numba: without it the model is slow"
NEEDED = ("numpy", "mcap", "dynamixel-sdk", "pyserial")


@dataclass(frozen=True, slots=True)
class Machine:
    """Facts about this computer and who we are on it.

    Attributes:
        root: Whether we are root.
        groups: Groups we are in.
        port_group: Group of serial ports that exists here, empty for none.
        rtprio: Highest real-time priority we may ask for.
        nice_floor: Lowest niceness we may ask for.
        memlock_bytes: Memory that we may lock; -1 for no limit.
        preempt_rt: Whether the kernel is a real-time one.
        renderers: OpenGL libraries that can draw without a display.
        gl_choice: What MUJOCO_GL asks for, empty for nothing.
        display: Whether there is a display.
    """

    root: bool
    groups: tuple[str, ...]
    port_group: str
    rtprio: int
    nice_floor: int
    memlock_bytes: int
    preempt_rt: bool
    renderers: tuple[str, ...]
    gl_choice: str
    display: bool


@dataclass(frozen=True, slots=True)
class HostSettings:
    """What of the computer's settings a loop feels.

    Attributes:
        governors: Frequency governors of the processors; empty where the system shows none.
        latency_timer_ms: The adapter's latency timer, None where there is none.
        nice: Niceness of this process.
        realtime: Whether it runs under a real-time policy.
        isolated: Isolated processors as the kernel lists them, empty for none.
        switch_interval_ms: Python's switch interval.
        load: Programs that want to run, mean of one minute.
        processors: Number of processors.
    """

    governors: tuple[str, ...]
    latency_timer_ms: float | None
    nice: int
    realtime: bool
    isolated: str
    switch_interval_ms: float
    load: float
    processors: int


def machine_facts() -> Machine:
    """Look at this computer."""
    existing = {entry.gr_name for entry in grp.getgrall()}
    memlock = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0]
    return Machine(
        root=os.geteuid() == 0,
        groups=tuple(sorted(_group_name(gid) for gid in {*os.getgroups(), os.getegid()})),
        port_group=next((name for name in PORT_GROUPS if name in existing), ""),
        rtprio=_soft_limit(resource.RLIMIT_RTPRIO),
        nice_floor=20 - _soft_limit(resource.RLIMIT_NICE),
        memlock_bytes=-1 if memlock == UNLIMITED else memlock,
        preempt_rt="PREEMPT_RT" in platform.version() or Path("/sys/kernel/realtime").exists(),
        renderers=tuple(name for name in ("EGL", "OSMesa") if ctypes.util.find_library(name)),
        gl_choice=os.environ.get("MUJOCO_GL", ""),
        display=bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")),
    )


def _soft_limit(which: int) -> int:
    soft = resource.getrlimit(which)[0]
    return 99 if soft == UNLIMITED else soft


def _group_name(gid: int) -> str:
    try:
        return grp.getgrgid(gid).gr_name
    except KeyError:  # a group that only a file server knows
        return str(gid)


def machine_findings(machine: Machine) -> Iterator[Finding]:
    """Judge the computer. Pure."""
    yield group_finding(machine)
    yield priority_finding(machine)
    memory = f"{machine.memlock_bytes / 1e6:.0f} MB allowed, none is used"
    yield passed("locked memory", memory if machine.memlock_bytes >= 0 else "no limit")
    kind = "real-time" if machine.preempt_rt else "ordinary"
    yield passed("kernel", f"{platform.release()}, {kind}")
    yield renderer_finding(machine)


def group_finding(machine: Machine) -> Finding:
    """Judge whether serial ports may be opened."""
    if machine.root:
        return passed("serial group", "root may open every port")
    if not machine.port_group:
        return skipped("serial group", f"none of the groups {', '.join(PORT_GROUPS)} exists here")
    if machine.port_group in machine.groups:
        return passed("serial group", f"you are in {machine.port_group}")
    return warned(
        "serial group",
        f"you are not in {machine.port_group}",
        f"sudo usermod -aG {machine.port_group} $USER, then log out and in "
        "(see docs/tutorial.md#wiring)",
    )


def priority_finding(machine: Machine) -> Finding:
    """Judge whether the loop may be given priority."""
    if machine.root or machine.rtprio >= 1:
        highest = "any priority (root)" if machine.root else f"real-time up to {machine.rtprio}"
        return passed("priority", f"allowed: {highest}; nothing takes it by itself")
    found = f"real-time priority is not allowed, niceness from {machine.nice_floor} up"
    return warned(
        "priority",
        found,
        f"if bigant check --loop says that ticks are late: put '@{machine.port_group or 'users'} "
        f"- rtprio {WANTED_RTPRIO}' and '... - nice -10' into {LIMITS_FILE}, log in again, and start "
        f"with chrt -f {WANTED_RTPRIO}",
    )


def renderer_finding(machine: Machine) -> Finding:
    """Say whether MuJoCo could draw here; walking and reports need no drawing."""
    name = "OpenGL"
    found = ", ".join(machine.renderers) or "no EGL or OSMesa library"
    if machine.gl_choice:
        found += f"; MUJOCO_GL={machine.gl_choice}"
    if machine.renderers or machine.display:
        return passed(name, found + ("; a display" if machine.display else "; no display"))
    return skipped(name, f"{found}: pictures of the plant cannot be drawn, nothing else needs it")


def host_settings(latency_timer_ms: float | None) -> HostSettings:
    """Read the settings of this computer."""
    governors = sorted({_text(path) for path in CPUS.glob("cpu*/cpufreq/scaling_governor")})
    return HostSettings(
        governors=tuple(governors),
        latency_timer_ms=latency_timer_ms,
        nice=os.getpriority(os.PRIO_PROCESS, 0),
        realtime=os.sched_getscheduler(0) in {os.SCHED_FIFO, os.SCHED_RR},
        isolated=_text(CPUS / "isolated"),
        switch_interval_ms=sys.getswitchinterval() * 1e3,
        load=os.getloadavg()[0],
        processors=len(os.sched_getaffinity(0)),
    )


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8").strip()
    except OSError:
        return ""


def host_settings_findings(host: HostSettings) -> Iterator[Finding]:
    """Judge settings that affect a loop. Pure."""
    if not host.governors:
        yield skipped("governor", "the system shows none (a virtual machine?)")
    elif set(host.governors) == {"performance"}:
        yield passed("governor", "performance")
    else:
        yield warned("governor", ", ".join(host.governors), "cpupower frequency-set -g performance")
    isolated = (
        f"processors {host.isolated}" if host.isolated else "none; only of use if ticks are late"
    )
    yield passed("isolated", isolated)
    busy = f"system load is {host.load:.1f} on {host.processors} cores"
    if host.load > host.processors:
        yield warned("load", busy, "real-time walking may stutter; stop other programs first")
    else:
        yield passed("load", busy)


def software_findings() -> Iterator[Finding]:
    """Look at the disk for logs, and at the versions of what runs."""
    yield disk_finding(shutil.disk_usage(_existing(LOG_FOLDER)).free / GB, str(LOG_FOLDER))
    yield python_finding(platform.python_version_tuple())
    yield packages_finding({name: version_of(name) for name in (*NEEDED, "numba")})


def _existing(folder: Path) -> Path:
    folder = folder.absolute()
    while not folder.exists():
        folder = folder.parent
    return folder


def disk_finding(free_gb: float, where: str) -> Finding:
    """Judge the free space for logs."""
    found = f"{free_gb:.1f} GB free for logs in {where}"
    if free_gb < LEAST_FREE_GB:
        return failed("disk", found, "delete something, or choose another folder with --log")
    if free_gb < ENOUGH_FREE_GB:
        return warned("disk", found, "enough for a few walks; make room")
    return passed("disk", found)


def python_finding(version: tuple[str, ...]) -> Finding:
    """Judge the version of Python."""
    lowest, highest = PYTHONS
    found = ".".join(version)
    if lowest <= (int(version[0]), int(version[1])) <= highest:
        return passed("Python", found)
    return warned(
        "Python", found, f"tested from {lowest[0]}.{lowest[1]} to {highest[0]}.{highest[1]} only"
    )


def packages_finding(versions: dict[str, str]) -> Finding:
    """Judge which packages are there."""
    found = ", ".join(f"{name} {version}" for name, version in versions.items())
    gone = [name for name in NEEDED if versions[name] == NOT_INSTALLED]
    if gone:
        return failed("packages", found, f"install {', '.join(gone)}")
    if versions["numba"] == NOT_INSTALLED:
        return warned("packages", found, SLOW)
    return passed("packages", found)


def cache_finding(folder: Path | None = None) -> Finding:
    """Judge whether compiled code of the model can be kept between runs.

    Args:
        folder: Where it is kept; by default ``model.kernel_cache.kernel_folder``.
    """
    name = "compiler cache"
    if find_spec("numba") is None:
        return warned(name, "numba is missing", SLOW)
    place = folder or Path(kernel_folder())
    if os.access(_existing(place), os.W_OK):
        return passed(name, f"{place} can be written")
    return warned(
        name,
        f"{place} cannot be written",
        "set NUMBA_CACHE_DIR to a folder of yours, or each start compiles for half a minute",
    )


def extras_findings() -> Iterator[Finding]:
    """Say which optional parts are installed."""
    for module, package, extra, command in EXTRAS:
        if find_spec(module) is None:
            yield skipped(package, f"not installed; {command} needs it: {how_to_install(extra)}")
        else:
            yield passed(package, f"{version_of(package)}, for {command}")
    if find_spec("rclpy") is None:
        yield skipped("rclpy", "no ROS 2 in this shell; only bigant view --ros2 needs it")
    else:
        yield passed("rclpy", "ROS 2 is there, for bigant view --ros2")
