"""The parameters of one node: their values, constraints and listeners. It does no I/O."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

from msgspec import Struct, field

from rostether.errors import GraphError
from rostether.graph.callbacks import call_safely
from rostether.graph.ports import ParamValue
from rostether.ros2.parameters.typed_value import NOT_SET, ParameterType, TypedValue, typed_value

USE_SIM_TIME = "use_sim_time"

# Any node on the graph can set parameters; the largest nodes (navigation) have about a thousand.
MAX_PARAMETERS = 4096

# The limit of names that were requested but are not set; line noise can produce any number of names.
MAX_ASKED_NAMES = 256

# Real names have fewer than 100 characters.
MAX_NAME_CHARACTERS = 256

# Parameters that every node has; their type is fixed, and they cannot be deleted.
FIXED_TYPES = {USE_SIM_TIME: ParameterType.BOOL}


class Changes(Struct, frozen=True):
    """The parameters that were set or deleted together."""

    new: Mapping[str, TypedValue] = field(default_factory=dict)
    changed: Mapping[str, TypedValue] = field(default_factory=dict)
    deleted: Sequence[str] = ()

    @property
    def names(self) -> list[str]:
        """All changed names."""
        return [*self.new, *self.changed, *self.deleted]


OnChanges: TypeAlias = Callable[[Changes], None]


class OwnParameters(ABC):
    """The parameters of this program's node, and the listeners for their changes."""

    def __init__(self) -> None:
        self._listeners: list[OnChanges] = []

    @abstractmethod
    def get(self, name: str) -> TypedValue:
        """Return a value, or `NOT_SET`."""

    @abstractmethod
    def names(self) -> list[str]:
        """Return the names of all parameters that are set, sorted."""

    @abstractmethod
    def declare(self, name: str) -> None:
        """Declare a requested parameter that is not set, so that it appears in lists."""

    @abstractmethod
    def apply(self, values: Mapping[str, TypedValue]) -> None:
        """Set all the values, or none; `NOT_SET` deletes. Raises GraphError with the reason."""

    def listen(self, on_changes: OnChanges) -> None:
        """Call back after each change, until `unlisten`."""
        self._listeners.append(on_changes)

    def unlisten(self, on_changes: OnChanges) -> None:
        """Stop calling back."""
        if on_changes in self._listeners:
            self._listeners.remove(on_changes)

    def _report_changes(self, changes: Changes) -> None:
        for listener in list(self._listeners):
            call_safely("reporting changed parameters", listener, changes)


class ParameterStore(OwnParameters):
    """The parameters of one node; any name may be set to any type, and may change its type."""

    def __init__(self, initial: Mapping[str, ParamValue] | None = None) -> None:
        """Start with values from files and command lines. Raises SerializationError, GraphError."""
        super().__init__()
        self._values = {USE_SIM_TIME: TypedValue(ParameterType.BOOL, False)}
        self._asked: set[str] = set()
        self.apply({name: typed_value(name, value) for name, value in (initial or {}).items()})

    def get(self, name: str) -> TypedValue:
        """Return a value, or `NOT_SET`."""
        return self._values.get(name, NOT_SET)

    def names(self) -> list[str]:
        """Return the names of all parameters that are set, sorted."""
        return sorted(self._values)

    def declared_names(self) -> list[str]:
        """Return the names that are set or requested, sorted, as `ros2 param list` shows them."""
        return sorted({*self._values, *self._asked})

    def declare(self, name: str) -> None:
        """Declare a requested parameter that is not set, so that it appears in lists."""
        if len(self._asked) < MAX_ASKED_NAMES and name not in self._values and not _name_fault(name):
            self._asked.add(name)

    def apply(self, values: Mapping[str, TypedValue]) -> None:
        """Set all the values, or none; `NOT_SET` deletes. Raises GraphError with the reason."""
        for name, value in values.items():
            if fault := self._fault(name, value):
                raise GraphError(fault)
        added = sum(value != NOT_SET and name not in self._values for name, value in values.items())
        if len(self._values) + added > MAX_PARAMETERS:
            raise GraphError(f"a node has at most {MAX_PARAMETERS} parameters; delete some")
        changes = Changes(
            {n: v for n, v in values.items() if v != NOT_SET and n not in self._values},
            {n: v for n, v in values.items() if v != NOT_SET and n in self._values},
            [n for n, v in values.items() if v == NOT_SET and n in self._values],
        )
        for name in changes.deleted:
            del self._values[name]
        self._values |= {**changes.new, **changes.changed}
        if changes.names:
            self._report_changes(changes)

    def _fault(self, name: str, value: TypedValue) -> str:
        fixed = FIXED_TYPES.get(name)
        if fixed is not None and value.type is not fixed:
            return f"parameter {name} must be a {fixed.name.lower()}, not {value.type.name.lower()}"
        return _name_fault(name)


def _name_fault(name: str) -> str:
    if not name:
        return "a parameter needs a name"
    if len(name) > MAX_NAME_CHARACTERS:
        return f"a parameter's name has at most {MAX_NAME_CHARACTERS} characters"
    return ""
