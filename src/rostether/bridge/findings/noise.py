"""Bytes outside frames: text of a sketch or a bootloader, or bits at another baud rate.

They show why no board answers.
"""

from __future__ import annotations

import re

from rostether.bridge.findings.finding import Code, Finding, error
from rostether.rosserial.events import DiscardReason, FrameDiscarded

# Enough for a line that a sketch prints with Serial.print.
SHOWN_BYTES = 60

# Enough for a verdict, and for the lines that a crashed ESP prints before it restarts.
KEPT_BYTES = 512

# Random bytes form shorter runs by chance: 3 of 8 byte values are printable.
MIN_TEXT_BYTES = 8

# A board that is reset in the middle of its announcements leaves one piece of text, and noise may add some.
MIN_PIECES = 4

# One in 256 pieces of noise passes the length check of a header, but not three with the same version.
MIN_VERSIONS = 3

# At 9600 baud, the rest of an announcement arrives within this time, a few bytes at a time.
PIECE_GAP_S = 0.1

# The pattern has only the words: with whole lines, it takes 20 ms for noise without a line end.
_CRASH = re.compile(
    rb"brown-?out|wdt reset|watchdog|guru meditation|fatal exception|stack smashing|abort\(\)"
    rb"|rst cause|rst:0x",
    re.IGNORECASE,
)
_LINE_END = re.compile(rb"[\r\n]")


def is_text(data: bytes) -> bool:
    """Return whether bytes are text of a sketch: nine in ten characters printable, and not too few."""
    if len(data) < MIN_TEXT_BYTES:
        return False
    characters = data.decode("utf-8", "replace")
    printable = sum(char != "\ufffd" and (char.isprintable() or char in "\r\n\t") for char in characters)
    return printable * 10 >= len(characters) * 9


def show(data: bytes) -> str:
    """Format bytes for users: text in quotes, other bytes as numbers."""
    if is_text(data[:SHOWN_BYTES]) or (data and is_text(data)):
        return repr(data[:SHOWN_BYTES].decode("utf-8", "replace"))
    return data[:16].hex(" ")


class Noise:
    """The discarded bytes of one connection."""

    def __init__(self) -> None:
        # The number of bytes since the last frame of a rosserial board.
        self.byte_count = 0
        # How many bytes of text came between frames.
        self.text_count = 0
        # The beginning of that text.
        self.text = b""
        # The unknown version byte of valid headers.
        self.other_version: int | None = None
        self._first = bytearray()
        self._recent = bytearray()
        self._line = bytearray()
        self._pieces = 0
        self._piece_s = float("-inf")
        self._damaged_s = float("-inf")
        self._versions: dict[int, int] = {}

    @property
    def sample(self) -> bytes:
        """The first bytes since the last frame of a rosserial board."""
        return bytes(self._first)

    def handle_discarded(self, event: FrameDiscarded, now_s: float, *, is_alive: bool) -> bool:
        """Handle discarded bytes; return whether they are text. `is_alive`: frames also arrive."""
        data = event.data
        self.byte_count += len(data)
        self._first += data[: KEPT_BYTES - len(self._first)]
        self._recent += data[-KEPT_BYTES:]
        del self._recent[:-KEPT_BYTES]
        if event.reason is DiscardReason.VERSION:
            self._note_version(data)
        is_damage = event.reason is not DiscardReason.NOISE
        if not is_damage and now_s - self._damaged_s <= PIECE_GAP_S:
            # The rest of a damaged message may be text too.
            return False
        # A sketch that prints character by character still prints a line.
        self._line += data[:KEPT_BYTES]
        # The length before each string of a message has zeros.
        found = not is_damage and b"\0\0" not in self._line and is_text(bytes(self._line))
        if found and is_alive:
            self._note_text(len(data), now_s)
        if is_damage or (not found and len(self._line) >= MIN_TEXT_BYTES):
            self._damaged_s = now_s
            self._line.clear()
        del self._line[:-KEPT_BYTES]
        return found

    def note_board_frame(self) -> None:
        """Record a frame that only a rosserial board sends."""
        self.byte_count = 0
        self._first.clear()
        self._line.clear()

    def crash_line(self) -> str | None:
        """Return the line in which a board reports why it restarted, or None."""
        lines = [line for line in _LINE_END.split(bytes(self._recent)) if _CRASH.search(line)]
        return lines[-1].decode("utf-8", "replace").strip()[:SHOWN_BYTES] if lines else None

    def _note_text(self, size: int, now_s: float) -> None:
        """Treat text as printed by the sketch if it has an end of line or repeats.

        The rest of a damaged announcement is text too.
        """
        self._pieces += now_s - self._piece_s > PIECE_GAP_S
        self._piece_s = now_s
        if self.text_count or self._pieces >= MIN_PIECES or b"\n" in self._line or b"\r" in self._line:
            self.text_count += size
            self.text = self.text or bytes(self._line[:KEPT_BYTES])

    def _note_version(self, data: bytes) -> None:
        # Only headers with a correct length check count.
        if len(data) >= 5 and data[1] >= 0xF0 and sum(data[2:5]) & 0xFF == 0xFF:
            version = data[1]
            self._versions[version] = self._versions.get(version, 0) + 1
            if self._versions[version] >= MIN_VERSIONS:
                self.other_version = version


def absence(noise: Noise, baud: int | None, waited_s: float) -> Finding:
    """Return why there is no rosserial frame, based on the bytes received instead."""
    if not noise.byte_count:
        hint = f", and whether its baud rate is {baud}" if baud else ""
        return error(
            Code.NOTHING_RECEIVED,
            f"no answer from the board for {waited_s:.0f} s: no byte was received",
            "check that its sketch runs rosserial on this port (nh.initNode() in setup(), nh.spinOnce() in "
            f"loop()){hint}, and that the cable carries data",
        )
    what = (
        f"no rosserial frame for {waited_s:.0f} s, but {noise.byte_count} other bytes ({show(noise.sample)})"
    )
    if is_text(noise.sample):
        return error(
            Code.TEXT_RECEIVED,
            f"{what}: text that the sketch prints on this port (Serial.print)",
            "upload a sketch that runs rosserial, remove Serial.print from it, or print on another port",
        )
    if noise.other_version is not None:
        return error(
            Code.PROTOCOL_VERSION,
            f"{what}: frames of an unknown protocol version (version byte {noise.other_version:#04x})",
            "generate the client library again with rostether firmware lib and upload the sketch",
        )
    if baud:
        return error(
            Code.WRONG_BAUD,
            f"{what}: probably a baud rate other than {baud}",
            "give the rate of the sketch's setBaud() or Serial.begin() as ?baud=...; rostether doctor "
            "finds it",
        )
    return error(
        Code.NOISE_RECEIVED,
        what,
        "check that a rosserial board is connected here, with the same baud rate on both sides of a "
        "converter",
    )
