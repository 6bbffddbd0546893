from __future__ import annotations

import asyncio
import sys
from pathlib import Path

import pytest

from rostether.cli.shell.input_lines import input_lines


async def test_lines_of_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "commands"
    file.write_text("one\ntwo")
    with file.open() as opened:
        monkeypatch.setattr(sys, "stdin", opened)
        assert [line async for line in input_lines()] == ["one", "two"]


@pytest.mark.skipif(sys.platform == "win32", reason="has no /dev/zero")
async def test_input_without_end_leaves_the_loop_free(monkeypatch: pytest.MonkeyPatch) -> None:
    with Path("/dev/zero").open() as opened:
        monkeypatch.setattr(sys, "stdin", opened)
        reading = asyncio.ensure_future(anext(aiter(input_lines())))
        # Each turn of the loop comes only if reading gave way in the one before.
        for _ in range(100):
            await asyncio.sleep(0)
        assert not reading.done()
        reading.cancel()
        await asyncio.wait({reading})
