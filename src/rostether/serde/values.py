"""ROS messages as Python values: one class for each message type, made when the type is first used.

Field values: bool, int, float, str, `rostime.Time` and `rostime.Duration`, nested messages, `bytes` for
uint8[] and char[], lists for all other arrays. Bytes of a string that are not UTF-8 are kept as lone
surrogates (`surrogateescape`), so that what was decoded encodes to the same bytes.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Any, ClassVar, Final
from weakref import WeakValueDictionary

from rostether.errors import DefinitionError, SerializationError
from rostether.msgdef.spec import FieldType
from rostether.rostime import Duration, Time
from rostether.serde.type_tree import Array, Member, Node, Number, Stamp, Struct

_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
# The characters of a value that an error shows.
_MAX_SHOWN: Final = 40


class Message:
    """One ROS message; a subclass for each type has its fields as attributes and its constants on the class.

    The constructor takes fields by keyword; missing ones are zero, and unknown ones raise SerializationError.
    Two messages are equal if their types and all fields are; as everywhere in Python, NaN equals nothing.
    Internal names start with `_`, which no field's name does.
    """

    __slots__ = ()

    # The type as `package/Name`.
    _type: ClassVar[str] = ""

    # The fields' names and types in the order of the definition.
    _fields: ClassVar[tuple[tuple[str, FieldType], ...]] = ()

    _zeros: ClassVar[tuple[tuple[str, Any], ...]] = ()

    def __init__(self, /, *unnamed: Any, **fields: Any) -> None:
        if unnamed:
            names = ", ".join(f"{name}=..." for name, _ in self._fields)
            raise TypeError(f"{self._type} takes its fields by name: {type(self).__name__}({names})")
        for name, zero in self._zeros:
            setattr(self, name, fields.pop(name) if name in fields else zero() if callable(zero) else zero)
        if fields:
            raise unknown_field(self._type, next(iter(fields)), [name for name, _ in self._fields])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Message):
            return NotImplemented
        return self._type == other._type and all(
            getattr(self, name) == getattr(other, name) for name, _ in self._fields
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the fields as a dictionary, nested messages too; it can be published."""
        return {name: _plain(getattr(self, name)) for name, _ in self._fields}

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={getattr(self, name)!r}" for name, _ in self._fields)
        return f"{self._type}({values})"

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

        def __setattr__(self, name: str, value: Any) -> None: ...


def _plain(value: Any) -> Any:
    if isinstance(value, Message):
        # A field called to_dict replaces the method.
        return Message.to_dict(value)
    if isinstance(value, list):
        return [_plain(each) for each in value]
    if hasattr(value, "tolist"):
        # A numpy array.
        return value.tobytes() if value.dtype.char == "B" else value.tolist()
    return value


class MessageClasses:
    """The message classes of one type store, each made once; a subclass may choose the classes of values."""

    base: type[Message] = Message
    time: Any = Time
    duration: Any = Duration

    # Makes a time or a duration: the arguments are its class and a pair of integers.
    new_stamp: Any = staticmethod(tuple.__new__)

    # Makes an array of numbers.
    numbers: Any = list

    # Makes an array of numbers, or bytes, from a payload, a type code, a count and an offset.
    view: Callable[[bytes, str, int, int], Any] | None = None

    # Whether a class depends on nothing but the definition, so that other stores may use it too.
    are_shared: bool = True

    # The error handler for bytes of a string that are not UTF-8.
    text_errors: str = "surrogateescape"

    def __init__(self) -> None:
        self._classes: dict[str, type[Message]] = {}

    def for_other_types(self) -> MessageClasses:
        """Return classes that make values in the same way, for another registry's types."""
        return MessageClasses()

    def of(self, tree: Struct) -> type[Message]:
        """Return the class of a message type. Raises DefinitionError for names no definition may have."""
        message_class = self._classes.get(tree.name)
        if message_class is None:
            message_class = self._shared(tree) if self.are_shared else self._make(tree)
            self._classes[tree.name] = message_class
        return message_class

    def _shared(self, tree: Struct) -> type[Message]:
        """Return the class that other stores use for an equal definition, so that `isinstance` holds."""
        key = (
            type(self),
            tree.name,
            tree.constants,
            tuple(self._member_key(member) for member in tree.members),
        )
        message_class = _SHARED.get(key)
        if message_class is None:
            message_class = _SHARED[key] = self._make(tree)
        return message_class

    def _member_key(self, member: Member) -> Hashable:
        element = member.node.element if isinstance(member.node, Array) else member.node
        return member.name, member.type, self.of(element) if isinstance(element, Struct) else None

    def _make(self, tree: Struct) -> type[Message]:
        names = tuple(member.name for member in tree.members)
        for name in names:
            if not _NAME.fullmatch(name):
                raise DefinitionError(f"{tree.name} has a field {name!r}; names are letters, digits and _")
        if len(set(names)) != len(names):
            raise DefinitionError(f"{tree.name} has two fields of the same name; rename one")
        namespace: dict[str, Any] = {
            constant.name: constant.value
            for constant in tree.constants
            if _NAME.fullmatch(constant.name) and constant.name not in names
        }
        namespace |= {
            "__slots__": names,
            "__module__": __name__,
            "_type": tree.name,
            "_fields": tuple((member.name, member.type) for member in tree.members),
            "_zeros": tuple((member.name, self._zero(member.node)) for member in tree.members),
        }
        return type(tree.name.rpartition("/")[2], (self.base,), namespace)

    def _zero(self, node: Node) -> Any:
        """Return a zero value, or a function that makes one if it is mutable."""
        if isinstance(node, Struct):
            return self.of(node)
        if isinstance(node, Number):
            return False if node.code == "?" else 0.0 if node.code in "fd" else 0
        if isinstance(node, Stamp):
            return self.time() if node.name == "time" else self.duration()
        if not isinstance(node, Array):
            return ""
        if node.is_bytes:
            return bytes(node.length or 0)
        if not node.length:
            return list
        length, element = node.length, self._zero(node.element)
        if callable(element):
            return lambda: [element() for _ in range(length)]
        return lambda: [element] * length


# The classes in use, by how values are made and by definition.
_SHARED: WeakValueDictionary[Hashable, type[Message]] = WeakValueDictionary()


def unknown_field(type_name: str, field: object, known: list[str]) -> SerializationError:
    """Return the error for a field that a type does not have."""
    has = f"it has {', '.join(known)}" if known else "it has no fields"
    return SerializationError(f"{type_name} has no field {_show(field)}; {has}")


def misfit_error(type_name: str, path: str, wanted: str, got: object) -> SerializationError:
    """Return the error for a value that does not fit a field, or the whole type if the path is empty."""
    subject = f"field '{path}' of {type_name}" if path else type_name
    return SerializationError(f"{subject} needs {wanted}, got {_show(got)}")


def _show(value: object) -> str:
    """Return a value for an error text, short enough for one line."""
    # numpy shows an array with several dimensions on several lines.
    text = " ".join(line.strip() for line in repr(value).splitlines())
    return text if len(text) <= _MAX_SHOWN else f"{text[: _MAX_SHOWN - 3]}..."
