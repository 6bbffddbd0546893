from __future__ import annotations

import asyncio
import os
import pty
import sys
import termios

import pytest

from rostether.cli.shell.keys import split_keys, typed_keys

KNOWN = (b"\033[A", b"\033[5~", b"j", b"q")
TIMEOUT_S = 60.0


async def test_keys_arrive_as_they_are_pressed_and_the_terminal_is_restored(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    leader, follower = pty.openpty()
    came: asyncio.Queue[bytes] = asyncio.Queue()
    with os.fdopen(leader, "wb", buffering=0) as keyboard, os.fdopen(follower) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        before = termios.tcgetattr(follower)
        with typed_keys(came.put_nowait) as has_keys:
            assert has_keys
            keyboard.write(b"l")
            assert await asyncio.wait_for(came.get(), TIMEOUT_S) == b"l"
        assert termios.tcgetattr(follower) == before


async def test_a_pipe_has_no_keys(monkeypatch: pytest.MonkeyPatch) -> None:
    reading, writing = os.pipe()
    os.close(writing)
    with os.fdopen(reading) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        with typed_keys(lambda _typed: None) as has_keys:
            assert not has_keys


@pytest.mark.parametrize(
    ("typed", "keys"),
    [
        (b"", []),
        (b"jj", [b"j", b"j"]),
        (b"\033[A\033[5~q", [b"\033[A", b"\033[5~", b"q"]),
        (b"\033xz", [b"\033", b"x", b"z"]),
    ],
)
def test_split_keys(typed: bytes, keys: list[bytes]) -> None:
    assert split_keys(typed, KNOWN) == keys
