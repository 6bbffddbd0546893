from __future__ import annotations

import random
import time

import pytest

from rostether.bridge.findings.noise import KEPT_BYTES, Noise, is_text, show
from rostether.rosserial.events import DiscardReason, FrameDiscarded
from rostether.rosserial.frame import encode_frame


def noise(data: bytes, reason: DiscardReason = DiscardReason.NOISE) -> FrameDiscarded:
    return FrameDiscarded(reason, data)


@pytest.mark.parametrize("text", ["Hello from setup()\r\n", "t=21.5\tp=1013\n", "Température: 21 °C"])
def test_printed_lines_of_sketches_are_text(text: str) -> None:
    assert is_text(text.encode())


def test_noise_is_not_text() -> None:
    rng = random.Random(5)
    assert sum(is_text(rng.randbytes(16)) for _ in range(10_000)) < 3
    assert not is_text(b"\xf8\x00\x86\xfe" * 20)
    assert not is_text(b"short")


def test_text_is_shown_in_quotes_and_noise_as_numbers() -> None:
    assert show(b"Hello from setup()") == "'Hello from setup()'"
    assert show(b"\xf8\x00\x86\xfe") == "f8 00 86 fe"
    assert len(show(b"x" * 1000)) < 70


def test_text_that_comes_byte_by_byte_between_frames_is_found() -> None:
    watched = Noise()
    for number, char in enumerate(b"distance 42 cm\r\n"):
        watched.handle_discarded(noise(bytes((char,))), number / 1000, is_alive=True)
    assert watched.text_count > 0
    assert b"distance" in watched.text


def test_the_rest_of_a_damaged_announcement_is_not_text_of_the_sketch() -> None:
    watched = Noise()
    watched.handle_discarded(noise(b"std_msgs/Em"), 1.0, is_alive=True)
    assert watched.text_count == 0
    watched.handle_discarded(noise(b"distance 42 cm\r\n"), 2.0, is_alive=True)
    assert watched.text_count > 0


def test_damaged_messages_with_text_are_not_text_of_the_sketch() -> None:
    text = b"the battery has 12.1 V, the motors are off, and the arm is at its rest position\n"
    frame = bytearray(encode_frame(125, bytes((len(text), 0, 0, 0)) + text))
    watched = Noise()
    for second in range(9):
        # A damaged sync byte: the frame arrives as noise, in two reads or in one.
        watched.handle_discarded(noise(b"\xf7" + frame[1:20]), second, is_alive=True)
        watched.handle_discarded(noise(bytes(frame[20:])), second + 0.004, is_alive=True)
        watched.handle_discarded(noise(b"\xf7" + frame[1:]), second + 0.5, is_alive=True)
        checksum = noise(bytes(frame), DiscardReason.PAYLOAD_CHECKSUM)
        watched.handle_discarded(checksum, second + 0.7, is_alive=True)
    assert watched.text_count == 0
    watched.handle_discarded(noise(b"distance 42 cm\r\n"), 10.0, is_alive=True)
    assert watched.text == b"distance 42 cm\r\n"


def test_before_the_first_frame_text_is_a_boot_message() -> None:
    watched = Noise()
    watched.handle_discarded(noise(b"ets Jun  8 2016 00:22:57"), 0.0, is_alive=False)
    assert watched.text_count == 0
    assert watched.sample == b"ets Jun  8 2016 00:22:57"


def test_a_sign_of_life_clears_the_shown_bytes() -> None:
    watched = Noise()
    watched.handle_discarded(noise(b"ets Jun  8 2016"), 0.0, is_alive=False)
    watched.note_board_frame()
    assert (watched.byte_count, watched.sample) == (0, b"")


def test_a_flood_is_kept_within_bounds() -> None:
    watched = Noise()
    for _ in range(1000):
        watched.handle_discarded(noise(b"x" * 1000), 0.0, is_alive=True)
    assert watched.byte_count == 1_000_000
    assert len(watched.sample) == KEPT_BYTES
    assert len(watched.text) <= KEPT_BYTES


@pytest.mark.parametrize(
    "line",
    [
        "Brownout detector was triggered",
        "Guru Meditation Error: Core  1 panic'ed (LoadProhibited). Exception was unhandled.",
        "rst:0x8 (TG1WDT_SYS_RESET),boot:0x13 (SPI_FAST_FLASH_BOOT)",
        "Soft WDT reset",
    ],
)
def test_crash_output_of_a_board(line: str) -> None:
    watched = Noise()
    watched.handle_discarded(
        noise(b"\x00\xffother\r\n" + line.encode() + b"\r\nmore\r\n"), 0.0, is_alive=True
    )
    assert watched.crash_line() == line[:60]
    assert Noise().crash_line() is None


def test_valid_headers_of_another_version_are_not_noise() -> None:
    frame = bytearray(encode_frame(125, b"hello"))
    frame[1] = 0xFC
    watched = Noise()
    for _ in range(3):
        assert watched.other_version is None
        watched.handle_discarded(noise(bytes(frame), DiscardReason.VERSION), 0.0, is_alive=False)
    assert watched.other_version == 0xFC


def test_the_line_of_a_crash_is_found_between_others() -> None:
    watched = Noise()
    watched.handle_discarded(
        noise(b"load:0x40\r\n  Brownout detector was triggered \r\n\r\nets Jun\n"), 0.0, is_alive=False
    )
    assert watched.crash_line() == "Brownout detector was triggered"


def test_the_last_of_several_crashes_is_reported() -> None:
    watched = Noise()
    watched.handle_discarded(noise(b"rst:0x1 (POWERON)\nabort() was called\n"), 0.0, is_alive=False)
    assert watched.crash_line() == "abort() was called"


def test_the_search_for_a_crash_is_cheap_in_noise_without_an_end_of_line() -> None:
    watched = Noise()
    watched.handle_discarded(noise(bytes(KEPT_BYTES)), 0.0, is_alive=False)
    times_s = []
    for _ in range(5):
        began_s = time.thread_time()
        assert watched.crash_line() is None
        times_s.append(time.thread_time() - began_s)
    assert min(times_s) < 0.003
