"""Each finding, with its real cause: a board with that fault, at the doctor's line.

The clock is virtual, so a minute of examination takes no time. Findings that need a real port are in the
tests of the command.
"""

from __future__ import annotations

import asyncio
import random
import struct
from collections.abc import Callable

import pytest

from rostether.bridge.findings.finding import Code
from rostether.bridge.health.doctor import Diagnosis, Doctor
from rostether.errors import TransportOpenError
from rostether.rosserial.device_link import DeviceLinkConfig
from rostether.rosserial.frame import encode_frame
from rostether.transports.address import Address, SerialAddress
from rostether.transports.address_parser import parse_address
from rostether.transports.board_keys import NO_PROOF
from rostether.transports.memory import memory_pair
from rostether.transports.port_facts import PortFacts
from rostether.transports.transport import Transport
from unit.bridge.nodes import STORE
from unit.bridge.sketch_board import SketchBoard, every, hello, overwritten_info, publish, stamped
from unit.bridge.uart_port import UartPort
from unit.bridge.virtual_time import run
from vectors.captures import load

PORT = "/dev/ttyACM0"
MakeBoard = Callable[[Transport], SketchBoard]


class SlowLine:
    """A board's end of the line, which sends bytes at the speed of its UART, four at a time."""

    can_pause = False
    has_baud = False
    write_buffer_bytes = 0

    remote: str | None = None
    proof = NO_PROOF

    def __init__(self, wire: Transport, baud: int) -> None:
        self._wire = wire
        self._baud = baud
        self._unsent = bytearray()
        self._sending: asyncio.Task[None] | None = None
        self.peer = wire.peer
        self.start = wire.start
        self.pause_reading = wire.pause_reading
        self.resume_reading = wire.resume_reading
        self.wait_closed = wire.wait_closed

    def write(self, data: bytes | bytearray | memoryview) -> None:
        self._unsent += data
        if self._unsent and self._sending is None:
            self._sending = asyncio.get_running_loop().create_task(self._send())

    def close(self) -> None:
        if self._sending is not None:
            self._sending.cancel()
        self._wire.close()

    async def _send(self) -> None:
        while self._unsent:
            piece = bytes(self._unsent[:4])
            del self._unsent[:4]
            await asyncio.sleep(10 * len(piece) / self._baud)
            self._wire.write(piece)
        self._sending = None


class Bench:
    """A port with a board at `board_baud`; each time it is opened, the same board is connected again."""

    def __init__(self, make_board: MakeBoard | None, board_baud: int = 57600) -> None:
        self._make_board = make_board
        self._board_baud = board_baud
        self._board: SketchBoard | None = None

    async def open(self, address: Address) -> Transport:
        assert isinstance(address, SerialAddress)
        wire, board_end = memory_pair(can_pause=False)
        await self.close()
        if self._make_board is not None:
            self._board = self._make_board(board_end).plug_in()
        return UartPort(wire, address.baud, self._board_baud)

    async def close(self) -> None:
        if self._board is not None:
            await self._board.unplug()


def diagnose(
    make_board: MakeBoard | None, *, watch_s: float = 8.0, baud: int = 57600, board_baud: int = 57600
) -> Diagnosis:
    async def main() -> Diagnosis:
        bench = Bench(make_board, board_baud)

        async def facts(path: str) -> PortFacts:
            return PortFacts(path)

        doctor = Doctor(STORE, watch_s=watch_s, read_facts=facts, open_transport=bench.open)
        try:
            return await doctor.examine(parse_address(f"{PORT}?baud={baud}"))
        finally:
            await bench.close()

    return run(main())


def codes(diagnosis: Diagnosis) -> list[Code]:
    return [finding.code for finding in diagnosis.findings]


def talker(transport: Transport, **faults: object) -> SketchBoard:
    faults.setdefault("turn", every(0.1, publish("chatter", hello)))
    return SketchBoard(transport, **faults).publisher("chatter")  # type: ignore[arg-type]


def test_a_healthy_board() -> None:
    diagnosis = diagnose(talker)
    assert diagnosis.findings == ()
    assert diagnosis.is_ok
    assert diagnosis.board is not None
    (endpoint,) = diagnosis.board.view.endpoints
    assert diagnosis.board.rate_hz(endpoint) == pytest.approx(10, abs=1)


def test_nothing_received() -> None:
    diagnosis = diagnose(None)
    (finding,) = diagnosis.findings
    assert finding.code is Code.NOTHING_RECEIVED
    assert "any other usual baud rate" in finding.seen
    assert "cable carries data" in finding.next_step
    assert diagnosis.board is None


def test_a_sketch_that_prints_text() -> None:
    def board(transport: Transport) -> SketchBoard:
        printing = SketchBoard(transport, turn=every(1.0, lambda it: it.write(b"Temperature: 21.5 C\r\n")))
        printing.data_received = lambda data: None  # type: ignore[method-assign]
        return printing

    (finding,) = diagnose(board).findings
    assert finding.code is Code.TEXT_RECEIVED
    assert "'Temperature: 21.5 C" in finding.seen
    assert "Serial.print" in finding.seen


def test_text_at_another_baud_rate() -> None:
    def board(transport: Transport) -> SketchBoard:
        printing = SketchBoard(transport, turn=every(0.2, lambda it: it.write(b"Temperature: 21.5 C\r\n")))
        printing.data_received = lambda data: None  # type: ignore[method-assign]
        return printing

    (finding,) = diagnose(board, board_baud=9600).findings
    assert finding.code is Code.TEXT_RECEIVED
    assert "at 9600 baud" in finding.seen
    assert "Temperature" in finding.seen


@pytest.mark.parametrize("right", [115200, 9600, 250000, 500000, 1000000, 2000000])
def test_wrong_baud_and_the_right_one(right: int) -> None:
    diagnosis = diagnose(talker, board_baud=right)
    assert codes(diagnosis) == [Code.WRONG_BAUD]
    assert f"{right} baud, not" in diagnosis.findings[0].seen
    assert f"?baud={right}" in diagnosis.findings[0].next_step
    assert diagnosis.board is not None
    assert diagnosis.baud == right


def test_noise_that_is_not_a_board() -> None:
    rng = random.Random(7)

    def board(transport: Transport) -> SketchBoard:
        noisy = SketchBoard(transport, turn=every(0.1, lambda it: it.write(rng.randbytes(40))))
        noisy.data_received = lambda data: None  # type: ignore[method-assign]
        return noisy

    (finding,) = diagnose(board).findings
    assert finding.code is Code.NOISE_RECEIVED


def test_protocol_version_1() -> None:
    diagnosis = diagnose(lambda transport: talker(transport, config=DeviceLinkConfig(version=1)))
    assert codes(diagnosis) == [Code.PROTOCOL_VERSION]
    assert "version 1" in diagnosis.findings[0].seen


def test_an_unknown_version() -> None:
    frame = bytearray(encode_frame(125, b"hello"))
    frame[1] = 0xFC

    def board(transport: Transport) -> SketchBoard:
        modern = SketchBoard(transport, turn=every(0.1, lambda it: it.write(bytes(frame))))
        modern.data_received = lambda data: None  # type: ignore[method-assign]
        return modern

    (finding, *_) = diagnose(board).findings
    assert finding.code is Code.PROTOCOL_VERSION
    assert "version byte 0xfc" in finding.seen


@pytest.mark.parametrize("percent", [2, 10])
def test_damaged_frames(percent: int) -> None:
    rng = random.Random(3)

    def spoil(data: bytes) -> bytes:
        if len(data) < 9 or rng.random() * 100 > percent:
            return data
        place = rng.randrange(2, len(data))
        return data[:place] + bytes((data[place] ^ 0x10,)) + data[place + 1 :]

    def board(transport: Transport) -> SketchBoard:
        return talker(transport, garble=spoil, turn=every(0.01, publish("chatter", hello)))

    diagnosis = diagnose(board, watch_s=20.0)
    (finding,) = [each for each in diagnosis.findings if each.code is Code.FRAMES_DAMAGED]
    reported = float(finding.seen.split(" %")[0])
    assert reported == pytest.approx(percent, rel=0.6)


@pytest.mark.parametrize("period_s", [0.7, 1.5, 3.0, 4.0])
def test_a_board_that_resets_in_a_loop(period_s: float) -> None:
    diagnosis = diagnose(lambda transport: talker(transport, reset_every_s=period_s))
    assert Code.RESET_LOOP in codes(diagnosis)


def test_a_reset_loop_with_the_output_of_the_board() -> None:
    text = b"\r\nBrownout detector was triggered\r\n\r\nets Jun  8 2016 00:22:57\r\n"
    diagnosis = diagnose(lambda transport: talker(transport, reset_every_s=3.0, boot_text=text))
    (finding,) = [each for each in diagnosis.findings if each.code is Code.RESET_LOOP]
    assert "Brownout detector was triggered" in finding.seen


def test_ram_that_is_overwritten() -> None:
    def spill(board: SketchBoard) -> None:
        board.write(overwritten_info())

    diagnosis = diagnose(lambda transport: talker(transport, turn=every(2.0, spill)))
    (finding,) = [each for each in diagnosis.findings if each.code is Code.RAM_OVERFLOW]
    assert "temp\\x00\\x17" in finding.seen
    assert "smaller buffers" in finding.next_step


def test_stale_headers_of_an_earlier_message() -> None:
    def board(transport: Transport) -> SketchBoard:
        # sensor_msgs/BatteryState before the field `temperature` was added.
        stale = "476f837fa6771f6e16e3bf4ef96f8770"
        return talker(transport).publisher("battery", "sensor_msgs/BatteryState", stale)

    diagnosis = diagnose(board)
    assert codes(diagnosis) == [Code.STALE_HEADERS]
    finding = diagnosis.findings[0]
    assert finding.subject == "sensor_msgs/BatteryState"
    ours = STORE.registry.message_type("sensor_msgs/BatteryState").md5sum
    for part in ("battery", "476f837fa6771f6e16e3bf4ef96f8770", ours, "lacks 'float32 temperature'"):
        assert part in finding.seen
    assert "generate its message headers again" in finding.next_step


def test_an_unknown_type() -> None:
    def board(transport: Transport) -> SketchBoard:
        return talker(transport).publisher("arm", "my_robot/Arm", "0" * 32)

    (finding,) = diagnose(board).findings
    assert finding.code is Code.UNKNOWN_TYPE
    assert "my_robot" in finding.seen
    assert "--msg-path" in str(finding)


@pytest.mark.parametrize("loop_s", [0.3, 0.8, 1.7])
def test_a_slow_loop(loop_s: float) -> None:
    diagnosis = diagnose(
        lambda transport: talker(transport, loop_s=loop_s).subscriber("led"),
        watch_s=20.0,
    )
    (finding,) = [each for each in diagnosis.findings if each.code is Code.SLOW_LOOP]
    assert "late by" in finding.seen
    late_ms = float(finding.seen.split("late by ")[1].split(" ms")[0])
    assert late_ms <= loop_s * 1000 + 50


def test_a_loop_that_sleeps_a_second_is_reported_only_for_listeners() -> None:
    assert diagnose(lambda transport: talker(transport, loop_s=1.0)).is_ok
    diagnosis = diagnose(lambda transport: talker(transport, loop_s=1.0).subscriber("led"))
    assert codes(diagnosis) == [Code.SLOW_LOOP]


def test_a_fast_loop_is_not_reported() -> None:
    assert diagnose(lambda transport: talker(transport, loop_s=0.05)).is_ok


def test_an_output_buffer_too_small_for_a_topic() -> None:
    config = DeviceLinkConfig(output_buffer_bytes=280)
    diagnosis = diagnose(
        lambda transport: talker(transport, config=config).publisher("imu", "sensor_msgs/Imu")
    )
    assert codes(diagnosis) == [Code.BUFFER_TOO_SMALL]
    assert diagnosis.findings[0].subject == "imu"
    assert "280" in diagnosis.findings[0].seen


def test_an_input_buffer_too_small_for_a_topic() -> None:
    config = DeviceLinkConfig(input_buffer_bytes=60)
    diagnosis = diagnose(
        lambda transport: talker(transport, config=config).subscriber(
            "goal", "geometry_msgs/PoseWithCovariance"
        )
    )
    assert codes(diagnosis) == [Code.BUFFER_TOO_SMALL]
    assert diagnosis.findings[0].subject == "goal"


def long_text(size: int) -> Callable[[SketchBoard], None]:
    payload = struct.pack("<I", size - 4) + b"a line of text, \xff and \xc3\xa9 in it\n".ljust(size - 4, b"x")
    return lambda board: board.write(encode_frame(board.ids["text"], payload))


@pytest.mark.parametrize("size", [300, 511, 2000])
@pytest.mark.parametrize("baud", [9600, 57600])
def test_messages_longer_than_the_board_announced(size: int, baud: int) -> None:
    """The output, a few bytes at a time, of a board whose library does not check its own buffer."""
    config = DeviceLinkConfig(output_buffer_bytes=280)

    def board(transport: Transport) -> SketchBoard:
        slow = SlowLine(transport, baud)
        return talker(slow, config=config, turn=every(3.0, long_text(size))).publisher("text")

    diagnosis = diagnose(board, watch_s=12.0)
    (finding,) = diagnosis.findings
    assert (finding.code, finding.subject) == (Code.MESSAGES_TOO_LONG, "text")
    assert f"have {size} bytes" in finding.seen
    assert "buffer of 280" in finding.seen


def test_messages_longer_than_their_type_from_a_board_that_streams() -> None:
    config = DeviceLinkConfig(output_buffer_bytes=65535)

    def lie(board: SketchBoard) -> None:
        board.write(encode_frame(board.ids["count"], bytes(12)))

    def board(transport: Transport) -> SketchBoard:
        return SketchBoard(transport, config=config, turn=every(0.5, lie)).publisher(
            "count", "std_msgs/Int32"
        )

    (finding,) = diagnose(board).findings
    assert (finding.code, finding.subject) == (Code.MESSAGES_TOO_LONG, "count")
    assert "have 12 bytes, more than this type" in finding.seen


def test_a_service_answer_longer_than_the_board_announced() -> None:
    config = DeviceLinkConfig(output_buffer_bytes=64)

    def board(transport: Transport) -> SketchBoard:
        def answer(it: SketchBoard) -> None:
            it.write(encode_frame(halves.response_id, b"\x01" + struct.pack("<I", 100) + b"x" * 100))

        serving = SketchBoard(transport, config=config, turn=every(0.5, answer))
        service = STORE.registry.service_type("std_srvs/Trigger")
        halves = serving.link.add_service_server(
            "check", "std_srvs/Trigger", service.request.md5sum, service.response.md5sum
        )
        return serving

    (finding,) = diagnose(board).findings
    assert (finding.code, finding.subject) == (Code.MESSAGES_TOO_LONG, "check")


def test_a_board_that_reports_a_message_as_too_large() -> None:
    from rostether.rosserial.packets import LogLevel

    def complain(board: SketchBoard) -> None:
        board.link.log(LogLevel.ERROR, "Message from device dropped: message larger than buffer.")

    diagnosis = diagnose(
        lambda transport: SketchBoard(transport, turn=every(1.0, complain)).publisher("text")
    )
    (finding,) = diagnosis.findings
    assert finding.code is Code.BUFFER_TOO_SMALL
    assert finding.subject == "text"


@pytest.mark.parametrize("ppm", [5000.0, -3000.0])
def test_a_clock_that_drifts(ppm: float) -> None:
    def board(transport: Transport) -> SketchBoard:
        return SketchBoard(transport, clock_ppm=ppm, turn=every(0.05, publish("range", stamped))).publisher(
            "range", "sensor_msgs/Range"
        )

    diagnosis = diagnose(board, watch_s=20.0)
    assert codes(diagnosis) == [Code.CLOCK_DRIFT]
    assert diagnosis.board is not None
    assert diagnosis.board.clock_drift_ppm == pytest.approx(ppm, rel=0.1)


def test_messages_on_an_id_that_is_never_announced() -> None:
    def board(transport: Transport) -> SketchBoard:
        stray = encode_frame(140, struct.pack("<I", 1) + b"x")
        return talker(transport, turn=every(0.2, lambda it: it.write(stray)))

    diagnosis = diagnose(board, watch_s=15.0)
    assert Code.UNANNOUNCED_MESSAGES in codes(diagnosis)
    assert "140" in str(next(each for each in diagnosis.findings if each.code is Code.UNANNOUNCED_MESSAGES))


def test_messages_that_have_another_layout() -> None:
    def board(transport: Transport) -> SketchBoard:
        return talker(transport, turn=every(0.2, publish("chatter", lambda _: b"\x05\x00\x00\x00short")))

    def misfit(transport: Transport) -> SketchBoard:
        return talker(transport, turn=every(0.2, publish("chatter", lambda _: b"\x09\x00\x00\x00short")))

    assert diagnose(board).is_ok
    assert codes(diagnose(misfit)) == [Code.MESSAGES_MISFIT]


def test_text_between_the_frames() -> None:
    def board(transport: Transport) -> SketchBoard:
        return talker(transport, turn=every(0.5, lambda it: it.write(b"distance 42 cm\r\n")))

    (finding,) = diagnose(board).findings
    assert finding.code is Code.TEXT_BETWEEN_FRAMES
    assert "distance 42 cm" in finding.seen


def test_a_board_that_falls_silent() -> None:
    def die(board: SketchBoard) -> None:
        if board.now_s() > 1003.0:
            board.loop_s = 1e6

    diagnosis = diagnose(lambda transport: talker(transport, turn=every(0.1, die)), watch_s=10.0)
    assert codes(diagnosis) == [Code.BOARD_SILENT]


def test_a_port_that_goes_away() -> None:
    def leave(board: SketchBoard) -> None:
        if board.now_s() > 1003.0:
            board.transport.close()

    diagnosis = diagnose(lambda transport: talker(transport, turn=every(0.1, leave)))
    assert diagnosis.findings[0].code is Code.CONNECTION_LOST


def test_a_port_that_goes_away_between_two_openings() -> None:
    async def main() -> Diagnosis:
        opened = 0

        async def open_once(address: Address) -> Transport:
            nonlocal opened
            opened += 1
            if opened > 1:
                raise TransportOpenError(f"no device answers on {address}; plug it in")
            return memory_pair(can_pause=False)[0]

        async def facts(path: str) -> PortFacts:
            return PortFacts(path)

        doctor = Doctor(STORE, read_facts=facts, open_transport=open_once)
        return await doctor.examine(parse_address(PORT))

    (finding,) = run(main()).findings
    assert finding.code is Code.CANNOT_OPEN


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("boot_text", {Code.TEXT_BETWEEN_FRAMES}),
        ("damaged", {Code.FRAMES_DAMAGED}),
        ("protocol1", {Code.PROTOCOL_VERSION}),
        ("helloworld", set()),
        ("ultrasound", set()),
        ("pubsub", set()),
        ("odom", set()),
    ],
)
def test_recorded_boards(name: str, expected: set[Code]) -> None:
    """Replays the bytes of established boards, at their times."""
    capture = load(name)

    class Recording(SketchBoard):
        async def _run(self) -> None:
            began_s = asyncio.get_running_loop().time()
            for chunk in capture.of_device():
                await asyncio.sleep(began_s + chunk.time_s - asyncio.get_running_loop().time())
                self.write(chunk.data)
            await asyncio.sleep(1e6)

    diagnosis = diagnose(Recording, watch_s=min(8.0, capture.seconds - 1.0))
    assert set(codes(diagnosis)) == expected, diagnosis.findings
