"""The progress line of a recording or playback on a terminal; each update overwrites the line."""

from __future__ import annotations

import asyncio
import shutil
import sys
from typing import TYPE_CHECKING

from rostether.cli.bag.formatting import size_text
from rostether.mechanisms.text import counted

if TYPE_CHECKING:
    from rostether.recording.recorder import Recorder

# Rates are the messages and bytes of one period.
_PROGRESS_PERIOD_S = 1.0


def show(line: str) -> None:
    """Overwrite the current line, cut to the terminal's width: a second line would remain."""
    columns = shutil.get_terminal_size().columns
    sys.stderr.write(f"\r\033[K{line[: columns - 1]}")
    sys.stderr.flush()


class ProgressLine:
    """The line of a recording, with rates and sizes; nothing is written unless `is_shown`."""

    def __init__(self, *, is_shown: bool) -> None:
        self._is_shown = is_shown

    async def refresh(self, recorder: Recorder) -> None:
        """Write the line every second until canceled."""
        loop = asyncio.get_running_loop()
        began_s = before_s = loop.time()
        before = (0, 0)
        while self._is_shown:
            await asyncio.sleep(_PROGRESS_PERIOD_S)
            now_s = loop.time()
            now = (recorder.progress.message_count, recorder.size_bytes)
            rate, speed = ((new - old) / (now_s - before_s) for new, old in zip(now, before, strict=True))
            show(
                f"[{now_s - began_s:.0f} s]  {counted(now[0], 'message')}, {max(rate, 0):.0f}/s   "
                f"{size_text(now[1])}, {size_text(max(speed, 0))}/s   "
                f"{counted(recorder.topic_count, 'topic')}"
            )
            before, before_s = now, now_s

    def clear(self) -> None:
        """Erase the line before another is written."""
        if self._is_shown:
            show("")
