from __future__ import annotations

import asyncio
import os
import sys
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path

import pytest

from rostether.errors import ConfigError, TransportOpenError
from rostether.transports import pty
from rostether.transports.address import PtyAddress
from rostether.transports.pty import PtyTransport, open_pty
from unit.transports.recorder import Recorder
from waiting import until

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


@asynccontextmanager
async def terminal_at(link: Path) -> AsyncIterator[tuple[PtyTransport, Recorder]]:
    transport, recorder = open_pty(PtyAddress(str(link))), Recorder()
    transport.start(recorder)
    try:
        yield transport, recorder
    finally:
        transport.close()
        await transport.wait_closed()


@contextmanager
def opened(link: Path) -> Iterator[int]:
    board = os.open(link, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        yield board
    finally:
        os.close(board)


async def write_until_taken(transport: PtyTransport, data: bytes, board: int) -> None:
    """Write as soon as the transport has detected that a program opened the terminal."""
    await until(lambda: transport._is_open)
    transport.write(data)
    assert await read(board, len(data)) == data


async def read(board: int, count: int) -> bytes:
    data = bytearray()

    def more() -> bool:
        try:
            data.extend(os.read(board, 65536))
        except BlockingIOError:
            return False
        return len(data) >= count

    await until(more)
    return bytes(data)


async def test_carry_all_bytes_raw_both_ways(tmp_path: Path) -> None:
    every_byte = bytes(range(256))
    async with terminal_at(tmp_path / "board") as (transport, seen):
        with opened(tmp_path / "board") as board:
            os.write(board, every_byte)
            await seen.until_received(every_byte)
            await write_until_taken(transport, every_byte, board)
        assert transport.can_pause
        assert str(tmp_path / "board") in transport.peer


async def test_boards_come_and_go_without_a_busy_loop(tmp_path: Path) -> None:
    async with terminal_at(tmp_path / "board") as (transport, seen):
        for number in range(3):
            with opened(tmp_path / "board") as board:
                os.write(board, bytes((number,)) * 3)
                await seen.until_received(b"".join(bytes((turn,)) * 3 for turn in range(number + 1)))
                await write_until_taken(transport, b"hello", board)
            await until(lambda: not transport._is_open)
            cpu_s = time.thread_time()
            await asyncio.sleep(0.2)
            assert time.thread_time() - cpu_s < 0.05
        assert not seen.losses


async def test_a_new_opener_does_not_read_what_was_written_before(tmp_path: Path) -> None:
    async with terminal_at(tmp_path / "board") as (transport, _):
        transport.write(b"nobody is there")
        assert transport.write_buffer_bytes == 0
        with opened(tmp_path / "board"):
            await until(lambda: transport._is_open)
            transport.write(b"unread by the first")
        await until(lambda: not transport._is_open)
        with opened(tmp_path / "board") as board:
            await write_until_taken(transport, b"fresh", board)


async def test_a_board_that_does_not_read_pauses_writing_and_uses_no_cpu(tmp_path: Path) -> None:
    async with terminal_at(tmp_path / "board") as (transport, seen):
        with opened(tmp_path / "board") as board:
            await until(lambda: transport._is_open)
            sent = bytearray()
            while not seen.write_pauses:
                chunk = os.urandom(4096)
                sent += chunk
                transport.write(chunk)
            assert transport.write_buffer_bytes > 0
            cpu_s = time.thread_time()
            await asyncio.sleep(0.2)
            assert time.thread_time() - cpu_s < 0.05
            assert await read(board, len(sent)) == sent
            await seen.until(lambda seen: seen.write_pauses == [True, False])
            assert transport.write_buffer_bytes == 0


async def test_a_board_that_closes_a_full_terminal_is_detected(tmp_path: Path) -> None:
    async with terminal_at(tmp_path / "board") as (transport, seen):
        with opened(tmp_path / "board"):
            await until(lambda: transport._is_open)
            while not seen.write_pauses:
                transport.write(bytes(4096))
        await until(lambda: not transport._is_open)
        assert transport.write_buffer_bytes == 0
        assert seen.write_pauses == [True, False]
        cpu_s = time.thread_time()
        await asyncio.sleep(0.2)
        assert time.thread_time() - cpu_s < 0.05


async def test_pausing_blocks_the_board_and_loses_nothing(tmp_path: Path) -> None:
    async with terminal_at(tmp_path / "board") as (transport, seen):
        with opened(tmp_path / "board") as board:
            transport.pause_reading()
            sent = bytearray()
            with pytest.raises(BlockingIOError):
                while True:
                    chunk = os.urandom(1000)
                    sent += chunk[: os.write(board, chunk)]
            await asyncio.sleep(0.1)
            assert not seen.data
            transport.resume_reading()
            await seen.until_received(bytes(sent))


async def test_bytes_before_the_end_arrive(tmp_path: Path) -> None:
    async with terminal_at(tmp_path / "board") as (_, seen):
        with opened(tmp_path / "board") as board:
            os.write(board, b"last words")
        await seen.until_received(b"last words")


async def test_close_removes_the_link_and_flushes(tmp_path: Path) -> None:
    link = tmp_path / "board"
    async with terminal_at(link) as (transport, seen):
        with opened(link) as board:
            await until(lambda: transport._is_open)
            sent = bytearray()
            while not seen.write_pauses:
                chunk = os.urandom(4096)
                sent += chunk
                transport.write(chunk)
            transport.close()
            transport.close()
            transport.write(b"too late")
            assert await read(board, len(sent)) == sent
            assert await seen.until_lost() is None
        assert not link.is_symlink()
    assert seen.losses == [None]


async def test_close_drops_data_for_a_board_that_does_not_read(tmp_path: Path) -> None:
    async with terminal_at(tmp_path / "board") as (transport, seen):
        with opened(tmp_path / "board"):
            await until(lambda: transport._is_open)
            while not seen.write_pauses:
                transport.write(bytes(4096))
            transport.close()
            assert await seen.until_lost() is None


async def test_replace_a_stale_link_but_never_a_file(tmp_path: Path) -> None:
    link = tmp_path / "board"
    link.symlink_to("/dev/pts/999999")
    async with terminal_at(link):
        assert link.is_char_device()
    precious = tmp_path / "notes.txt"
    precious.write_text("keep me")
    link.symlink_to(precious)
    for path in (precious, link):
        with pytest.raises(TransportOpenError, match="choose another path"):
            open_pty(PtyAddress(str(path)))
    assert precious.read_text() == "keep me"
    assert link.is_symlink()


async def test_the_link_points_to_the_newest_terminal(tmp_path: Path) -> None:
    link = tmp_path / "board"
    async with terminal_at(link) as (first, _):
        async with terminal_at(link) as (second, _):
            assert str(link.readlink()) == second.terminal
            first.close()
            await first.wait_closed()
            assert str(link.readlink()) == second.terminal
        assert not link.is_symlink()


async def test_a_folder_that_is_not_there_is_reported(tmp_path: Path) -> None:
    with pytest.raises(TransportOpenError, match="No such file or directory; choose another path"):
        open_pty(PtyAddress(str(tmp_path / "nowhere" / "board")))


async def test_windows_has_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pty.sys, "platform", "win32")  # type: ignore[attr-defined]
    with pytest.raises(ConfigError, match="use tcp://:11411"):
        open_pty(PtyAddress("x"))
