"""Finding force-torque units: ATI's RTA discovery, a question by broadcast and answers by multicast.

Source: ATI's Java demo (DiscoveryClient). Devices answer one after the other, in the order of the last
byte of their address. A unit that is asked directly (the virtual one on loopback) answers directly.
"""

import contextlib
import select
import socket
import time
from dataclasses import dataclass

from model.errors import ForceStreamError

DISCOVERY_PORT = 51000
ANSWER_PORT = 28250
ANSWER_GROUP = "224.0.5.128"
DELAY_MULTIPLIER = 7
LONGEST_WAIT_S = 257 * DELAY_MULTIPLIER * 1e-3
DIRECT_WAIT_S = 1.0
APPLICATION = "Wireless F/T"
_QUESTION = b"RTA Device DiscoveryRTAD"
_ANSWER = b"RTAD"
_TAG_MAC, _TAG_ADDRESS, _TAG_MASK, _TAG_TEXT, _TAG_LOCATION = 0x01, 0x02, 0x03, 0x0D, 0x86


@dataclass(frozen=True, slots=True)
class DiscoveredUnit:
    """One unit that answered.

    Attributes:
        address: Its address.
        mac: Hardware address.
        text: Application text.
        location: Location text, set by its owner.
    """

    address: str
    mac: str
    text: str
    location: str


def question() -> bytes:
    """Return the discovery question: answer to the group, seven times the usual delay."""
    group = socket.inet_aton(ANSWER_GROUP)
    return _QUESTION + bytes([0x02, 4]) + group + bytes([0xF2, 1, DELAY_MULTIPLIER])


def answer(unit: DiscoveredUnit, netmask: str = "255.255.255.0") -> bytes:
    """Return a unit's answer."""
    items = (
        (_TAG_MAC, bytes.fromhex(unit.mac.replace(":", ""))),
        (_TAG_ADDRESS, socket.inet_aton(unit.address)),
        (_TAG_MASK, socket.inet_aton(netmask)),
        (_TAG_TEXT, unit.text.encode("ascii")),
        (_TAG_LOCATION, unit.location.encode("ascii")),
    )
    return _ANSWER + b"".join(bytes([tag, len(value)]) + value for tag, value in items)


def parse_answer(data: bytes) -> DiscoveredUnit | None:
    """Return the unit in an answer; None if it is none, or of no wireless force-torque unit."""
    if not data.startswith(_ANSWER):
        return None
    items: dict[int, bytes] = {}
    at = len(_ANSWER)
    while at + 2 <= len(data):
        tag, length = data[at], data[at + 1]
        items[tag] = data[at + 2 : at + 2 + length]
        at += 2 + length
    text = _printable(items.get(_TAG_TEXT, b""))
    address = items.get(_TAG_ADDRESS, b"")
    if APPLICATION not in text or len(address) != 4:
        return None
    return DiscoveredUnit(
        address=socket.inet_ntoa(address),
        mac=items.get(_TAG_MAC, b"").hex(":"),
        text=text,
        location=_printable(items.get(_TAG_LOCATION, b"")),
    )


def _printable(data: bytes) -> str:
    """Return the letters of a text that anybody on the network may have sent; other bytes are left out."""
    return "".join(chr(byte) for byte in data if 0x20 <= byte < 0x7F)


def discover(address: str, port: int = DISCOVERY_PORT) -> tuple[DiscoveredUnit, ...]:
    """Ask and collect answers until no more can come.

    Args:
        address: A broadcast address, or one unit's own.
        port: Port to ask at.

    Raises:
        ForceStreamError: The question cannot be sent.
    """
    broadcast = address.endswith(".255")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asker:
        asker.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            if broadcast:
                asker.bind(("", ANSWER_PORT))
                _join_group(asker)
                asker.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
            asker.sendto(question(), (address, port))
        except OSError as error:
            raise ForceStreamError(
                f"no discovery at {address}: {error.strerror or error}; name another address with "
                "--discover, or none"
            ) from error
        return _collect(asker, LONGEST_WAIT_S if broadcast else DIRECT_WAIT_S)


def _join_group(asker: socket.socket) -> None:
    member = socket.inet_aton(ANSWER_GROUP) + socket.inet_aton("0.0.0.0")
    with contextlib.suppress(OSError):  # without multicast, units that answer directly remain
        asker.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)


def _collect(asker: socket.socket, wait_s: float) -> tuple[DiscoveredUnit, ...]:
    units: list[DiscoveredUnit] = []
    deadline_s = time.monotonic() + wait_s
    while (left_s := deadline_s - time.monotonic()) > 0:
        ready, _, _ = select.select([asker], [], [], left_s)
        if not ready:
            break
        unit = None
        with contextlib.suppress(OSError):
            unit = parse_answer(asker.recv(512))
        if unit is not None and unit not in units:
            units.append(unit)
            if wait_s == DIRECT_WAIT_S:
                break
    return tuple(units)
