from __future__ import annotations

from collections.abc import Callable
from itertools import islice, permutations, product

import pytest

from effort import effort
from rostether.rosserial import topic_id as ids
from rostether.rosserial.baud_probe import USUAL_BAUDS, BaudProbe, BoardFound, NoBoard
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.packets import TopicInfo
from unit.rosserial.uart_line import garbled

CHATTER = TopicInfo(125, "chatter", "std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", 280)

# The longest search: each usual rate is tried in all three passes.
LIMIT_S = 35.0


def answer(version: int = 2) -> bytes:
    """Return a board's answer to a topic request."""
    return encode_frame(ids.TIME, bytes(8), version) + encode_frame(ids.PUBLISHER, CHATTER.encode(), version)


class Device:
    """A device behind a port, with a clock that the test advances; it receives and sends at one rate.

    Until `deaf_until_s` its bootloader runs; `talks` is sent in each period without a request.
    """

    def __init__(
        self,
        baud: int,
        *,
        version: int = 2,
        deaf_until_s: float = 0.0,
        delay_s: float = 0.01,
        talks: Callable[[int], bytes] | None = None,
        period_s: float = 0.1,
        talks_until_s: float = float("inf"),
        answers: bool = True,
    ) -> None:
        self.baud = baud
        self.version = version
        self.deaf_until_s = deaf_until_s
        self.delay_s = delay_s
        self.talks = talks
        self.period_s = period_s
        self.talks_until_s = talks_until_s
        self.answers = answers
        self.asked: list[tuple[float, int, bytes]] = []

    def hears(self, data: bytes, now_s: float, line_baud: int) -> bool:
        """Whether these bytes make it answer."""
        self.asked.append((now_s, line_baud, data))
        request = encode_frame(ids.TOPIC_REQUEST, b"", self.version)
        return self.answers and now_s >= self.deaf_until_s and request in garbled(data, line_baud, self.baud)


def probe_it(probe: BaudProbe, device: Device) -> float:
    """Run a probe to its end; return how long it took."""
    now_s = 0.0
    coming: list[tuple[float, bytes]] = []
    next_talk_s, talks = 0.0, 0
    probe.start(now_s)
    while probe.result is None:
        data = probe.data_to_send()
        if data and device.hears(data, now_s, probe.baud):
            coming.append((now_s + device.delay_s, answer(device.version)))
        timer_s = probe.get_timer()
        assert timer_s is not None
        dues = [timer_s, *(due_s for due_s, _ in coming)]
        if device.talks is not None and next_talk_s < device.talks_until_s:
            dues.append(next_talk_s)
        now_s = max(now_s, min(dues))
        for due in [item for item in coming if item[0] <= now_s]:
            coming.remove(due)
            probe.receive_data(garbled(due[1], device.baud, probe.baud), now_s)
        if device.talks is not None and next_talk_s <= now_s and next_talk_s < device.talks_until_s:
            probe.receive_data(garbled(device.talks(talks), device.baud, probe.baud), now_s)
            talks += 1
            next_talk_s += device.period_s
        if now_s >= timer_s:
            probe.handle_timer(now_s)
        assert now_s <= LIMIT_S
    assert probe.get_timer() is None
    assert probe.data_to_send() == b""
    return now_s


@pytest.mark.parametrize("listens_first", [False, True])
@pytest.mark.parametrize("baud", USUAL_BAUDS)
def test_every_usual_speed_is_found(baud: int, listens_first: bool) -> None:
    probe = BaudProbe(listens_first=listens_first)
    took_s = probe_it(probe, Device(baud))
    assert probe.result == BoardFound(baud, 2, answer())
    assert took_s < 7.0 + listens_first * 1.2


def test_the_likely_rates_are_found_immediately() -> None:
    for baud, limit_s in ((57600, 0.02), (115200, 0.52)):
        assert probe_it(BaudProbe(), Device(baud)) < limit_s
    assert probe_it(BaudProbe(known_baud=38400), Device(38400)) < 0.02
    assert probe_it(BaudProbe(known_baud=921600), Device(921600)) < 0.12


def test_a_board_that_changed_its_speed_since_last_time_is_found() -> None:
    probe = BaudProbe(known_baud=921600)
    probe_it(probe, Device(250000))
    assert probe.result == BoardFound(250000, 2, answer())


@pytest.mark.parametrize("baud", [57600, 115200, 2000000])
def test_a_boot_loader_is_waited_for(baud: int) -> None:
    probe = BaudProbe()
    probe_it(probe, Device(baud, deaf_until_s=2.0))
    assert isinstance(probe.result, BoardFound)
    assert probe.result.baud == baud


def test_a_slow_sketch_is_waited_for() -> None:
    probe = BaudProbe()
    probe_it(probe, Device(38400, delay_s=0.6))
    assert isinstance(probe.result, BoardFound)


@pytest.mark.parametrize("baud", [57600, 9600, 500000])
def test_protocol_version_1(baud: int) -> None:
    probe = BaudProbe()
    probe_it(probe, Device(baud, version=1))
    assert isinstance(probe.result, BoardFound)
    assert (probe.result.baud, probe.result.version) == (baud, 1)


def message(number: int) -> bytes:
    return encode_frame(125, number.to_bytes(4, "little") + bytes(range(40)))


@pytest.mark.parametrize("baud", USUAL_BAUDS)
def test_a_board_that_talks_already_is_found_by_listening(baud: int) -> None:
    device = Device(baud, talks=message, answers=False)
    probe = BaudProbe(listens_first=True)
    probe_it(probe, device)
    assert isinstance(probe.result, BoardFound)
    assert probe.result.baud == baud
    assert device.asked == []


def test_no_pair_of_speeds_makes_a_board_of_noise() -> None:
    reported = answer() + b"".join(message(number) for number in range(20)) + answer()
    pairs = product(permutations(USUAL_BAUDS, 2), (0, 3))
    # A third of the pairs is enough: it contains each gap, and each speed on both sides.
    for (sent_at, received_at), gap_bits in islice(pairs, None, None, effort(3, 1)):
        probe = BaudProbe((received_at, *(baud for baud in USUAL_BAUDS if baud != received_at)))
        probe.start(0.0)
        arrived = garbled(reported, sent_at, received_at, gap_bits=gap_bits)
        for start in range(0, len(arrived), 16):
            probe.receive_data(arrived[start : start + 16], 0.01)
        while probe.baud == received_at and probe.result is None:
            timer_s = probe.get_timer()
            assert timer_s is not None
            probe.handle_timer(timer_s)
        assert probe.result is None, (sent_at, received_at)


def test_a_noisy_line_at_a_rate_with_a_near_one_is_still_found() -> None:
    device = Device(250000, talks=lambda _number: bytes(range(100)), period_s=0.05)
    probe = BaudProbe()
    probe_it(probe, device)
    assert isinstance(probe.result, BoardFound)
    assert probe.result.baud == probe.baud == 250000


def nmea(number: int) -> bytes:
    return b"$GPGGA,1235%02d.00,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n" % (number % 60)


@pytest.mark.parametrize("baud", [9600, 4800, 115200])
def test_a_gps_is_listened_to_and_never_written_to(baud: int) -> None:
    gps = Device(baud, talks=nmea, period_s=1.0, answers=False)
    probe = BaudProbe(listens_first=True)
    probe_it(probe, gps)
    assert isinstance(probe.result, NoBoard)
    assert gps.asked == []
    if baud in USUAL_BAUDS:
        assert probe.result.text_baud == baud
        assert probe.result.text.startswith(b"$GPGGA")


def test_a_lidar_that_streams_is_never_written_to() -> None:
    lidar = Device(230400, talks=lambda number: bytes((number * 37 + each * 11) % 256 for each in range(90)))
    probe = BaudProbe(listens_first=True)
    probe_it(probe, lidar)
    assert isinstance(probe.result, NoBoard)
    assert lidar.asked == []
    assert probe.result.foreign_bytes > 1000


def test_a_boot_message_does_not_keep_a_board_from_being_asked() -> None:
    board = Device(
        57600,
        talks=lambda _number: b"rst:0x1 (POWERON_RESET),boot:0x13 (SPI_FAST_FLASH_BOOT)\r\n",
        talks_until_s=0.4,
    )
    probe = BaudProbe(listens_first=True)
    probe_it(probe, board)
    assert isinstance(probe.result, BoardFound)


def test_a_sketch_that_prints_is_shown() -> None:
    sketch = Device(115200, talks=lambda number: b"distance: %d cm\r\n" % number, answers=False)
    probe = BaudProbe()
    took_s = probe_it(probe, sketch)
    assert isinstance(probe.result, NoBoard)
    assert (probe.result.text_baud, probe.result.text[:9]) == (115200, b"distance:")
    assert took_s < 19.0


def test_silence_ends_in_bounded_time() -> None:
    probe = BaudProbe()
    assert probe_it(probe, Device(57600, answers=False)) < 19.0
    assert probe.result == NoBoard(0)
    single = BaudProbe((57600,))
    assert probe_it(single, Device(57600, answers=False)) < 4.0


def test_a_flood_is_bounded_and_nothing_is_taken_after_the_end() -> None:
    probe = BaudProbe()
    probe.start(0.0)
    for _ in range(100):
        probe.receive_data(bytes(10_000), 0.01)
    probe.receive_data(answer(), 0.02)
    assert isinstance(probe.result, BoardFound)
    assert len(probe.result.received) <= 64 * 1024
    found = probe.result
    probe.receive_data(answer(), 0.03)
    probe.handle_timer(9.0)
    assert probe.result is found
