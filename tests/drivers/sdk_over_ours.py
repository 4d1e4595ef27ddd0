"""The SDK's own requests over our packets: the oracle that ours are held to."""

from collections.abc import Sequence

from dynamixel_sdk import (
    COMM_NOT_AVAILABLE,
    COMM_RX_CORRUPT,
    COMM_SUCCESS,
    Protocol2PacketHandler,
)

from drivers.dynamixel.frames import (
    BROADCAST_ID,
    STATUS_BYTES,
    Instruction,
    build_instruction,
    build_status,
)
from drivers.dynamixel.packets import ServoAnswer
from drivers.dynamixel.port import ClockedPort
from drivers.dynamixel.requests import ServoRequests


class SdkRequests(ServoRequests, Protocol2PacketHandler):  # type: ignore[misc]  # the SDK is not typed
    """``ServoRequests`` with what every request of the SDK goes through put on top of them."""

    def txPacket(self, port: ClockedPort, txpacket: Sequence[int]) -> int:  # noqa: N802
        """Send a request that the SDK has laid out: header and CRC are made here, stuffing too."""
        length = txpacket[5] | txpacket[6] << 8
        payload = bytes(txpacket[7 : 7 + length - 2])
        return self.send(build_instruction(txpacket[4], payload[0], payload[1:]))

    def rxPacket(  # noqa: N802
        self, port: ClockedPort, _fast_option: bool = False
    ) -> tuple[list[int], int]:
        """Return the next status frame, unstuffed, laid out as the SDK expects it."""
        frame, code = self.next_status()
        if frame is None:
            return [], code
        head = build_status(frame.servo_id, frame.error or 0)[: STATUS_BYTES - 2]
        packet = [*head, *frame.parameters, 0, 0]  # nobody looks at the CRC any more
        packet[5], packet[6] = (len(packet) - 7) & 0xFF, (len(packet) - 7) >> 8
        return packet, code

    def readTxRx(  # noqa: N802
        self, port: ClockedPort, dxl_id: int, address: int, length: int
    ) -> tuple[list[int], int, int]:
        """Read; an answer that reports an error or has another length is no success."""
        if dxl_id >= BROADCAST_ID:
            return [], COMM_NOT_AVAILABLE, 0
        parameters = address.to_bytes(2, "little") + length.to_bytes(2, "little")
        return _as_sdk(self.request(dxl_id, Instruction.READ, parameters, length))

    def readRx(  # noqa: N802
        self, port: ClockedPort, dxl_id: int, length: int
    ) -> tuple[list[int], int, int]:
        """Take the answer to a read sent before; see ``readTxRx``."""
        return _as_sdk(self.answer(dxl_id, length))


def _as_sdk(answer: ServoAnswer) -> tuple[list[int], int, int]:
    """Lay an answer out as the SDK's helpers expect it; they index into data upon success."""
    if answer.data is None and answer.code == COMM_SUCCESS:
        return [], COMM_RX_CORRUPT, answer.error
    return list(answer.data or b""), answer.code, answer.error
