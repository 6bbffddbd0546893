"""A field of a topic as a source of numbers: a value of a board becomes a sensor with a name and a unit."""

from __future__ import annotations

from collections.abc import AsyncGenerator
from contextlib import aclosing

from rostether.errors import ConfigError
from rostether.graph.typed_graph import TypedGraph
from rostether.serde.field_path import FieldPath


async def topic_values(graph: TypedGraph, topic: str, field: str) -> AsyncGenerator[float, None]:
    """Yield a field of each message, such as `range` or `pose/position/x`; true is 1.

    Raises ConfigError if the topic's type has no such field, or if the field is not a number; GraphError.
    """
    async with aclosing(aiter(graph.messages(topic))) as messages:
        path: FieldPath | None = None
        async for message in messages:
            if path is None:
                path = FieldPath(graph.store.codec(message._type), field)
            value = path.read(message)
            if not isinstance(value, int | float):
                raise ConfigError(f"{topic}: {field} is not a number, but {value!r:.50}")
            yield float(value)
