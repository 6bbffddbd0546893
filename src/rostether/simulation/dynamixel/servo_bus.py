"""A bus of simulated DYNAMIXEL servos, sans I/O: request bytes in, answer bytes out.

The caller provides the clock.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rostether.simulation.dynamixel.packets import (
    BROADCAST_ID,
    Instruction,
    Packet,
    PacketReader,
    ServoError,
    encode_packet,
)
from rostether.simulation.dynamixel.servo import Servo


class ServoBus:
    """Servos on one line. `damage` may change or drop (b"") each answer on its way to the controller."""

    def __init__(self, ids: Sequence[int], clock: Callable[[], float]) -> None:
        self.servos = {servo_id: Servo(servo_id, clock()) for servo_id in ids}
        self.damage: Callable[[bytes], bytes] | None = None
        self._clock = clock
        self._reader = PacketReader()

    def advance(self) -> None:
        """Move all servos up to the present time."""
        now_s = self._clock()
        for servo in self.servos.values():
            servo.advance(now_s)

    def receive(self, data: bytes) -> bytes:
        """Return the servos' answers to the requests that end in `data`."""
        answer = b""
        for packet in self._reader.feed(data):
            if packet.instruction == Instruction.STATUS:
                continue
            self.advance()
            for reply in self._handle_packet(packet, self._clock()):
                answer += reply if self.damage is None else self.damage(reply)
        return answer

    def _handle_packet(self, packet: Packet, now_s: float) -> list[bytes]:
        listening = [each for each in self.servos.values() if not each.is_restarting(now_s)]
        listening.sort(key=lambda servo: servo.id)
        if packet.id == BROADCAST_ID:
            for servo in listening:
                servo.restart_watchdog(now_s)
            return self._broadcast(packet, listening, now_s)
        for servo in listening:
            if servo.id == packet.id:
                servo.restart_watchdog(now_s)
                level = servo["status_return_level"]
                error, data = servo.handle(packet.instruction, packet.parameters, now_s)
                if packet.instruction == Instruction.PING or level == 2:
                    return [_status(packet.id, error, data)]
                return [_status(packet.id, error, data)] if level == 1 and data else []
        return []

    def _broadcast(self, packet: Packet, servos: list[Servo], now_s: float) -> list[bytes]:
        parameters = packet.parameters
        match packet.instruction:
            case Instruction.PING:
                return [_status(each.id, *each.handle(Instruction.PING, b"", now_s)) for each in servos]
            case Instruction.SYNC_READ if len(parameters) > 4:
                # Each servo waits for the answer of the previous one.
                by_id = {servo.id: servo for servo in servos}
                replies = []
                for servo_id in parameters[4:]:
                    if servo_id not in by_id:
                        break
                    reply = by_id[servo_id].handle(Instruction.READ, parameters[:4], now_s)
                    replies.append(_status(servo_id, *reply))
                return replies
            case Instruction.SYNC_WRITE if len(parameters) > 4:
                self._sync_write(parameters, servos)
            case Instruction.WRITE | Instruction.REG_WRITE | Instruction.ACTION | Instruction.REBOOT:
                for servo in servos:
                    servo.handle(packet.instruction, parameters, now_s)
        return []

    def _sync_write(self, parameters: bytes, servos: list[Servo]) -> None:
        address = int.from_bytes(parameters[:2], "little")
        size = int.from_bytes(parameters[2:4], "little")
        by_id = {servo.id: servo for servo in servos}
        for start in range(4, len(parameters) - size, size + 1):
            servo = by_id.get(parameters[start])
            if servo is not None:
                # Servos do not answer it: a refused value changes nothing.
                servo.write(address, parameters[start + 1 : start + 1 + size])


def _status(servo_id: int, error: int, data: bytes) -> bytes:
    has_failed = error & 0x7F != ServoError.NONE
    return encode_packet(servo_id, Instruction.STATUS, bytes((error,)) + (b"" if has_failed else data))
