from __future__ import annotations

import pytest

from rostether.errors import BoardError
from unit.simulation.simavr.conftest import Start
from unit.simulation.simavr.programs import build

pytestmark = pytest.mark.simavr

SENT = bytes(range(256)) * 4


async def echoed(start: Start, *words: str) -> bytes:
    board = await start(build("echo"), "watch serial", *words)
    await board.run("1ms")
    await board.send(SENT)
    await board.run("150ms")
    return bytes(board.serial)


async def test_none_by_default(start: Start) -> None:
    assert await echoed(start) == SENT


async def test_the_same_seed_gives_the_same_faults(start: Start) -> None:
    first = await echoed(start, "fault flip=0.05,drop=0.02,seed=3")
    assert first == await echoed(start, "fault flip=0.05,drop=0.02,seed=3")
    assert first != await echoed(start, "fault flip=0.05,drop=0.02,seed=4")
    assert first != SENT


@pytest.mark.parametrize("direction", ["to", "from"])
async def test_bytes_flip_one_bit_at_their_rate(start: Start, direction: str) -> None:
    got = await echoed(start, f"fault {direction}:flip=0.1,{direction}:seed=1")
    changed = [a ^ b for a, b in zip(SENT, got, strict=True) if a != b]
    assert len(changed) == pytest.approx(0.1 * len(SENT), rel=0.4)
    assert all(bits.bit_count() == 1 for bits in changed)


async def test_bytes_are_lost_at_their_rate(start: Start) -> None:
    got = await echoed(start, "fault to:drop=0.1,seed=2")
    assert len(SENT) - len(got) == pytest.approx(0.1 * len(SENT), rel=0.4)


@pytest.mark.parametrize("direction", ["to", "from"])
async def test_late_bytes_arrive_in_order(start: Start, direction: str) -> None:
    board = await start(build("echo"), "watch serial", f"fault {direction}:delay=1,delay_ms=3")
    await board.run("1ms")
    await board.send(b"abc")
    await board.run("2ms")
    early = bytes(board.serial)
    await board.run("20ms")
    assert board.serial == b"abc"
    # Events show the bytes that the board sent, so only bytes to the board are late.
    assert early == (b"" if direction == "to" else b"abc")


async def test_they_end_on_request(start: Start) -> None:
    assert await echoed(start, "fault flip=1", "fault none") == SENT


@pytest.mark.parametrize("words", ["flip=2", "flip=x", "speed=1", "flip", "delay_ms=-1", "up:flip=0.1"])
async def test_invalid_settings_change_nothing(start: Start, words: str) -> None:
    board = await start(build("echo"), "watch serial")
    with pytest.raises(BoardError, match="fault"):
        await board.set_faults(f"drop=1,{words}")
    await board.run("1ms")
    await board.send(b"abc")
    await board.run("5ms")
    assert board.serial == b"abc"
