from __future__ import annotations

import pytest

from unit.simulation.simavr.conftest import Start
from unit.simulation.simavr.programs import build
from unit.simulation.simavr.readings import named, number

pytestmark = pytest.mark.simavr

CLOCK_HZ = 16_000_000


def real_baud(baud: int) -> float:
    """Return the bit rate of a divider with U2X."""
    return CLOCK_HZ / 8 / ((CLOCK_HZ // 4 // baud - 1) // 2 + 1)


@pytest.mark.parametrize("style", ["POLLING", "INTERRUPTS"])
@pytest.mark.parametrize("baud", [9600, 57600, 115200, 1_000_000])
async def test_both_directions_at_full_line_rate(start: Start, baud: int, style: str) -> None:
    board = await start(build("check", f"BAUD={baud}UL", style), "watch serial")
    await board.run("2ms")
    board.serial.clear()
    count = min(2000, baud // 100)
    await board.send(bytes(index & 0xFF for index in range(count)))
    await board.run("50ms")
    expected = min(count, 0.05 * real_baud(baud) / 10)
    assert await number(board, "received") == pytest.approx(expected, abs=1)
    assert (await number(board, "wrong"), await number(board, "overruns")) == (0, 0)
    assert len(board.serial) == pytest.approx(0.05 * real_baud(baud) / 10, abs=1.5)
    assert all((board.serial[i + 1] - board.serial[i]) & 0xFF == 1 for i in range(len(board.serial) - 1))


@pytest.mark.parametrize(("kind", "uart"), [("mega", None), ("leonardo", None), ("leonardo", 1), ("nano", 0)])
async def test_other_boards_echo(start: Start, kind: str, uart: int | None) -> None:
    board = await start(build("echo", board=kind), "watch serial", board=kind, uart=uart)
    await board.run("1ms")
    await board.send(b"hello, board")
    await board.run("5ms")
    assert board.serial == b"hello, board"


async def test_a_slow_program_keeps_three_bytes_and_loses_the_others(start: Start) -> None:
    board = await start(build("slow"), "watch serial")
    await board.run("1ms")
    await board.send(bytes(range(10)))
    await board.run("200ms")
    assert board.serial == bytes((0, 1, 2))
    assert await number(board, "lost") == 1
    assert sum(event["lost_bytes"] for event in named(board, "overrun")) == 7


async def test_a_slow_program_loses_none_of_three_bytes(start: Start) -> None:
    board = await start(build("slow"), "watch serial")
    await board.run("1ms")
    await board.send(b"abc")
    await board.run("40ms")
    assert board.serial == b"abc"
    assert named(board, "overrun") == []


async def test_transmission_ends_once_after_bytes_without_a_gap(start: Start) -> None:
    board = await start(build("txc", "BAUD=9600UL"), "watch serial")
    await board.run("1ms")
    assert await number(board, "ends") == 0
    await board.run("5ms")
    assert board.serial == b"ab"
    assert await number(board, "ends") == 1


async def test_bytes_are_as_long_as_their_bits(start: Start) -> None:
    board = await start(build("echo", "BAUD=9600UL"), "watch serial")
    await board.run("1ms")
    begun = await board.cycles()
    await board.send(b"x")
    while not board.serial:
        await board.run("1ms")
    # There and back, ten bits each; it is reported at the end of a slice, up to a millisecond later.
    assert (await board.cycles() - begun) / CLOCK_HZ == pytest.approx(20 / real_baud(9600), abs=0.0011)


async def test_what_is_not_hexadecimal_is_not_sent(start: Start) -> None:
    board = await start(build("echo"))
    with pytest.raises(Exception, match="hexadecimal"):
        await board.send_command("send xyz")


async def test_only_existing_uarts_can_be_chosen(start: Start) -> None:
    with pytest.raises(Exception, match="no such UART"):
        await start(build("echo"), uart=1)
