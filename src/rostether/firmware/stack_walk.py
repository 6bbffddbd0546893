"""Computes the stack use of a piece of AVR code, and its calls.

It follows all paths through the code and keeps the deepest stack at each instruction.
A function that needs a frame loads the stack pointer into r28, subtracts the size of the frame, and stores
the result in the stack pointer. So the size is known if the walk has seen that r28 was loaded.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import takewhile

from msgspec import Struct, field

from rostether.firmware.avr_code import Instruction, Op, decode
from rostether.firmware.avr_pointers import pointer_kind, table_of_jump

# More than the RAM of any AVR; it stops the walk in code that pushes in a loop.
MAX_DEPTH_BYTES = 65536

_FRAME_POINTER = 28
_SHARED_REGISTERS = 18
# libgcc's `__prologue_saves__` pushes r2 to r17, r28 and r29, with two bytes of code each, from its start;
# then it subtracts X from the stack pointer and continues at Z, after the jump.
_SHARED_PROLOGUE = "__prologue_saves__"
_SHARED_EPILOGUE = "__epilogue_restores__"
# A large `switch`: continues at one of the labels in a table in flash.
_TABLE_JUMP = "__tablejump"


class Walk(Struct):
    """The stack use of one function: its own deepest stack, and its calls with the stack at each.

    `calls` has the targets; `indirect` the calls through pointers, by the result of `pointer_kind`.
    `is_unknown`: the stack pointer gets a value that is computed at run time.
    """

    depth_bytes: int = 0
    calls: dict[int, int] = field(default_factory=dict)
    indirect: dict[int, int] = field(default_factory=dict)
    enables_interrupts: bool = False
    is_unknown: bool = False


class Code(Struct, frozen=True):
    """The flash of a program, the starts and sizes of its functions, and the length of a return address.

    Old compilers put the tables of labels of large `switch` statements below `tables_end`.
    """

    flash: bytes
    entries: dict[int, str]
    sizes: dict[int, int]
    tables_end: int
    return_bytes: int

    def shared(self, target: int, name: str, size: int) -> int | None:
        """Return the number of registers that a shared sequence of libgcc handles from a target on."""
        start = next((address for address, each in self.entries.items() if each == name), None)
        if start is None or not start <= target <= start + size:
            return None
        return _SHARED_REGISTERS - (target - start) // 2

    def labels(self, entry: int, jump: int) -> list[int]:
        """Return the possible targets of the table jump at `jump`, all inside its function."""
        inside = range(entry + 2, entry + self.sizes.get(entry, 0), 2)
        table = table_of_jump(self.flash, jump)
        labels = [] if table is None else list(takewhile(inside.__contains__, self._words(table)))
        # In a damaged file, the size may be gigabytes: a set of the range would fill the memory.
        return sorted({each for each in labels or self._words(0, self.tables_end) if each in inside})

    def _words(self, start: int, end: int | None = None) -> Iterator[int]:
        """Return the code addresses in a part of the flash, as if all of it were a table."""
        last = len(self.flash) - 1
        offsets = range(start, last if end is None else min(end, last), 2)
        return (2 * int.from_bytes(self.flash[offset : offset + 2], "little") for offset in offsets)


_State = tuple[int, int | None]


def walk(code: Code, entry: int) -> Walk:
    """Return the stack use of the function at an entry."""
    return _Walker(code, entry).run()


class _Walker:
    """Follows all paths through one function."""

    def __init__(self, code: Code, entry: int) -> None:
        self._code = code
        self._entry = entry
        self._found = Walk()

    def run(self) -> Walk:
        found, flash = self._found, self._code.flash
        deepest: dict[int, int] = {}
        pending: list[tuple[int, _State]] = [(self._entry, (0, None))]
        while pending:
            address, (depth, frame) = pending.pop()
            if depth > MAX_DEPTH_BYTES:
                found.is_unknown = True
                continue
            if deepest.get(address, -1) >= depth or address >= len(flash):
                continue
            deepest[address] = depth
            for target, state in self._step(address, decode(flash, address), (depth, frame)):
                found.depth_bytes = max(found.depth_bytes, state[0])
                pending.append((target, state))
        return found

    def _step(self, address: int, instruction: Instruction, state: _State) -> list[tuple[int, _State]]:
        """Return the possible next instructions, each with its stack."""
        flash, following = self._code.flash, address + instruction.size
        match instruction.op:
            case Op.RETURN:
                return []
            case Op.INDIRECT_JUMP:
                self._add(self._found.indirect, pointer_kind(flash, address), state[0])
                return []
            case Op.JUMP:
                return self._jump(address, instruction, state)
            case Op.BRANCH:
                return [(following, state), (instruction.target, state)]
            case Op.SKIP:
                return [(following, state), (following + decode(flash, following).size, state)]
        return [(following, self._stack_after(address, instruction, state))]

    def _stack_after(self, address: int, instruction: Instruction, state: _State) -> _State:
        """Return the stack after an instruction that does not jump."""
        depth, frame = state
        match instruction.op:
            case Op.PUSH:
                return depth + 1, frame
            case Op.POP:
                return max(depth - 1, 0), frame
            case Op.READ_STACK_POINTER:
                return depth, depth
            case Op.MOVE_FRAME | Op.MOVE_FRAME_HIGH:
                return depth, None if frame is None else _moved(frame, depth, instruction)
            case Op.WRITE_STACK_POINTER:
                if frame is not None and instruction.register == _FRAME_POINTER:
                    return max(frame, 0), frame
                self._found.is_unknown = True
            case Op.CALL:
                return self._depth_after_call(address, instruction, depth), frame
            case Op.INDIRECT_CALL:
                kind = pointer_kind(self._code.flash, address)
                self._add(self._found.indirect, kind, depth + self._code.return_bytes)
            case Op.ENABLE_INTERRUPTS:
                self._found.enables_interrupts = True
        return state

    def _depth_after_call(self, address: int, call: Instruction, depth: int) -> int:
        if call.target == address + call.size:  # rcall .+0 makes room for a frame
            return depth + self._code.return_bytes
        if call.target:  # otherwise the function is undefined, and the call is never reached
            self._add(self._found.calls, call.target, depth + self._code.return_bytes)
        return depth

    def _jump(self, address: int, instruction: Instruction, state: _State) -> list[tuple[int, _State]]:
        target, depth = instruction.target, state[0]
        pushed = self._code.shared(target, _SHARED_PROLOGUE, 2 * _SHARED_REGISTERS)
        if pushed is not None:
            depth += pushed + _frame_in_x(self._code, address)
            return [(address + instruction.size, (depth, depth))]
        if self._code.shared(target, _SHARED_EPILOGUE, 2 * _SHARED_REGISTERS) is not None:
            return []
        if target == 0:
            return []  # the program begins again
        if self._code.entries.get(target, "").startswith(_TABLE_JUMP):
            return [(label, state) for label in self._code.labels(self._entry, address)]
        if target in self._code.entries and target != self._entry:
            # A tail call.
            self._add(self._found.calls, target, depth)
            return []
        return [(target, state)]

    def _add(self, calls: dict[int, int], target: int, depth: int) -> None:
        calls[target] = max(calls.get(target, 0), depth)
        self._found.depth_bytes = max(self._found.depth_bytes, depth)


def _moved(frame: int, depth: int, instruction: Instruction) -> int:
    if instruction.op is Op.MOVE_FRAME:
        return frame - instruction.value
    # subi has eight bits; its carry and sbci complete the number. subi r28, low / sbci r29, high subtract one
    # number: the frame's size to grow the stack, or its complement to 65536 to shrink it.
    total = frame - depth + (-instruction.value << 8)
    return depth + (total - 0x10000 if total >= 0x8000 else total)


def _frame_in_x(code: Code, address: int) -> int:
    """Return the size of the frame that was loaded into r26 and r27 just before a jump."""
    low = high = 0
    for back in range(14, 0, -2):
        instruction = decode(code.flash, address - back)
        if instruction.op is Op.LOAD and instruction.register == 26:
            low = instruction.value
        if instruction.op is Op.LOAD and instruction.register == 27:
            high = instruction.value
    return high << 8 | low
