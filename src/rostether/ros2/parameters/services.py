"""A node's parameters on the graph: six services, and their changes on /parameter_events."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from typing import Any

from rostether.errors import GraphError, SerializationError
from rostether.graph.ports import Graph, Publisher, ServiceServer
from rostether.ros2.parameters.parameter_name import DOT
from rostether.ros2.parameters.store import Changes, ParameterStore
from rostether.ros2.parameters.typed_value import NOT_SET, TypedValue, value_of_message
from rostether.ros2.rcl_interfaces import rcl_interfaces
from rostether.serde.values import Message

PARAMETER_EVENTS = "/parameter_events"

Answer = Callable[[ParameterStore, Message], Mapping[str, Any]]


class ParameterServices:
    """Offers the parameters of a store on the graph, from `open` to `close`."""

    def __init__(self, store: ParameterStore, graph: Graph) -> None:
        self._store = store
        self._graph = graph
        self._events: Publisher | None = None
        self._servers: list[ServiceServer] = []

    async def open(self) -> None:
        """Offer the services, and publish every change. Raises GraphError."""
        self._events = await self._graph.advertise(
            PARAMETER_EVENTS, rcl_interfaces().message("ParameterEvent")
        )
        for verb, (name, answer) in SERVICES.items():
            self._servers.append(await self._offer(verb, name, answer))
        self._store.listen(self._publish_changes)
        self._publish_changes(Changes(new={name: self._store.get(name) for name in self._store.names()}))

    async def close(self) -> None:
        """Stop offering the services. Idempotent."""
        self._store.unlisten(self._publish_changes)
        servers, self._servers = self._servers, []
        await asyncio.gather(*(server.close() for server in servers))
        if self._events is not None:
            await self._events.close()

    async def _offer(self, verb: str, name: str, answer: Answer) -> ServiceServer:
        interfaces = rcl_interfaces()
        request, response = interfaces.codec(f"{name}Request"), interfaces.codec(f"{name}Response")

        async def handle(payload: bytes) -> bytes:
            return response.encode(answer(self._store, request.decode(payload)))

        service = f"{self._graph.node_name}/{verb}"
        return await self._graph.advertise_service(service, interfaces.service(name), handle)

    def _publish_changes(self, changes: Changes) -> None:
        assert self._events is not None
        event = {
            "stamp": self._graph.now(),
            "node": self._graph.node_name,
            "new_parameters": _parameters(changes.new),
            "changed_parameters": _parameters(changes.changed),
            # As in rclcpp, deleted parameters are listed without a value.
            "deleted_parameters": _parameters(dict.fromkeys(changes.deleted, NOT_SET)),
        }
        self._events.publish_raw([rcl_interfaces().codec("ParameterEvent").encode(event)])


def _list(store: ParameterStore, request: Message) -> Mapping[str, Any]:
    names = [name for name in store.declared_names() if _is_listed(name, request.prefixes, request.depth)]
    prefixes = dict.fromkeys(name.rpartition(DOT)[0] for name in names)
    return {"result": {"names": names, "prefixes": [prefix for prefix in prefixes if prefix]}}


def _is_listed(name: str, prefixes: list[str], depth: int) -> bool:
    """Return whether a name is at or below a prefix, at most `depth` parts deeper (0: any number).

    Without prefixes, the depth counts from the root.
    """
    if not prefixes:
        return depth == 0 or name.count(DOT) < depth
    return any(
        name == prefix
        or (name.startswith(prefix + DOT) and (depth == 0 or name[len(prefix) + 1 :].count(DOT) < depth))
        for prefix in prefixes
    )


def _apply(store: ParameterStore, parameters: list[Message]) -> Mapping[str, Any]:
    try:
        store.apply({each.name: value_of_message(each.value) for each in parameters})
    except (GraphError, SerializationError) as error:
        return {"successful": False, "reason": str(error)}
    return {"successful": True}


def _parameters(values: Mapping[str, TypedValue]) -> list[Mapping[str, Any]]:
    return [{"name": name, "value": value.to_fields()} for name, value in values.items()]


# The type and the answer of each service.
SERVICES: dict[str, tuple[str, Answer]] = {
    "describe_parameters": (
        "DescribeParameters",
        lambda store, request: {
            "descriptors": [
                {"name": name, "type": int(store.get(name).type), "dynamic_typing": True}
                for name in request.names
            ]
        },
    ),
    "get_parameter_types": (
        "GetParameterTypes",
        lambda store, request: {"types": bytes(store.get(name).type for name in request.names)},
    ),
    "get_parameters": (
        "GetParameters",
        lambda store, request: {"values": [store.get(name).to_fields() for name in request.names]},
    ),
    "list_parameters": ("ListParameters", _list),
    "set_parameters": (
        "SetParameters",
        lambda store, request: {"results": [_apply(store, [each]) for each in request.parameters]},
    ),
    "set_parameters_atomically": (
        "SetParametersAtomically",
        lambda store, request: {"result": _apply(store, request.parameters)},
    ),
}
