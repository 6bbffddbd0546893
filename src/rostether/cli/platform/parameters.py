"""The parameters of the platform's nodes: private ones, and the names that its first nodes read."""

from __future__ import annotations

from collections.abc import Callable

from rostether.cli.shell.output import warn, write_line
from rostether.errors import ConfigError
from rostether.graph.ports import Level, ParamValue
from rostether.graph.typed_graph import TypedGraph


class Parameters:
    """Reads `~name`, else `NODE/name` in the node's namespace, where the platform's first nodes look."""

    def __init__(self, graph: TypedGraph, node: str) -> None:
        self._graph = graph
        self._node = node

    async def value(self, default: ParamValue, *names: str) -> ParamValue:
        """Return the first parameter that is set of several spellings of its name."""
        for name in names:
            for full_name in (f"~{name}", f"{self._node}/{name}"):
                if await self._graph.raw.has_param(full_name):
                    return await self._graph.raw.get_param(full_name)
        return default

    async def text(self, default: str, *names: str) -> str:
        """Return a text."""
        return str(await self.value(default, *names))

    async def flag(self, default: bool, *names: str) -> bool:
        """Return true or false. Raises ConfigError."""
        value = await self.value(default, *names)
        if not isinstance(value, bool):
            raise ConfigError(f"~{names[0]} must be true or false, not {value!r:.200}")
        return value

    async def number(self, default: float, *names: str) -> float:
        """Return a number. Raises ConfigError."""
        value = await self.value(default, *names)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ConfigError(f"~{names[0]} must be a number, not {value!r:.200}")
        return float(value)

    async def whole(self, default: int, least: int, most: int, *names: str) -> int:
        """Return a whole number within limits. Raises ConfigError."""
        value = await self.value(default, *names)
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            raise ConfigError(f"~{names[0]} is a whole number from {least} to {most}, not {value!r:.200}")
        return value

    async def words(self, *names: str) -> tuple[str, ...]:
        """Return a list of texts, which may be one text with commas."""
        value = await self.value("", *names)
        texts = [str(each) for each in value] if isinstance(value, list) else str(value).split(",")
        return tuple(stripped for each in texts if (stripped := each.strip()))


def reporter(graph: TypedGraph) -> Callable[[Level, str], None]:
    """Return what prints a line and logs it on the graph."""

    def report(level: Level, text: str) -> None:
        graph.log(level, text)
        (warn if level > Level.INFO else write_line)(text)

    return report
