from __future__ import annotations

import asyncio

import click
import pytest

from rostether.cli.board import console
from rostether.simulation.simavr.board_events import BoardEvent

TEXT = BoardEvent("serial", 1.5, {"data": b"abc".hex()})


async def test_an_incomplete_line_is_printed_when_the_sketch_pauses(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(console, "LINE_GAP_S", 0.0)
    printer = console.EventPrinter(as_json=False)
    printer.show(TEXT)
    printer.show(TEXT)
    assert capsys.readouterr().out == ""
    await asyncio.sleep(0.01)
    assert '"abcabc"' in capsys.readouterr().out


async def test_a_closed_pipe_ends_the_command_with_the_next_event(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise click.exceptions.Exit(0)

    monkeypatch.setattr(console, "LINE_GAP_S", 0.0)
    monkeypatch.setattr(console, "write_result", fail)
    printer = console.EventPrinter(as_json=False)
    printer.show(TEXT)
    await asyncio.sleep(0.01)
    with pytest.raises(click.exceptions.Exit):
        printer.show(TEXT)
