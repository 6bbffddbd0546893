"""The master's API for one node: adds the node's name to calls, and raises failures as errors."""

from __future__ import annotations

import asyncio
from typing import Any, ClassVar
from weakref import WeakKeyDictionary

from rostether.errors import GraphError, MasterUnreachableError, UnknownNameError
from rostether.ros1.environment import parse_rpc_uri
from rostether.ros1.xmlrpc_client import DEFAULT_TIMEOUT_S, MAX_IDLE_CONNECTIONS, StatusTriplet, XmlRpcClient
from rostether.xmlrpc.http_message import MAX_BODY_BYTES
from rostether.xmlrpc.values import XmlRpcValue


class MasterClient:
    """Calls to the master in the name of node `caller_id`. Raises ConfigError for an invalid URI.

    The nodes of one event loop share their connections to a master, because a master does not accept those of
    a thousand nodes. All calls raise MasterUnreachableError if the master does not answer, GraphError if it
    refuses.
    """

    def __init__(self, uri: str, caller_id: str, *, max_body_bytes: int = MAX_BODY_BYTES) -> None:
        parse_rpc_uri(uri)
        self.uri = uri
        self.caller_id = caller_id
        self._max_body_bytes = max_body_bytes
        self._connections: _Connections | None = None

    async def register_publisher(self, topic: str, type_name: str, node_uri: str) -> None:
        """Register the node as a publisher."""
        await self._call("registerPublisher", topic, type_name, node_uri)

    async def unregister_publisher(self, topic: str, node_uri: str) -> None:
        """Remove a registration."""
        await self._call("unregisterPublisher", topic, node_uri)

    async def register_subscriber(self, topic: str, type_name: str, node_uri: str) -> list[str]:
        """Register the node as a subscriber; return the URIs of the topic's publishers."""
        return _strings(await self._call("registerSubscriber", topic, type_name, node_uri))

    async def unregister_subscriber(self, topic: str, node_uri: str) -> None:
        """Remove a registration."""
        await self._call("unregisterSubscriber", topic, node_uri)

    async def register_service(self, service: str, service_uri: str, node_uri: str) -> None:
        """Register the node as the provider."""
        await self._call("registerService", service, service_uri, node_uri)

    async def unregister_service(self, service: str, service_uri: str) -> None:
        """Remove a registration."""
        await self._call("unregisterService", service, service_uri)

    async def lookup_service(self, service: str) -> str:
        """Return the rosrpc URI of a service's provider. Raises UnknownNameError."""
        return str(await self._look_up("lookupService", service))

    async def lookup_node(self, node_name: str) -> str:
        """Return the URI of a node. Raises UnknownNameError."""
        return str(await self._look_up("lookupNode", node_name))

    async def system_state(self) -> tuple[dict[str, list[str]], dict[str, list[str]], dict[str, list[str]]]:
        """Return the publishers and the subscribers of each topic, and the providers of each service."""
        answer: Any = await self._call("getSystemState")
        try:
            publishers, subscribers, services = answer
            return dict(publishers), dict(subscribers), dict(services)
        except (TypeError, ValueError):
            raise self._invalid_answer("getSystemState") from None

    async def topic_types(self) -> dict[str, str]:
        """Return the known types of topics."""
        answer: Any = await self._call("getTopicTypes")
        try:
            return dict(answer)
        except (TypeError, ValueError):
            raise self._invalid_answer("getTopicTypes") from None

    async def get_param(self, name: str) -> XmlRpcValue:
        """Return a value or tree. Raises UnknownNameError."""
        return await self._look_up("getParam", name)

    async def set_param(self, name: str, value: object) -> None:
        """Set a value or tree."""
        await self._call("setParam", name, value)

    async def delete_param(self, name: str) -> None:
        """Delete a value or tree. Raises UnknownNameError."""
        await self._look_up("deleteParam", name)

    async def has_param(self, name: str) -> bool:
        """Return whether a value or tree is set."""
        return bool(await self._call("hasParam", name))

    async def search_param(self, name: str) -> str | None:
        """Return the full name of the nearest parameter, upward from the node's name."""
        try:
            return str(await self._look_up("searchParam", name)) or None
        except UnknownNameError:
            return None

    async def param_names(self) -> list[str]:
        """Return the names of all values."""
        return _strings(await self._call("getParamNames"))

    async def subscribe_param(self, name: str, node_uri: str) -> XmlRpcValue:
        """Subscribe to changes; return the current value, an empty dict if there is none."""
        return await self._call("subscribeParam", node_uri, name)

    async def unsubscribe_param(self, name: str, node_uri: str) -> None:
        """End the subscription of `subscribe_param`."""
        await self._call("unsubscribeParam", node_uri, name)

    async def get_pid(self) -> int:
        """Return the master's process id: the cheapest check that it answers."""
        pid = await self._call("getPid")
        return pid if isinstance(pid, int) else 0

    async def close(self) -> None:
        """Close idle connections, unless other nodes use them. Idempotent; a later call opens new ones."""
        if self._connections is not None:
            connections, self._connections = self._connections, None
            await connections.release()

    async def _call(self, method: str, *args: object) -> XmlRpcValue:
        code, text, value = await self._call_status(method, *args)
        if code != 1:
            raise GraphError(f"the ROS master refused {method}: {text}")
        return value

    async def _look_up(self, method: str, name: str) -> XmlRpcValue:
        code, text, value = await self._call_status(method, name)
        if code != 1:
            raise UnknownNameError(text)
        return value

    def _invalid_answer(self, method: str) -> GraphError:
        return GraphError(
            f"the ROS master at {self.uri} sent an invalid answer to {method}; check which program listens "
            "there"
        )

    async def _call_status(self, method: str, *args: object) -> StatusTriplet:
        if self._connections is None:
            self._connections = _Connections.acquire(self.uri, self._max_body_bytes)
        return await self._connections.call_status(method, self.caller_id, *args)


class _Connections:
    """Connections of one event loop's nodes to one master; the last `release` closes them."""

    _open: ClassVar[WeakKeyDictionary[asyncio.AbstractEventLoop, dict[tuple[str, int], _Connections]]] = (
        WeakKeyDictionary()
    )

    def __init__(self, uri: str, max_body_bytes: int) -> None:
        self._key = uri, max_body_bytes
        self._users = 0
        # A burst, such as the fifty topics of a board, uses the kept connections: a new one for each call
        # would take three times as long.
        self._free_connections = asyncio.Semaphore(MAX_IDLE_CONNECTIONS)
        self._client = XmlRpcClient(
            uri,
            peer="the ROS master",
            unreachable=MasterUnreachableError,
            max_body_bytes=max_body_bytes,
            other_server_advice="; check which program listens there, and give the master with --master or "
            "ROS_MASTER_URI",
        )

    @classmethod
    def acquire(cls, uri: str, max_body_bytes: int) -> _Connections:
        """Return the connections to `uri`, or create them. Raises ConfigError for an invalid URI."""
        of_loop = cls._open.setdefault(asyncio.get_running_loop(), {})
        key = uri, max_body_bytes
        if key not in of_loop:
            of_loop[key] = cls(uri, max_body_bytes)
        of_loop[key]._users += 1
        return of_loop[key]

    async def release(self) -> None:
        """Close the connections if they have no other user."""
        self._users -= 1
        if not self._users:
            del self._open[asyncio.get_running_loop()][self._key]
            await self._client.close()

    async def call_status(self, method: str, *args: object) -> StatusTriplet:
        """Call a method.

        Raises the same errors as XmlRpcClient, and MasterUnreachableError if no connection becomes free.
        """
        try:
            async with asyncio.timeout(DEFAULT_TIMEOUT_S):
                await self._free_connections.acquire()
        except TimeoutError:
            raise MasterUnreachableError(
                f"the ROS master at {self._key[0]} does not answer; check whether it hangs"
            ) from None
        try:
            return await self._client.call_status(method, *args)
        finally:
            self._free_connections.release()


def _strings(value: XmlRpcValue) -> list[str]:
    return [each for each in value if isinstance(each, str)] if isinstance(value, list) else []
