"""The common part of Publisher and Subscriber: their checks, and the table of this node's topics."""

from __future__ import annotations

import threading
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable
from typing import Any, Generic, TypeVar

from rostether.errors import RostetherError
from rostether.names.graph_name import is_legal_name
from rostether.rospy.client.exceptions import ROSException
from rostether.rospy.client.message import Message
from rostether.rospy.client.names import names
from rostether.rospy.client.node import is_initialized, node
from rostether.rospy.client.shutdown import is_shutdown

_E = TypeVar("_E")


class SharedTopic(ABC, Generic[_E]):
    """The state that all handles to a topic share; its endpoint exists after the node has joined."""

    verb = ""

    def __init__(self, name: str, data_class: type[Message]) -> None:
        self.resolved_name = name
        self.type = data_class._type
        self.data_class = data_class
        self.handle_count = 0
        self._endpoint: _E | None = None
        self._is_closed = False

    def open(self) -> None:
        """Create the endpoint, unless closed. Raises ROSException."""
        if self._is_closed:
            return
        try:
            self._endpoint = node.call(self._make_endpoint())
        except RostetherError as error:
            raise ROSException(f"cannot {self.verb} {self.resolved_name}: {error}") from None

    def close(self) -> None:
        """Close the endpoint; one that does not exist yet is never created."""
        self._is_closed = True
        node.forget(self.open)
        if self._endpoint is not None and not is_shutdown():
            node.call(self._close_endpoint(self._endpoint))

    @property
    def connection_count(self) -> int:
        """The number of connected nodes."""
        return 0 if self._endpoint is None else self._count_connections(self._endpoint)

    def has_connection(self, node_name: str) -> bool:
        """Return whether a node is connected."""
        return node.loop.call(self._has_connection(node_name))

    async def _has_connection(self, node_name: str) -> bool:
        return self._endpoint is not None and node_name in self._connected_nodes(self._endpoint)

    @abstractmethod
    async def _make_endpoint(self) -> _E: ...

    @abstractmethod
    async def _close_endpoint(self, endpoint: _E) -> None: ...

    @abstractmethod
    def _count_connections(self, endpoint: _E) -> int: ...

    @abstractmethod
    def _connected_nodes(self, endpoint: _E) -> list[str | None]: ...


_S = TypeVar("_S", bound=SharedTopic[Any])


class TopicTable:
    """The topics in use, each shared by all its handles."""

    def __init__(self) -> None:
        self._topics: dict[Hashable, SharedTopic[Any]] = {}
        self._lock = threading.RLock()

    def acquire(self, key: Hashable, make: Callable[[], _S]) -> tuple[_S, bool]:
        """Return the shared state for another handle, and whether the state is new."""
        found: Any
        with self._lock:
            is_new = key not in self._topics
            found = self._topics[key] = make() if is_new else self._topics[key]
            found.handle_count += 1
        return found, is_new

    def release(self, key: Hashable) -> None:
        """Release a handle; the release of the last one closes the topic."""
        with self._lock:
            shared = self._topics[key]
            shared.handle_count -= 1
            if shared.handle_count:
                return
            del self._topics[key]
        shared.close()

    def names(self) -> list[str]:
        """Return the names of all topics, each once."""
        with self._lock:
            return list(dict.fromkeys(each.resolved_name for each in self._topics.values()))


topics = TopicTable()


class Topic(Generic[_S]):
    """Base of the handles to a topic; `resolved_name` is its full name, `impl` the state that they share.

    Raises ValueError for a name or a message class that is not valid.
    """

    impl: _S | None
    _key: Hashable

    def __init__(self, name: str, data_class: type[Message]) -> None:
        if not name or not isinstance(name, str):
            raise ValueError("topic name is not a non-empty string")
        if data_class is None:
            raise ValueError("topic parameter 'data_class' is not initialized")
        if not (isinstance(data_class, type) and issubclass(data_class, Message)):
            # As in rospy, this is a ValueError.
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

    def get_num_connections(self) -> int:
        """Return the number of connected nodes."""
        return 0 if self.impl is None else self.impl.connection_count

    def unregister(self) -> None:
        """Release the topic. Idempotent."""
        impl, self.impl = self.impl, None
        if impl is not None:
            topics.release(self._key)
