"""Packets: the examples in ROBOTIS' e-Manual of the protocol."""

from __future__ import annotations

import pytest

from rostether.simulation.dynamixel.packets import MAX_LENGTH, Instruction, PacketReader, encode_packet

PING = bytes.fromhex("fffffd0001030001194e")


@pytest.mark.parametrize(
    ("servo_id", "instruction", "parameters", "packet"),
    [
        (1, Instruction.PING, "", PING.hex()),
        (1, Instruction.READ, "84000400", "fffffd000107000284000400 1d15"),
        (1, Instruction.STATUS, "00a6000000", "fffffd000108005500a60000008cc0"),
        (0xFE, Instruction.SYNC_READ, "840004000102", "fffffd00fe09008284000400 0102cefa"),
        (
            0xFE,
            Instruction.SYNC_WRITE,
            "74000400 0196000000 02aa000000",
            "fffffd00fe1100837400040001960000 0002aa0000008287",
        ),
    ],
)
def test_packets_are_those_of_the_manual(
    servo_id: int, instruction: int, parameters: str, packet: str
) -> None:
    data = bytes.fromhex(parameters)
    assert encode_packet(servo_id, instruction, data) == bytes.fromhex(packet)
    (read,) = PacketReader().feed(bytes.fromhex(packet))
    assert (read.id, read.instruction, read.parameters) == (servo_id, instruction, data)


def test_a_header_in_the_parameters_is_stuffed() -> None:
    data = bytes.fromhex("00fffffffdfdfffffd")
    packet = encode_packet(1, Instruction.STATUS, data)
    assert len(packet) == 7 + 1 + len(data) + 2 + 2
    # Byte by byte, after noise that looks like the start of a header.
    reader = PacketReader()
    found = [each for byte in b"\xff\xff\xfd\x01\xff" + packet for each in reader.feed(bytes((byte,)))]
    assert [each.parameters for each in found] == [data]


def test_damage_costs_only_the_damaged_packet() -> None:
    for index in range(len(PING)):
        reader = PacketReader()
        damaged = bytearray(PING)
        damaged[index] ^= 0x10
        # If the length is wrong, the reader waits for more bytes, and then finds the packets inside.
        found = reader.feed(bytes(damaged) + PING + bytes(MAX_LENGTH))
        assert [each.id for each in found] == [1]
