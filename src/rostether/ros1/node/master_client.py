"""The master, seen from a node: its API with our name filled in, and its failures as errors."""

from __future__ import annotations

import asyncio
from typing import Any

from rostether.errors import GraphError, MasterUnreachableError, UnknownNameError
from rostether.ros1.xmlrpc_client import MAX_IDLE_CONNECTIONS, StatusTriplet, XmlRpcClient
from rostether.xmlrpc.http_message import MAX_BODY_BYTES
from rostether.xmlrpc.values import XmlRpcValue


class MasterClient:
    """Calls to the master in the name of node `caller_id`.

    All of them raise MasterUnreachableError when it does not answer, GraphError when it refuses.
    """

    def __init__(self, uri: str, caller_id: str, *, max_body_bytes: int = MAX_BODY_BYTES) -> None:
        self.uri = uri
        self.caller_id = caller_id
        # A burst, such as a board announcing fifty topics, goes over the connections that are kept:
        # opening one for each call takes three times as long.
        self._turns = asyncio.Semaphore(MAX_IDLE_CONNECTIONS)
        self._client = XmlRpcClient(
            uri,
            peer="the ROS master",
            unreachable=MasterUnreachableError,
            max_body_bytes=max_body_bytes,
            if_other="; see what listens there, and name the master with --master or ROS_MASTER_URI",
        )

    async def register_publisher(self, topic: str, type_name: str, node_uri: str) -> list[str]:
        """Register us; returns the URIs of the topic's subscribers."""
        return _strings(await self._call("registerPublisher", topic, type_name, node_uri))

    async def unregister_publisher(self, topic: str, node_uri: str) -> None:
        """Take a registration back."""
        await self._call("unregisterPublisher", topic, node_uri)

    async def register_subscriber(self, topic: str, type_name: str, node_uri: str) -> list[str]:
        """Register us; returns the URIs of the topic's publishers."""
        return _strings(await self._call("registerSubscriber", topic, type_name, node_uri))

    async def unregister_subscriber(self, topic: str, node_uri: str) -> None:
        """Take a registration back."""
        await self._call("unregisterSubscriber", topic, node_uri)

    async def register_service(self, service: str, service_uri: str, node_uri: str) -> None:
        """Register us as the provider."""
        await self._call("registerService", service, service_uri, node_uri)

    async def unregister_service(self, service: str, service_uri: str) -> None:
        """Take a registration back."""
        await self._call("unregisterService", service, service_uri)

    async def lookup_service(self, service: str) -> str:
        """Return the rosrpc URI of a service's provider. Raises UnknownNameError."""
        return str(await self._look_up("lookupService", service))

    async def lookup_node(self, node_name: str) -> str:
        """Return the URI of a node. Raises UnknownNameError."""
        return str(await self._look_up("lookupNode", node_name))

    async def system_state(self) -> tuple[dict[str, list[str]], dict[str, list[str]], dict[str, list[str]]]:
        """Return who publishes each topic, who subscribes to it, and who provides each service."""
        answer: Any = await self._call("getSystemState")
        try:
            publishers, subscribers, services = answer
            return dict(publishers), dict(subscribers), dict(services)
        except (TypeError, ValueError):
            raise GraphError(f"the ROS master at {self.uri} answered getSystemState with nonsense") from None

    async def topic_types(self) -> dict[str, str]:
        """Return the type of each topic that somebody knows."""
        answer: Any = await self._call("getTopicTypes")
        try:
            return dict(answer)
        except (TypeError, ValueError):
            raise GraphError(f"the ROS master at {self.uri} answered getTopicTypes with nonsense") from None

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
        """Tell whether a value or tree is set."""
        return bool(await self._call("hasParam", name))

    async def search_param(self, name: str) -> str | None:
        """Return the full name of the nearest parameter, upward from our own name."""
        try:
            return str(await self._look_up("searchParam", name)) or None
        except UnknownNameError:
            return None

    async def param_names(self) -> list[str]:
        """Return the names of all values."""
        return _strings(await self._call("getParamNames"))

    async def subscribe_param(self, name: str, node_uri: str) -> XmlRpcValue:
        """Subscribe to changes; returns the current value, an empty dict if there is none."""
        return await self._call("subscribeParam", node_uri, name)

    async def unsubscribe_param(self, name: str, node_uri: str) -> None:
        """End that."""
        await self._call("unsubscribeParam", node_uri, name)

    async def get_pid(self) -> int:
        """Return the master's process id: the cheapest way to see that it answers."""
        pid = await self._call("getPid")
        return pid if isinstance(pid, int) else 0

    async def close(self) -> None:
        """Close idle connections."""
        await self._client.close()

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

    async def _call_status(self, method: str, *args: object) -> StatusTriplet:
        async with self._turns:
            return await self._client.call_status(method, self.caller_id, *args)


def _strings(value: XmlRpcValue) -> list[str]:
    return [each for each in value if isinstance(each, str)] if isinstance(value, list) else []
