"""Estimates for programs whose stack is known from their source."""

from __future__ import annotations

from pathlib import Path

import pytest

from rostether.firmware.boards import Board
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.elf import ElfFile
from rostether.firmware.stack import StackEstimate, estimate_stack
from unit.firmware.sketches import EMPTY, write_sketch

pytestmark = pytest.mark.avr

LEAF = """
volatile int sink;
__attribute__((noinline)) int leaf(int n) { volatile char b[300]; b[n] = n; return b[n + 1]; }
__attribute__((noinline)) int middle(int n) { volatile char b[40]; b[n] = n; return leaf(b[n]) + b[2]; }
"""


async def estimate(tmp_path: Path, text: str, board: str = "uno") -> StackEstimate:
    chosen: Board = find_board(board)
    built = await build_sketch(write_sketch(tmp_path, "S", text), chosen)
    return estimate_stack(ElfFile.read(built.elf))


@pytest.mark.parametrize("board", ["uno", "mega", "leonardo"])
async def test_frames_and_calls_add_up(tmp_path: Path, board: str) -> None:
    found = await estimate(tmp_path, LEAF + "void setup() { sink = middle(sink); }\nvoid loop() {}\n", board)
    # Both frames, three return addresses, the frame pointer twice, and a few more bytes.
    assert 340 + 10 <= found.main_bytes <= 340 + 30
    assert [name.strip("_") for name in found.main_path] == ["main", "Z6middlei", "Z4leafi"]


async def test_return_addresses_are_longer_on_large_boards(tmp_path: Path) -> None:
    text = LEAF + "void setup() { sink = middle(sink); }\nvoid loop() {}\n"
    uno, mega = await estimate(tmp_path, text), await estimate(tmp_path, text, "mega")
    assert mega.main_bytes == uno.main_bytes + 3


async def test_calls_through_pointers_count(tmp_path: Path) -> None:
    text = LEAF + (
        "typedef int (*Function)(int);\nFunction volatile table[] = { middle };\n"
        "void setup() { sink = table[sink](1); }\nvoid loop() {}\n"
    )
    assert (await estimate(tmp_path, text)).main_bytes > 340


async def test_virtual_calls_count_by_their_slot(tmp_path: Path) -> None:
    text = LEAF + (
        "struct Shape { virtual int small(int) = 0; virtual int large(int) = 0; };\n"
        "struct Disk : Shape { int small(int n) { return n; } int large(int n) { return middle(n); } };\n"
        "Disk disk; Shape* volatile shape = &disk;\n"
        "void setup() { sink = shape->SLOT(sink); }\nvoid loop() {}\n"
    )
    large = await estimate(tmp_path / "large", text.replace("SLOT", "large"))
    small = await estimate(tmp_path / "small", text.replace("SLOT", "small"))
    assert large.main_bytes > 340
    assert small.main_bytes < 340


async def test_the_cases_of_a_large_switch_count(tmp_path: Path) -> None:
    cases = "".join(f"case {index}: return analogRead({index}) * {index + 7};\n" for index in range(12))
    text = LEAF + (
        "__attribute__((noinline)) int choose(int n) { switch (n) {\n"
        f"{cases}case 12: return middle(n);\n}} return 1; }}\n"
        "void setup() { sink = choose(sink); }\nvoid loop() {}\n"
    )
    assert (await estimate(tmp_path, text)).main_bytes > 340


async def test_the_deepest_interrupt_is_added(tmp_path: Path) -> None:
    text = LEAF + "ISR(TIMER1_OVF_vect) { sink = leaf(sink); }\n" + EMPTY
    found = await estimate(tmp_path, text)
    assert found.interrupt_bytes > 300
    assert found.total_bytes == found.main_bytes + found.interrupt_bytes


async def test_constructors_of_global_objects_count(tmp_path: Path) -> None:
    text = LEAF + "struct T { T() { sink = middle(sink); } } t;\n" + EMPTY
    assert (await estimate(tmp_path, text)).main_bytes > 340


async def test_shared_prologues_of_the_c_library_count(tmp_path: Path) -> None:
    text = (
        "char text[40]; volatile int n;\n"
        'void setup() { snprintf(text, sizeof text, "%d %s", n, "x"); }\nvoid loop() {}\n'
    )
    found = await estimate(tmp_path, text)
    # With the interrupt of the clock, a simulated Uno uses 69 bytes.
    assert 65 <= found.main_bytes <= 80
    assert "vfprintf" in found.main_path


@pytest.mark.parametrize(
    ("text", "phrase"),
    [
        (
            "volatile int n; int fact(int a) { return a < 2 ? 1 : a * fact(a - 1) + fact(a - 2); }\n"
            "void setup() { n = fact(n); }\nvoid loop() {}\n",
            "_Z4facti calls itself",
        ),
        (
            "volatile int n;\nvoid setup() { volatile char* p = (char*)__builtin_alloca(n); p[n] = 1; }\n"
            "void loop() {}\n",
            "needs an amount of stack that is computed at run time",
        ),
        ("String s;\nvoid setup() { s += millis(); Serial.print(s); }\nvoid loop() {}\n", "the heap"),
        (
            "volatile int n; ISR(TIMER1_OVF_vect) { sei(); n = millis(); }\n" + EMPTY,
            "an interrupt handler enables interrupts",
        ),
    ],
)
async def test_reasons_for_a_larger_stack_are_reported(tmp_path: Path, text: str, phrase: str) -> None:
    found = await estimate(tmp_path, text)
    assert any(phrase in each for each in found.unknown)


async def test_the_stack_of_an_ordinary_sketch_is_known(tmp_path: Path) -> None:
    text = "void setup() { Serial.begin(9600); }\nvoid loop() { Serial.println(analogRead(0)); }\n"
    for board in ("uno", "mega", "leonardo"):
        assert (await estimate(tmp_path, text, board)).unknown == ()
