"""Reads the parameters of a node, and checks the types of their values."""

from __future__ import annotations

from collections.abc import Mapping

from rostether.errors import ConfigError
from rostether.graph.ports import ParamValue
from rostether.graph.typed_graph import TypedGraph


class NodeParameters:
    """Reads `~name`, else the name with each of `other_prefixes`, in order.

    Each method gets the default and the names of a parameter, which may have several spellings. A value of
    another type, or outside the range, raises ConfigError.
    """

    def __init__(self, graph: TypedGraph, *other_prefixes: str) -> None:
        self._graph = graph
        self._prefixes = ("~", *other_prefixes)

    async def value(self, default: ParamValue, *names: str) -> ParamValue:
        """Return the first parameter that is set, of any type."""
        for name in names:
            for prefix in self._prefixes:
                if await self._graph.has_param(f"{prefix}{name}"):
                    return await self._graph.get_param(f"{prefix}{name}")
        return default

    async def text(self, default: str, *names: str) -> str:
        """Return the value as text."""
        return str(await self.value(default, *names))

    async def flag(self, default: bool, *names: str, accepts_integers: bool = False) -> bool:
        """Return true or false; with `accepts_integers`, 0 is false and other integers are true."""
        value = await self.value(default, *names)
        if accepts_integers and isinstance(value, int):
            return bool(value)
        if not isinstance(value, bool):
            raise ConfigError(f"~{names[0]} must be true or false, not {value!r:.200}")
        return value

    async def number(self, default: float, *names: str) -> float:
        """Return a number."""
        return as_number(await self.value(default, *names), f"~{names[0]}")

    async def integer(self, default: int, lowest: int, highest: int, *names: str) -> int:
        """Return an integer from `lowest` to `highest`."""
        value = await self.value(default, *names)
        if isinstance(value, bool) or not isinstance(value, int) or not lowest <= value <= highest:
            raise ConfigError(
                f"~{names[0]} must be a whole number from {lowest} to {highest}, not {value!r:.200}"
            )
        return value

    async def texts(self, *names: str) -> tuple[str, ...]:
        """Return a list of texts, which may be one text with commas."""
        value = await self.value("", *names)
        texts = [str(each) for each in value] if isinstance(value, list) else str(value).split(",")
        return tuple(stripped for each in texts if (stripped := each.strip()))

    async def mapping(self, *names: str) -> Mapping[str, ParamValue]:
        """Return a mapping of names to values, empty if it is not set."""
        value = await self.value({}, *names)
        if not isinstance(value, dict):
            raise ConfigError(f"~{names[0]} must map names to values, not {value!r:.200}")
        return value


def as_number(value: ParamValue, what: str) -> float:
    """Return a value as a number. Raises ConfigError, which calls the value `what`."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigError(f"{what} must be a number, not {value!r:.200}")
    return float(value)
