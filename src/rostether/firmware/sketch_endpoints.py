"""Finds the topics and services of a sketch, and whether their messages fit in the input buffer.

It reads the program's variables first: an endpoint points to its topic and to a function whose name contains
its type. If an endpoint is constructed only at run time, the sketch's text is searched instead.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import Struct

from rostether.errors import RostetherError
from rostether.firmware.elf import ElfFile, Variable
from rostether.serde.layout import smallest_size
from rostether.serde.type_tree import TypeTrees

if TYPE_CHECKING:
    from rostether.msgdef.registry import Registry

# Longer than usual names; text that is not the topic is not read to its end.
MAX_TOPIC_BYTES = 128
# An endpoint has about ten bytes; a large variable with a matching type name is not searched.
MAX_VARIABLE_BYTES = 64

_CLASSES = {
    "ros::Publisher": "publishes",
    "ros::Subscriber": "subscribes",
    "ros::ServiceServer": "serves",
    "ros::ServiceClient": "calls",
}
_TYPES = re.compile(
    r"ros::(?:Publisher::\w+<(?P<published>[\w:]+)>"
    r"|(?:Subscriber|ServiceServer|ServiceClient)<(?P<others>[\w:]+(?:, [\w:]+)?))"
)
_NODE_HANDLE = re.compile(r"ros::NodeHandle_<[^<>]*?, (\d+), (\d+), (\d+), (\d+)")

# The index of the word `driver_` in an endpoint. Other words may equal a function's address by chance.
_DRIVER_WORD = 2


class Endpoint(Struct, frozen=True):
    """One topic or service of a sketch.

    `role` is `publishes`, `subscribes`, `serves` or `calls`. `name` is that of the variable. `smallest_bytes`
    is the size of the message with empty strings and arrays; `is_fixed` means that it has none of them.
    `incoming_bytes` must fit in the input buffer; None for an endpoint that only sends.
    """

    role: str
    name: str
    topic: str
    type_name: str
    smallest_bytes: int
    is_fixed: bool
    incoming_bytes: int | None

    def note(self, buffer_bytes: int) -> str:
        """Return whether its messages fit in the input buffer, as a phrase; empty if its size is unknown."""
        if self.incoming_bytes is None:
            return "sent without a buffer"
        if not buffer_bytes:
            return ""
        if self.incoming_bytes > buffer_bytes:
            return f"never arrives: the buffer has {buffer_bytes} bytes"
        if self.is_fixed:
            return "fits"
        left = buffer_bytes - self.incoming_bytes
        return f"fits with up to {left} bytes of strings and arrays"


def input_buffer_bytes(readable: Mapping[str, str]) -> int:
    """Return the size of the node handle's input buffer; 0 for a sketch without a node handle."""
    sizes = [int(match[3]) for name in readable.values() if (match := _NODE_HANDLE.search(name))]
    return max(sizes, default=0)


def find_endpoints(
    elf: ElfFile, readable: Mapping[str, str], registry: Registry, sources: Sequence[Path]
) -> list[Endpoint]:
    """Return a sketch's topics and services; those whose type cannot be determined are omitted."""
    variables = elf.variables
    trees = TypeTrees(registry)
    texts = (each.read_text(encoding="utf-8", errors="replace") for each in sources)
    finder = _Finder(elf, readable, variables, "".join(texts))
    found = []
    for variable in variables:
        # Compilers since version 7 add the arguments of the template.
        role = _CLASSES.get(variable.type_name.partition("<")[0])
        if role is None:
            continue
        types = finder.types(variable)
        with suppress(RostetherError):
            if types:
                found.append(_endpoint(role, variable.name, finder.topic(variable), types, trees))
    roles = list(_CLASSES.values())
    return sorted(found, key=lambda each: (roles.index(each.role), each.topic or each.name))


class _Finder:
    def __init__(
        self, elf: ElfFile, readable: Mapping[str, str], variables: Sequence[Variable], text: str
    ) -> None:
        self._elf = elf
        self._text = text
        self._types = {each.name: each.type_name for each in variables}
        self._sizes = {each.address: each.size for each in elf.symbols if each.size}
        self._functions = {
            each.address // 2: readable.get(each.name, each.name)
            for each in elf.symbols
            if each.section == ".text"
        }

    def types(self, variable: Variable) -> list[str]:
        """Return the types of an endpoint, `package::Name`: one, or a service's two."""
        drivers = islice(self._words(variable), _DRIVER_WORD, _DRIVER_WORD + 1)
        for name in (variable.type_name, *(self._functions.get(each, "") for each in drivers)):
            match = _TYPES.search(name)
            if match is not None:
                return _message_types(match["published"] or match["others"])
        declared = re.search(rf"<\s*([\w:,\s]+?)\s*>\s*{re.escape(variable.name)}\s*[({{]", self._text)
        if declared is not None:
            return _message_types(declared[1])
        given = re.search(rf"\b{re.escape(variable.name)}\s*\(\s*\"[^\"]*\"\s*,\s*&\s*(\w+)", self._text)
        name = self._types.get(given[1], "") if given is not None else ""
        return [name] if name else []

    def topic(self, variable: Variable) -> str:
        """Return an endpoint's topic name, or an empty string."""
        data = self._elf.section(".data")
        for word in self._words(variable):
            address = (data.address & ~0xFFFF | word) if data is not None else 0
            text = self._elf.read_at(address, MAX_TOPIC_BYTES).partition(b"\0")
            if text[1] and re.fullmatch(rb"[~/]?[A-Za-z][\w/]*", text[0]):
                return text[0].decode("ascii")
        given = re.search(rf"\b{re.escape(variable.name)}\s*\(\s*\"([^\"]*)\"", self._text)
        return given[1] if given is not None else ""

    def _words(self, variable: Variable) -> Iterator[int]:
        size = min(self._sizes.get(variable.address, 0), MAX_VARIABLE_BYTES)
        data = self._elf.read_at(variable.address, size)
        return (data[i] | data[i + 1] << 8 for i in range(0, len(data) - 1, 2))


def _message_types(text: str) -> list[str]:
    # After a subscriber's message type comes the class whose member function is called.
    parts = [each.strip() for each in text.split(",")]
    return [each for each in parts if each.count("::") == 1 and not each.startswith("ros::")]


def _endpoint(role: str, name: str, topic: str, types: Sequence[str], trees: TypeTrees) -> Endpoint:
    """Return an endpoint. Raises RostetherError if a type has no definition."""
    incoming = {"publishes": None, "subscribes": 0, "serves": 0, "calls": -1}[role]
    messages = [trees.struct(each.replace("::", "/")) for each in types]
    counted = messages[incoming or 0]
    size_bytes = smallest_size(counted)
    type_name = messages[0].name
    if role in ("serves", "calls"):
        type_name = re.sub(r"(Request|Response)$", "", type_name)
    return Endpoint(
        role=role,
        name=name,
        topic=topic,
        type_name=type_name,
        smallest_bytes=size_bytes,
        is_fixed=counted.fixed_size_bytes is not None,
        incoming_bytes=None if incoming is None else size_bytes,
    )
