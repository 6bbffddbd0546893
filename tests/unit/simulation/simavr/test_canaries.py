from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import BoardError
from unit.simulation.simavr.conftest import Start
from unit.simulation.simavr.programs import build, build_text
from unit.simulation.simavr.readings import named, number

pytestmark = pytest.mark.simavr

STRINGS = """
uint8_t rounds;

void setup() { Serial.begin(57600); }

void loop() {
  String text = "Temperature: ";
  for (int i = 0; i < 40; i++) text += String(i) + ", ";
  Serial.println(text.length());
  rounds++;
}
"""


@pytest.mark.parametrize(
    ("letter", "output"), [(b"j", "jumped to its start"), (b"o", "ran past the end of its code")]
)
async def test_a_restart_without_a_reset_is_reported(start: Start, letter: bytes, output: str) -> None:
    board = await start(build("wrong"))
    await board.run("1ms")
    first = await number(board, "starts")
    await board.send(letter)
    await board.run("1ms")
    assert [output in event["text"] for event in named(board, "restart")] == [True]
    assert (await number(board, "starts") - first) & 0xFF == 1
    assert len(named(board, "reset")) == 1


@pytest.mark.parametrize(("letter", "event"), [(b"i", "bad_opcode"), (b"w", "bad_write"), (b"r", "bad_read")])
async def test_faults_of_the_program_are_reported(start: Start, letter: bytes, event: str) -> None:
    board = await start(build("wrong"), "watch serial")
    await board.run("1ms")
    assert named(board, event) == []
    await board.send(letter)
    await board.run("1ms")
    reported = named(board, event)
    assert len(reported) == 1
    assert reported[0].values.get("address") in (None, 0x4000)
    assert named(board, "restart") == []


async def test_the_deepest_stack_is_measured(start: Start) -> None:
    board = await start(build("wrong"))
    await board.run("1ms")
    before = await board.free_stack_bytes()
    assert before > 1900
    await board.send(b"d")
    await board.run("1ms")
    deep = await board.free_stack_bytes()
    assert before - 800 < deep < before - 20 * 18
    await board.run("1ms")
    assert await board.free_stack_bytes() == deep


async def test_a_stack_that_reaches_the_variables_is_reported(start: Start) -> None:
    board = await start(build("wrong"))
    await board.run("1ms")
    await board.send(b"x")
    await board.run("5ms")
    assert named(board, "stack_overflow")


async def test_freed_heap_memory_does_not_count_as_stack(start: Start) -> None:
    board = await start(build("wrong"))
    await board.run("1ms")
    before = await board.free_stack_bytes()
    await board.send(b"m")
    await board.run("5ms")
    assert await board.free_stack_bytes() == pytest.approx(before - 702, abs=64)
    assert named(board, "stack_overflow") == named(board, "stack_low") == []
    # The stack reached the freed heap, but no variable: it is near, and harmless.
    await board.send(b"D")
    await board.run("5ms")
    assert named(board, "stack_overflow") == []
    assert [event["free_bytes"] for event in named(board, "stack_low")] == [0]


async def test_a_stack_that_reaches_the_heap_is_reported(start: Start) -> None:
    board = await start(build("wrong"))
    await board.run("1ms")
    await board.send(b"M")
    await board.run("5ms")
    assert named(board, "stack_overflow") == []
    # 73 calls deep, with 1,300 bytes left.
    await board.send(b"D")
    await board.run("5ms")
    assert named(board, "stack_overflow")


async def test_a_sketch_that_uses_strings_is_not_blamed(start: Start, tmp_path: Path) -> None:
    board = await start(await build_text(tmp_path, STRINGS))
    await board.run("300ms")
    assert await number(board, "rounds") > 10
    assert named(board, "stack_overflow") == named(board, "stack_low") == []
    assert await board.free_stack_bytes() > 900


async def test_guarded_memory_reports_writes(start: Start) -> None:
    board = await start(build("wrong"))
    fence = int((await board.ask("memory fence", "memory"))["address"])
    buffer = int((await board.ask("memory buffer", "memory"))["address"])
    await board.run("1ms")
    await board.guard("fence")
    await board.guard(f"{buffer + 8:#x}..{buffer + 10:#x}")
    await board.send(b"c")
    await board.run("1ms")
    assert named(board, "guarded_write") == []
    await board.send(b"b")
    await board.run("1ms")
    assert [event["address"] - buffer for event in named(board, "guarded_write")] == [8, 9]
    await board.send(b"f")
    await board.run("1ms")
    assert named(board, "guarded_write")[-1]["address"] == fence


async def test_the_watchdog_resets(start: Start) -> None:
    board = await start(build("wrong"))
    await board.run("1ms")
    first = await number(board, "starts")
    await board.send(b"g")
    await board.run("40ms")
    assert [event["cause"] for event in named(board, "reset")] == ["power", "watchdog"]
    assert await number(board, "cause") == 0x08
    # Memory that the start does not clear is kept, and the watchdog is off again.
    assert (await number(board, "starts") - first) & 0xFF == 1


async def test_a_sleep_without_end_is_reported(start: Start) -> None:
    board = await start(build("wrong"))
    await board.run("1ms")
    await board.send(b"s")
    await board.run("2s")
    assert len(named(board, "asleep")) == 1
    await board.reset()
    await board.run("1ms")
    await board.send(b"c")
    await board.run("1ms")
    assert len(named(board, "asleep")) == 1


async def test_cycles_between_markers(start: Start) -> None:
    board = await start(build("markers"))
    await board.run("1ms")
    assert [event["cycles"] for event in named(board, "region")] == [0, 5]


@pytest.mark.parametrize("place", ["nothing", "0x100..0x90", "5..0x10000", ""])
async def test_invalid_places_are_refused(start: Start, place: str) -> None:
    board = await start(build("wrong"))
    with pytest.raises(BoardError, match="guard"):
        await board.guard(place)


async def test_memory_by_address(start: Start) -> None:
    board = await start(build("wrong"))
    assert len(await board.memory("0x100", 16)) == 16
    with pytest.raises(BoardError, match="memory"):
        await board.memory("0xffff")
