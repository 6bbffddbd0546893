"""`msg show` and `srv show` of ROS 2 definitions, as `ros2 interface show` prints them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from enum import Enum, auto
from itertools import islice
from typing import TYPE_CHECKING, Any, Final

from rostether.errors import DefinitionError
from rostether.msgdef.resolve_types import SpecT, dependencies
from rostether.msgdef.ros2.definition_text import message_text
from rostether.msgdef.ros2.parse import SECTION_MARK, parse_message
from rostether.msgdef.ros2.primitives import PRIMITIVE_TYPES
from rostether.msgdef.ros2.spec import Ros2Message, Ros2Service
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.type_hash import message_hash, service_hash

if TYPE_CHECKING:
    from rostether.msgdef.registry import Registry

# Real types have at most about 200 lines. Four fields of the next type on each of 24 levels make 10^14 lines.
MAX_SHOWN_LINES: Final = 10_000


class Comments(Enum):
    """Which comments and empty lines are shown."""

    NONE = auto()
    # The comments of the type itself, as `ros2 interface show` does.
    OWN = auto()
    # The comments of the type and of the types of its fields.
    ALL = auto()


def shown(
    registry: Registry, group: str, name: str, comments: Comments = Comments.OWN, *, raw: bool = False
) -> str:
    """Return the text of a message, service or action, with each field's type below the field.

    With `raw`, return the original text. Raises UnknownTypeError, DefinitionError.
    """
    native = _native(registry)
    is_action = group == "action"
    found = native.definitions.action(name).action if is_action else _found(registry, group, name)
    text = native.definitions.file_text(found.full_name)
    if text is None:
        text = f"{SECTION_MARK}\n".join(message_text(part) for part in found.parts)
    if raw:
        return text.removesuffix("\n")
    for part in found.parts[1:]:
        dependencies(part, native.ros2_message)
    lines = _lines(native, text, found.package, comments, "")
    return shown_definition(found.parts[0], native.ros2_message, lines).removesuffix("\n")


def type_hash(registry: Registry, group: str, name: str) -> str:
    """Return the type hash, which both ends of a topic or service must have.

    Raises UnknownTypeError, DefinitionError.
    """
    found = _found(registry, group, name)
    source = _native(registry).source
    if isinstance(found, Ros2Message):
        return message_hash(found, source)
    return service_hash(found, source)


def record(registry: Registry, group: str, name: str) -> dict[str, Any]:
    """Return a definition for `--json`. Raises UnknownTypeError, DefinitionError."""
    found = _found(registry, group, name)
    base = {"type": found.full_name, "type_hash": type_hash(registry, group, name)}
    if isinstance(found, Ros2Message):
        return {**base, **_described(found)}
    return {**base, "request": _described(found.request), "response": _described(found.response)}


def _native(registry: Registry) -> NativeRegistry:
    assert isinstance(registry, NativeRegistry)
    return registry


def _found(registry: Registry, group: str, name: str) -> Ros2Message | Ros2Service:
    native = _native(registry)
    return native.ros2_message(name) if group == "msg" else native.ros2_service(name)


def _described(message: Ros2Message) -> dict[str, Any]:
    return {
        "constants": [{"type": c.type, "name": c.name, "value": c.value} for c in message.constants],
        "fields": [
            {"type": str(field.type), "name": field.name, "default": field.default}
            for field in message.fields
        ],
    }


def _lines(
    registry: NativeRegistry, text: str, package: str, comments: Comments, indent: str
) -> Iterator[str]:
    for line in text.removesuffix("\n").split("\n"):
        declaration = line.partition("#")[0].rstrip()
        shown_line = declaration if comments is Comments.NONE else line.rstrip()
        if shown_line or comments is not Comments.NONE:
            yield f"{indent}{shown_line}" if shown_line else ""
        if declaration == SECTION_MARK:
            continue
        for field in parse_message(declaration, package=package, name="Line").fields:
            if field.type.base not in PRIMITIVE_TYPES:
                below = registry.ros2_message(field.type.base)
                of_below = Comments.ALL if comments is Comments.ALL else Comments.NONE
                found = registry.source.text(below.full_name)
                yield from _lines(registry, found, below.package, of_below, f"{indent}\t")


def shown_definition(spec: SpecT, lookup: Callable[[str], SpecT], lines: Iterable[str]) -> str:
    """Return the lines of a definition as one text.

    Raises UnknownTypeError, and DefinitionError for a type inside itself or for too many lines.
    """
    dependencies(spec, lookup)
    shown = list(islice(lines, MAX_SHOWN_LINES + 1))
    if len(shown) > MAX_SHOWN_LINES:
        raise DefinitionError(
            f"{spec.full_name} has more than {MAX_SHOWN_LINES} lines with the types of all its fields; "
            "show the types of single fields instead"
        )
    return "".join(f"{line}\n" for line in shown)
