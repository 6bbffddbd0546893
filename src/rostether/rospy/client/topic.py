"""The common part of Publisher and Subscriber: their checks, and the table of this node's topics."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable, Hashable
from typing import Any, Protocol, TypeVar

from rostether.names.graph_name import is_legal_name
from rostether.rospy.client.message import Message
from rostether.rospy.client.names import names
from rostether.rospy.client.node import is_initialized


class _Shared(Protocol):
    handle_count: int
    resolved_name: str

    def close(self) -> None: ...


_S = TypeVar("_S", bound=_Shared)


class Topics:
    """The topics in use, each shared by all its handles."""

    def __init__(self) -> None:
        self.published: dict[Hashable, Any] = {}
        self.subscribed: dict[Hashable, Any] = {}
        self._lock = threading.RLock()

    def acquire(
        self,
        table: dict[Hashable, Any],
        key: tuple[str, type[Message]],
        make: Callable[[str, type[Message]], _S],
    ) -> tuple[_S, bool]:
        """Return the shared part of one more handle, and whether it is new."""
        found: Any
        with self._lock:
            # A node publishes a topic with one class, the first; as rospy does.
            index = key if table is self.subscribed else key[0]
            is_new = index not in table
            found = table[index] if not is_new else make(*key)
            table[index] = found
            found.handle_count += 1
        return found, is_new

    def release(self, table: dict[Hashable, Any], index: Hashable) -> None:
        """Release a handle; the last one closes the topic."""
        with self._lock:
            shared = table[index]
            shared.handle_count -= 1
            if shared.handle_count:
                return
            del table[index]
        shared.close()

    def names(self) -> list[str]:
        """Return the names of all topics, each once."""
        with self._lock:
            every = [*self.published.values(), *self.subscribed.values()]
        return list(dict.fromkeys(each.resolved_name for each in every))


topics = Topics()


class Topic:
    """Base of the handles on a topic; `resolved_name` is its full name."""

    def __init__(self, name: str, data_class: type[Message]) -> None:
        if not name or not isinstance(name, str):
            raise ValueError("topic name is not a non-empty string")
        if data_class is None:
            raise ValueError("topic parameter 'data_class' is not initialized")
        if not (isinstance(data_class, type) and issubclass(data_class, Message)):
            # ValueError, as rospy raises it.
            raise ValueError(f"data_class [{data_class}] is not a message data class")  # noqa: TRY004
        if not is_legal_name(name):
            warnings.warn(
                f"'{name}' is not a legal ROS graph resource name. "
                "This may cause problems with other ROS tools",
                stacklevel=4,
            )
        self.resolved_name = names.resolve(name) if is_initialized() else names.resolve_early(name)
        self.name = self.resolved_name
        self.data_class = data_class
        self.type = data_class._type
        self.md5sum = data_class._md5sum
