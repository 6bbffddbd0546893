from __future__ import annotations

import asyncio
import errno
import os
from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.transports.capture import Capture, Chunk, Entry, LinkClosed, LinkOpened
from rostether.transports.capture_writer import CaptureWriter
from rostether.transports.memory import memory_pair
from unit.transports.recorder import Recorder


class Desk:
    """A writer, and the list of what it reports."""

    def __init__(self, path: Path, limit_bytes: int = 1_000_000) -> None:
        self.reported: list[str] = []
        self.writer = CaptureWriter(
            path,
            clock=asyncio.get_running_loop().time,
            description={"note": "a test"},
            limit_bytes=limit_bytes,
            report=self.reported.append,
        )

    @property
    def entries(self) -> list[Entry]:
        return list(Capture(self.writer.path).entries())

    @property
    def bytes_of(self) -> dict[tuple[int, bool], bytes]:
        found: dict[tuple[int, bool], bytes] = {}
        for each in self.entries:
            if isinstance(each, Chunk):
                key = each.link, each.from_device
                found[key] = found.get(key, b"") + each.data
        return found


async def test_both_directions_pass_and_are_noted(tmp_path: Path) -> None:
    desk = Desk(tmp_path / "arm.jsonl")
    ours, theirs = memory_pair()
    tapped = desk.writer.tap(ours)
    host, board = Recorder(), Recorder()
    tapped.start(host)
    theirs.start(board)
    for part in (b"ask", bytearray(b"ed"), memoryview(b"!")):
        tapped.write(part)
    theirs.write(b"answer")
    await board.until_received(b"asked!")
    await host.until_received(b"answer")
    assert (tapped.peer, tapped.can_pause) == (ours.peer, True)
    tapped.close()
    await tapped.wait_closed()
    tapped.write(b"too late")
    desk.writer.close()
    desk.writer.close()
    assert desk.bytes_of == {(1, False): b"asked!", (1, True): b"answer"}
    assert isinstance(desk.entries[0], LinkOpened)
    assert isinstance(desk.entries[-1], LinkClosed)
    assert Capture(desk.writer.path).description == {"capture": "arm", "note": "a test"}
    assert desk.writer.written_bytes == desk.writer.path.stat().st_size
    assert not desk.reported


async def test_a_killed_recorder_keeps_what_it_has_written(tmp_path: Path) -> None:
    """The writer is not closed: the file has everything a moment later."""
    desk = Desk(tmp_path / "arm.jsonl")
    ours, theirs = memory_pair()
    desk.writer.tap(ours).start(Recorder())
    theirs.write(b"last words")
    async with asyncio.timeout(60):
        while desk.bytes_of.get((1, True)) != b"last words":
            await asyncio.sleep(0.01)
    desk.writer.close()


async def test_a_flood_is_written_before_the_period_is_over(tmp_path: Path) -> None:
    desk = Desk(tmp_path / "arm.jsonl", 10_000_000)
    for _ in range(100):
        desk.writer.note(1, "device", bytes(4096))
    assert desk.writer.path.stat().st_size > 700_000
    desk.writer.close()
    assert len(desk.bytes_of[1, True]) == 100 * 4096


async def test_each_link_has_its_number(tmp_path: Path) -> None:
    desk = Desk(tmp_path / "arm.jsonl")
    for word in (b"one", b"two"):
        ours, theirs = memory_pair()
        far = Recorder()
        desk.writer.tap(ours).start(far)
        theirs.write(word)
        await far.until_received(word)
        theirs.close()
        await far.until(lambda seen: bool(seen.losses))
    desk.writer.close()
    assert desk.bytes_of == {(1, True): b"one", (2, True): b"two"}
    kinds = [(type(each), each.link) for each in desk.entries if not isinstance(each, Chunk)]
    assert kinds == [(LinkOpened, 1), (LinkClosed, 1), (LinkOpened, 2), (LinkClosed, 2)]


async def test_pauses_pass_both_ways(tmp_path: Path) -> None:
    desk = Desk(tmp_path / "arm.jsonl")
    ours, theirs = memory_pair()
    tapped = desk.writer.tap(ours)
    host, board = Recorder(), Recorder()
    tapped.start(host)
    theirs.start(board)
    theirs.pause_reading()
    while not host.write_pauses:
        tapped.write(bytes(1024))
    assert tapped.write_buffer_bytes == ours.write_buffer_bytes > 0
    theirs.resume_reading()
    await host.until(lambda seen: seen.write_pauses == [True, False])
    tapped.pause_reading()
    theirs.write(b"x")
    await asyncio.sleep(0.01)
    assert not host.data
    tapped.resume_reading()
    await host.until_received(b"x")
    desk.writer.close()


async def test_the_limit_ends_the_recording_not_the_line(tmp_path: Path) -> None:
    desk = Desk(tmp_path / "arm.jsonl", 2000)
    ours, theirs = memory_pair()
    far = Recorder()
    desk.writer.tap(ours).start(far)
    for number in range(50):
        theirs.write(bytes([number]) * 20)
    await far.until(lambda seen: len(seen.data) == 1000)
    desk.writer.flush()
    assert desk.writer.path.stat().st_size <= 2000
    assert len(desk.reported) == 1
    assert "has reached 0.00191 MB: the recording has stopped" in desk.reported[0]
    recorded = desk.bytes_of[1, True]
    assert recorded
    assert bytes(far.data).startswith(recorded)
    theirs.write(b"more")
    await far.until(lambda seen: len(seen.data) == 1004)
    desk.writer.close()
    assert len(desk.reported) == 1


async def test_links_that_open_and_close_stay_within_the_limit(tmp_path: Path) -> None:
    desk = Desk(tmp_path / "arm.jsonl", 2000)
    for _ in range(50):
        ours, _ = memory_pair()
        desk.writer.tap(ours)
    assert desk.writer.path.stat().st_size <= 2000
    assert len(desk.reported) == 1
    assert sum(isinstance(each, LinkOpened) for each in desk.entries) > 10
    desk.writer.close()


async def test_a_full_disk_ends_the_recording_not_the_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk = Desk(tmp_path / "arm.jsonl")
    ours, theirs = memory_pair()
    far = Recorder()
    desk.writer.tap(ours).start(far)

    def fail(_file: int, _data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", fail)
        theirs.write(b"x")
        await far.until_received(b"x")
        desk.writer.flush()
    (reported,) = desk.reported
    assert "the recording has stopped: cannot write" in reported
    assert "No space left on device; free some space" in reported
    desk.writer.note(1, "device", b"y")
    desk.writer.close()


async def test_no_capture_is_written_over_another(tmp_path: Path) -> None:
    path = tmp_path / "arm.jsonl"
    path.write_text("precious")
    with pytest.raises(ConfigError, match="exists"):
        Desk(path)
    assert path.read_text() == "precious"
    with pytest.raises(ConfigError, match="No such file or directory"):
        Desk(tmp_path / "none" / "arm.jsonl")
