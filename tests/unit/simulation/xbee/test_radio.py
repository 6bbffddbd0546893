from __future__ import annotations

import pytest

from rostether.simulation.xbee.radio import SimulatedRadio, Transmission
from rostether.simulation.xbee.registers import DIGIMESH, SERIES_1
from rostether.transports.xbee.frame import encode_frame

NUMBER = 0x0013A20040A10007


class Bench:
    """A radio, and a clock that the test moves."""

    def __init__(self, radio: SimulatedRadio | None = None) -> None:
        self.radio = radio or SimulatedRadio(SERIES_1, NUMBER)
        self.now_s = 100.0

    def send(self, data: bytes, *, then_s: float = 0.001) -> bytes:
        """Send bytes to its serial port; return what it answers until `then_s` later."""
        self.radio.serial_received(data, self.now_s)
        self.wait(then_s)
        return self.radio.serial_to_send()

    def wait(self, seconds: float) -> None:
        end_s = self.now_s + seconds
        while (due_s := self.radio.get_timer()) is not None and due_s <= end_s:
            self.now_s = due_s
            self.radio.handle_timer(due_s)
        self.now_s = end_s

    def enter_command_mode(self) -> None:
        self.wait(1.1)
        assert self.send(b"+++", then_s=1.1) == b"OK\r"


def test_command_mode_reads_sets_and_leaves() -> None:
    bench = Bench()
    bench.enter_command_mode()
    assert bench.send(b"ATVR\r") == b"10EC\r"
    assert bench.send(b"AT\rATSH\rATSL\r") == b"OK\r13A200\r40A10007\r"
    # Upper and lower case, with and without a space, several on a line.
    assert bench.send(b"atmy 2a,ID1331,WR\r") == b"OK\rOK\rOK\r"
    assert bench.send(b"ATMY\r") == b"2A\r"
    for wrong in (b"ATXX\r", b"ATCH99\r", b"ATVR1\r", b"ATMYxyz\r", b"hello\r"):
        assert bench.send(wrong) == b"ERROR\r"
    # Values are set, but not applied before the mode ends.
    assert bench.radio.registers["MY"] == 0
    assert bench.send(b"ATCN\r") == b"OK\r"
    assert bench.radio.registers["MY"] == 0x2A
    assert bench.send(b"ATMY\r") == b""


def test_command_mode_ends_after_ten_silent_seconds() -> None:
    bench = Bench()
    bench.enter_command_mode()
    assert bench.send(b"ATMY7\r", then_s=10.1) == b"OK\r"
    assert bench.radio.registers["MY"] == 7
    assert bench.send(b"ATMY\r") == b""


@pytest.mark.parametrize(("before_s", "text"), [(0.5, b"+++"), (1.1, b"++++"), (1.1, b"++")])
def test_pluses_in_data_are_sent(before_s: float, text: bytes) -> None:
    bench = Bench()
    bench.send(b"x", then_s=0.01)
    bench.radio.outgoing.clear()
    bench.wait(before_s)
    assert bench.send(text, then_s=1.1) == b""
    assert [each.payload for each in bench.radio.outgoing] == [text]


def test_bytes_become_packets_after_a_silence_or_when_full() -> None:
    bench = Bench()
    bench.send(b"a", then_s=0.0)
    bench.send(b"b", then_s=0.0)
    assert not bench.radio.outgoing
    # RO is 3 characters of 1 ms at 9600 baud.
    bench.wait(0.0032)
    assert list(bench.radio.outgoing) == [Transmission(0, False, b"ab")]
    # While a packet is in the air, the rest collects: 202 bytes at most.
    bench.send(bytes(80), then_s=0.01)
    bench.send(bytes(130), then_s=0.01)
    for size in (2, 100, 100, 2):
        packet = bench.radio.outgoing.popleft()
        assert len(packet.payload) == size
        bench.radio.transmitted(packet, 0, 0)
    assert not bench.radio.outgoing


def test_api_mode_answers_commands_and_reports_packets() -> None:
    bench = Bench()
    bench.radio.registers.execute("AP", 2)
    bench.radio.registers.apply()
    assert bench.send(encode_frame(b"\x08\x01CH")) == encode_frame(b"\x88\x01CH\x00\x0c")
    assert bench.send(encode_frame(b"\x08\x01MY\x00\x07")) == encode_frame(b"\x88\x01MY\x00")
    assert bench.send(encode_frame(b"\x08\x02NH")) == encode_frame(b"\x88\x02NH\x02")
    assert bench.send(encode_frame(b"\x08\x02CH\x99")) == encode_frame(b"\x88\x02CH\x03")
    # A queued value waits.
    bench.send(encode_frame(b"\x09\x03ID\x12\x34"))
    assert bench.radio.registers["ID"] == 0x3332
    bench.send(encode_frame(b"\x08\x04AC"))
    assert bench.radio.registers["ID"] == 0x1234
    bench.radio.serial_to_send()
    assert bench.send(encode_frame(b"\x01\x05\x00\x09\x00hello")) == b""
    packet = bench.radio.outgoing.popleft()
    assert packet == Transmission(9, False, b"hello", 5)
    bench.radio.transmitted(packet, 1, 3)
    assert bench.radio.serial_to_send() == encode_frame(b"\x89\x05\x01")
    bench.radio.radio_received(9, 0x0013A20040000009, b"hi", -40)
    bench.radio.radio_received(None, 0x0013A20040000009, b"hi", -40)
    assert bench.radio.serial_to_send() == encode_frame(b"\x81\x00\x09\x28\x00hi") + encode_frame(
        b"\x80\x00\x13\xa2\x00\x40\x00\x00\x09\x28\x00hi"
    )


def test_a_mesh_knows_only_its_own_frames() -> None:
    bench = Bench(SimulatedRadio(DIGIMESH, NUMBER))
    bench.radio.registers.execute("AP", 2)
    bench.radio.registers.apply()
    bench.send(encode_frame(b"\x01\x05\x00\x09\x00hello"))
    assert not bench.radio.outgoing
    too_long = bench.send(encode_frame(b"\x10\x05" + bytes(8) + b"\xff\xfe\x00\x00" + bytes(74)))
    assert too_long == encode_frame(b"\x8b\x05\xff\xfe\x00\x74\x00")
    bench.send(encode_frame(b"\x10\x06" + NUMBER.to_bytes(8, "big") + b"\xff\xfe\x00\x00hi"))
    packet = bench.radio.outgoing.popleft()
    assert packet == Transmission(NUMBER, True, b"hi", 6, is_mesh_frame=True)
    bench.radio.transmitted(packet, 0x21, 10)
    assert bench.radio.serial_to_send() == encode_frame(b"\x8b\x06\xff\xfe\x0a\x21\x00")
    assert bench.radio.short_address is None
