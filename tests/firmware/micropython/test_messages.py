"""The generated modules read and write messages of every type like the codec."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from random import Random
from typing import Any

from firmware.micropython.boards import PROGRAMS, run
from rostether.codegen.micropython_library import write_micropython_library
from rostether.codegen.python_names import class_name, package_name
from rostether.msgdef.registry import Registry
from rostether.rostime import Duration, Time
from rostether.serde.codec import Codec
from rostether.serde.store import TypeStore
from rostether.serde.type_tree import Array, Node, Number, Stamp, Struct
from unit.codegen.hostile import write_definitions

MAX_ELEMENTS = 3


def test_all_types_keep_their_bytes(tmp_path: Path) -> None:
    registry = Registry([write_definitions(tmp_path / "definitions")])
    written = write_micropython_library(tmp_path, registry)
    cases = list(_cases(written.library.types, TypeStore(registry), Random(1)))
    assert len(cases) > 250
    text = "".join(f"{name} {payload.hex()}\n" for name, payload in cases)
    lines = run(PROGRAMS / "again.py", written.path, text, heap="16m").splitlines()
    wrong = [
        (name, payload.hex(), line)
        for (name, payload), line in zip(cases, lines, strict=True)
        if line != payload.hex()
    ]
    assert wrong == []


def test_bytes_that_are_not_a_message_are_refused(library: Path) -> None:
    text = b"\x04\0\0\0text"
    array = "std_msgs msg Float64MultiArray  "
    cases = [
        f"std_msgs msg String  {text[:-1].hex()}",
        f"std_msgs msg String  {text.hex()}00",
        "std_msgs msg String  ffffffff",
        f"{array}ffffffff",
        f"{array}0000000000000000ffffff1f",
        "std_msgs msg Empty  00",
    ]
    lines = run(PROGRAMS / "again.py", library, "\n".join(cases) + "\n").splitlines()
    assert [line for line in lines if " too " not in line] == []
    assert len(lines) == len(cases)


def _cases(types: Sequence[str], store: TypeStore, numbers: Random) -> Iterator[tuple[str, bytes]]:
    messages = set(store.registry.messages())
    for full_name in types:
        package, _, name = full_name.partition("/")
        package, name = package_name(package), class_name(name)
        if full_name in messages:
            yield f"{package} msg {name} ", _payload(store.codec(full_name), numbers)
            continue
        for part, codec in zip(("Request", "Response"), store.service_codecs(full_name), strict=True):
            yield f"{package} srv {name} {part}", _payload(codec, numbers)


def _payload(codec: Codec, numbers: Random) -> bytes:
    return codec.encode(codec.conform(_value(codec.tree, numbers)))


def _value(node: Node, numbers: Random) -> Any:
    if isinstance(node, Struct):
        return {each.name: _value(each.node, numbers) for each in node.members}
    if isinstance(node, Array):
        count = numbers.randrange(MAX_ELEMENTS + 1) if node.length is None else node.length
        return (
            numbers.randbytes(count)
            if node.is_bytes
            else [_value(node.element, numbers) for _ in range(count)]
        )
    if isinstance(node, Stamp):
        time_class = Time if node.name == "time" else Duration
        return time_class(numbers.randrange(1 << 31), numbers.randrange(1 << 30))
    if not isinstance(node, Number):
        return "".join(chr(numbers.choice((65, 0xE9, 0x4E2D))) for _ in range(numbers.randrange(6)))
    if node.code == "?":
        return numbers.random() < 0.5
    if node.code in "fd":
        return numbers.randrange(-1000, 1000) / 8
    bits = 8 * node.fixed_size_bytes
    return numbers.getrandbits(bits) - ((1 << bits - 1) if node.code.islower() else 0)
