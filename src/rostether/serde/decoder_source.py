"""Writes the Python source that decodes a type: fields of constant size fused into one unpacking.

For std_msgs/Header the result is:

    def decode(b):
        v0, v1, v2, v3 = unpack_0(b, 0)                # seq, stamp, the length of frame_id
        e4 = 16 + v3
        if e4 != len(b): raise overrun
        m5 = new(class_1)
        m5.seq = v0 ...
        m5.frame_id = str(b[16:e4], 'utf-8', text_errors)
        return m5

Messages are built after all lengths were checked. So an announced length alone allocates nothing.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, Final

from rostether.serde.generated_source import attribute_store, indented
from rostether.serde.type_tree import Array, Node, Number, Stamp, Struct, Text
from rostether.serde.values import Message, MessageClasses

Decode = Callable[[bytes], Message]

# The limit of variables of inline structs in one function; further structs get their own functions.
# Otherwise, the source would grow exponentially if each type contains the next one twice.
_MAX_VARIABLES: Final = 512

# The longest fixed array whose elements become variables; for longer ones, another unpacking is cheaper.
_MAX_UNROLLED_LENGTH: Final = 64

# The limit of numbers unpacked at once: more take longer than a millisecond, and other threads have to wait.
_MANY_NUMBERS: Final = 1 << 16

_UNPACK_U32: Final = struct.Struct("<I").unpack_from

# The errors of decoding bytes with another layout.
DECODE_ERRORS: Final = (struct.error, OverflowError)


def compile_decoder(tree: Struct, classes: MessageClasses) -> Decode:
    """Return the function that decodes a payload; it raises one of DECODE_ERRORS. Raises DefinitionError."""
    source = _DecoderSource(classes)
    body = _Body(source, "0")
    value = body.struct_value(tree)
    end = body.position()
    lines = [
        "def decode(b):",
        *indented(body.reads, 4),
        f"    if {end} != len(b): raise overrun",
        *indented(body.builds, 4),
        f"    return {value}",
    ]
    text = "\n".join([*source.functions, *lines])
    exec(compile(text, f"<decoder of {tree.name}>", "exec"), source.names)  # noqa: S102
    return source.names["decode"]  # type: ignore[no-any-return]


class _DecoderSource:
    """Collects the functions of nested types, and the names that the source refers to."""

    def __init__(self, classes: MessageClasses) -> None:
        self.functions: list[str] = []
        self.names: dict[str, Any] = {
            "new": object.__new__,
            "new_stamp": classes.new_stamp,
            "time": classes.time,
            "duration": classes.duration,
            "numbers": classes.numbers,
            "view": classes.view,
            "text_errors": classes.text_errors,
            "unpack_from": struct.unpack_from,
            "unpack_in_steps": _unpack_in_steps,
            "read_texts": _read_texts,
            "read_structs": _read_structs,
            "make_empties": _make_empties,
            "overrun": struct.error,
        }
        self.has_views = classes.view is not None
        self._classes = classes
        self._bound: dict[tuple[str, str], str] = {}
        self._leaves: dict[str, int] = {}

    def message_class(self, tree: Struct) -> str:
        return self._bind("class", tree.name, lambda: self._classes.of(tree))

    def unpacking(self, codes: str) -> str:
        return self._bind("unpack", codes, lambda: struct.Struct(f"<{codes}").unpack_from)

    def iteration(self, codes: str) -> str:
        return self._bind("iterate", codes, lambda: struct.Struct(f"<{codes}").iter_unpack)

    def reader(self, tree: Struct) -> str:
        """Return the name of `read(b, o) -> (message, end)`."""
        name = self._bound.get(("read", tree.name))
        if name is None:
            body = _Body(self, "o")
            value = body.struct_value(tree)
            end = body.position()
            name = self._name("read", tree.name)
            lines = [*body.reads, *body.builds, f"return {value}, {end}"]
            self.functions += [f"def {name}(b, o):", *indented(lines, 4)]
        return name

    def many_reader(self, tree: Struct) -> str:
        """Return the name of `many(raw) -> list of messages`, for a type of constant size above zero."""
        name = self._bound.get(("many", tree.name))
        if name is None:
            body = _Body(self, "")
            value = body.struct_value(tree)
            codes, variables = body.run()
            name = self._name("many", tree.name)
            lines = [
                "found = []",
                f"for {', '.join(variables)}, in {self.iteration(codes)}(raw):",
                *indented([*body.builds, f"found.append({value})"], 4),
                "return found",
            ]
            self.functions += [f"def {name}(raw):", *indented(lines, 4)]
        return name

    def leaves(self, node: Node) -> int:
        """Return how many variables an inline value needs."""
        if isinstance(node, Struct):
            count = self._leaves.get(node.name)
            if count is None:
                count = sum(self.leaves(member.node) for member in node.members) + 1
                self._leaves[node.name] = count
            return count
        if isinstance(node, Array) and isinstance(node.element, Number):
            return node.length if node.length and node.length <= _MAX_UNROLLED_LENGTH else 1
        return 2 if isinstance(node, Stamp) else 1

    def _bind(self, kind: str, key: str, make: Callable[[], object]) -> str:
        name = self._bound.get((kind, key))
        if name is None:
            name = self._name(kind, key)
            self.names[name] = make()
        return name

    def _name(self, kind: str, key: str) -> str:
        return self._bound.setdefault((kind, key), f"{kind}_{len(self._bound)}")


class _Body:
    """The body of one function: lines that read into variables, then lines that build messages of them.

    A run is a sequence of fields of constant size that one unpacking will read.
    """

    def __init__(self, source: _DecoderSource, start: str) -> None:
        self.reads: list[str] = []
        self.builds: list[str] = []
        self._source = source
        self._start = start
        self._offset = 0
        self._codes: list[str] = []
        self._variables: list[str] = []
        self._count = 0

    def run(self) -> tuple[str, list[str]]:
        """Return the format and variables of the run, and clear it."""
        run = "".join(self._codes), self._variables
        self._codes, self._variables = [], []
        return run

    def position(self) -> str:
        """Read the run, and return the position of the next byte."""
        codes, variables = self.run()
        if codes:
            unpacking = self._source.unpacking(codes)
            self.reads.append(f"{', '.join(variables)}, = {unpacking}(b, {self._at()})")
            self._offset += struct.calcsize(f"<{codes}")
        return self._at()

    def struct_value(self, tree: Struct) -> str:
        """Return the variable that will hold the message."""
        fields = [(member.name, self._value(member.node)) for member in tree.members]
        message = self._variable("m")
        self.builds.append(f"{message} = new({self._source.message_class(tree)})")
        self.builds += [attribute_store(message, name, value) for name, value in fields]
        return message

    def _value(self, node: Node) -> str:
        """Return an expression of a value, valid once all reads are done."""
        if isinstance(node, Number):
            return self._unpacked(node.code)
        if isinstance(node, Stamp):
            return f"new_stamp({node.name}, ({self._unpacked(node.code[0])}, {self._unpacked(node.code[1])}))"
        if isinstance(node, Text):
            length = self._unpacked("I")
            start = self.position()
            end = self._end(f"{start} + {length}")
            return f"str(b[{start}:{end}], 'utf-8', text_errors)"
        if isinstance(node, Array):
            return self._varying_array(node) if node.length is None else self._fixed_array(node, node.length)
        return self._nested(node)

    def _nested(self, tree: Struct) -> str:
        if self._count + self._source.leaves(tree) <= _MAX_VARIABLES or tree.fixed_size_bytes == 0:
            return self.struct_value(tree)
        if tree.fixed_size_bytes is not None:
            return f"{self._source.many_reader(tree)}({self._unpacked(f'{tree.fixed_size_bytes}s')})[0]"
        return self._call(f"{self._source.reader(tree)}(b, {self.position()})")

    def _fixed_array(self, array: Array, length: int) -> str:
        element = array.element
        size = array.fixed_size_bytes
        if size == 0:
            return self._empties(array, length)
        if size is None:
            return self._varying_elements(element, str(length))
        if isinstance(element, Number) and self._source.has_views and element.code != "?":
            return f"view({self._unpacked(f'{size}s')}, '<{element.code}', {length}, 0)"
        if array.is_bytes:
            return self._unpacked(f"{size}s")
        if isinstance(element, Number) and length <= _MAX_UNROLLED_LENGTH:
            values = "".join(f"{self._unpacked(element.code)}, " for _ in range(length))
            return f"{self._numbers(element)}(({values}))"
        return self._elements(element, self._unpacked(f"{size}s"), length)

    def _empties(self, array: Array, length: int) -> str:
        if isinstance(array.element, Struct) and length:
            return f"make_empties({self._source.message_class(array.element)}, {length}, {length})"
        return "b''" if array.is_bytes else "[]"

    def _varying_array(self, array: Array) -> str:
        element = array.element
        count = self._unpacked("I")
        size = element.fixed_size_bytes
        if size is None:
            return self._varying_elements(element, count)
        start = self.position()
        if isinstance(element, Struct) and size == 0:
            return f"make_empties({self._source.message_class(element)}, {count}, {array.max_count})"
        end = self._end(f"{start} + {count} * {size}" if size > 1 else f"{start} + {count}")
        if isinstance(element, Number) and self._source.has_views and element.code != "?":
            return f"view(b, '<{element.code}', {count}, {start})"
        if isinstance(element, Number) and not array.is_bytes:
            at_once = f"unpack_from(f'<{{{count}}}{element.code}', b, {start})"
            in_steps = f"unpack_in_steps('{element.code}', b, {start}, {count})"
            return f"{self._numbers(element)}({at_once} if {count} <= {_MANY_NUMBERS} else {in_steps})"
        raw = f"b[{start}:{end}]"
        return raw if array.is_bytes else self._elements(element, raw)

    def _elements(self, element: Node, raw: str, length: int = 0) -> str:
        """Return an expression of the list of the elements of constant size in `raw`."""
        if isinstance(element, Struct):
            return f"{self._source.many_reader(element)}({raw})"
        if isinstance(element, Stamp):
            each = self._source.iteration(element.code)
            return f"[new_stamp({element.name}, pair) for pair in {each}({raw})]"
        assert isinstance(element, Number)
        return f"{self._numbers(element)}({self._source.unpacking(f'{length}{element.code}')}({raw}))"

    def _numbers(self, element: Number) -> str:
        """Return the function that makes an array of numbers; bools are always a list, as in genpy."""
        return "list" if element.code == "?" else "numbers"

    def _varying_elements(self, element: Node, count: str) -> str:
        start = self.position()
        if isinstance(element, Struct):
            return self._call(f"read_structs({self._source.reader(element)}, b, {start}, {count})")
        return self._call(f"read_texts(b, {start}, {count}, text_errors)")

    def _call(self, call: str) -> str:
        """Read with a call that returns a value and its end."""
        value, end = self._variable("v"), self._variable("e")
        self.reads.append(f"{value}, {end} = {call}")
        self._start, self._offset = end, 0
        return value

    def _end(self, expression: str) -> str:
        end = self._variable("e")
        self.reads.append(f"{end} = {expression}")
        self._start, self._offset = end, 0
        return end

    def _unpacked(self, code: str) -> str:
        self._codes.append(code)
        self._variables.append(self._variable("v"))
        return self._variables[-1]

    def _at(self) -> str:
        if self._start == "0":
            return str(self._offset)
        return f"{self._start} + {self._offset}" if self._offset else self._start

    def _variable(self, prefix: str) -> str:
        self._count += 1
        return f"{prefix}{self._count - 1}"


def _unpack_in_steps(code: str, data: bytes, start: int, count: int) -> list[Any]:
    numbers: list[Any] = []
    size = struct.calcsize(f"<{code}")
    for first in range(0, count, _MANY_NUMBERS):
        step = min(_MANY_NUMBERS, count - first)
        numbers += struct.unpack_from(f"<{step}{code}", data, start + first * size)
    return numbers


def _read_texts(payload: bytes, at: int, count: int, errors: str) -> tuple[list[str], int]:
    """Read strings; return them and their end."""
    texts = []
    for _ in range(count):
        start = at + 4
        at = start + _UNPACK_U32(payload, at)[0]
        texts.append(str(payload[start:at], "utf-8", errors))
    return texts, at


def _read_structs(
    read: Callable[[bytes, int], tuple[Message, int]], payload: bytes, at: int, count: int
) -> tuple[list[Message], int]:
    """Read messages of varying size; return them and their end."""
    messages = []
    for _ in range(count):
        message, at = read(payload, at)
        messages.append(message)
    return messages, at


def _make_empties(message_class: type[Message], count: int, limit: int) -> list[Message]:
    """Return messages of a type without content."""
    if count > limit:
        raise struct.error
    return [message_class() for _ in range(count)]
