"""The types that a subscription of any type receives: known here, or described by the publisher's node."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

from rostether.errors import RostetherError, SerializationError, UnknownTypeError
from rostether.graph.ports import Level, Report
from rostether.ros2.naming import type_of_dds_name
from rostether.ros2.types.type_support import ANY_HASH, MessageSupport, Ros2Types

# The limit of types that a subscriber of any type learns; a topic has one type, but a peer may invent more.
MAX_DESCRIBED_TYPES = 64

# Asks a node to describe a type; the arguments are the names of node and type, and the hash. Raises
# UnknownTypeError.
Describe = Callable[[str, str, str], Awaitable[None]]


class DescribedTypes:
    """The types of one topic, by their names in the middleware and their hashes.

    `on_waiting` is called before a node is asked with `describe`, `on_found` after its answer.
    """

    def __init__(
        self,
        topic: str,
        types: Ros2Types,
        *,
        describe: Describe,
        report: Report,
        on_waiting: Callable[[], None],
        on_found: Callable[[], None],
    ) -> None:
        self._topic = topic
        self._types = types
        self._describe = describe
        self._report = report
        self._on_waiting = on_waiting
        self._on_found = on_found
        self._found: dict[str, MessageSupport | None] = {}
        self._asking: dict[str, asyncio.Task[None] | None] = {}

    @property
    def is_waiting(self) -> bool:
        """Whether a node was asked and has not answered."""
        return any(task is not None for task in self._asking.values())

    def has(self, type_name: str, type_hash: str) -> bool:
        """Return whether a type was looked up before, even without success."""
        return f"{type_name}/{type_hash}" in self._found

    def find(self, type_name: str, type_hash: str, node_name: str = "") -> MessageSupport | None:
        """Return a type; None if it is unknown, or until the node `node_name` has described it."""
        key = f"{type_name}/{type_hash}"
        if self._found.get(key) is None and key not in self._asking:
            name = type_of_dds_name(type_name)
            if len(self._found.keys() | self._asking.keys()) >= MAX_DESCRIBED_TYPES:
                return self._found.get(key)
            if node_name and self._is_unknown(name):
                self._on_waiting()
                asking = self._describe(node_name, name, type_hash)
                self._asking[key] = asyncio.ensure_future(self._find_after(asking, type_name, type_hash))
            elif key not in self._found:
                self._found[key] = self._look_up(type_name, type_hash)
        return self._found.get(key)

    def get(self, type_name: str, type_hash: str) -> MessageSupport | None:
        """Return a type that was found before, else None; may be called in any thread."""
        return self._found.get(f"{type_name}/{type_hash}")

    def close(self) -> None:
        """Stop waiting for answers."""
        for task in self._asking.values():
            if task is not None:
                task.cancel()

    def _is_unknown(self, name: str) -> bool:
        if not (name and self._types.asks_nodes):
            return False
        try:
            self._types.by_name(name)
        except UnknownTypeError:
            return True
        except RostetherError:
            pass
        return False

    async def _find_after(self, asking: Awaitable[None], type_name: str, type_hash: str) -> None:
        reason = ""
        try:
            await asking
        except UnknownTypeError as error:
            reason = f"; {error}"
        key = f"{type_name}/{type_hash}"
        self._asking[key] = None
        self._found[key] = self._look_up(type_name, type_hash, reason)
        self._on_found()

    def _look_up(self, type_name: str, type_hash: str, reason: str = "") -> MessageSupport | None:
        name = type_of_dds_name(type_name)
        try:
            if not name:
                raise SerializationError(f"{type_name!r:.200} is not the name of a type")
            support = self._types.received(name, type_hash)
        except RostetherError as error:
            self._report(Level.WARN, f"cannot receive {self._topic}: {error}{reason}")
            return None
        if support.type_hash not in (type_hash, ANY_HASH) and type_hash.startswith("RIHS"):
            self._report(
                Level.WARN,
                f"cannot receive {self._topic}: the publisher's {name} is not the known one "
                f"({type_hash:.80}, not {support.type_hash}); set ROS_DISTRO to the publisher's "
                "distribution, or give this definition with --msg-path",
            )
            return None
        return support
