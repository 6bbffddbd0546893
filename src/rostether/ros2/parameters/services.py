"""A node's parameters on the graph: six services, the client that calls them, and /parameter_events."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rostether.errors import GraphError, SerializationError, ServiceUnavailableError
from rostether.graph.ports import Graph, Publisher, ServiceServer
from rostether.mechanisms.text import fold_line
from rostether.ros2.parameters.parameter_name import DOT
from rostether.ros2.parameters.store import Changes, ParameterStore
from rostether.ros2.parameters.typed_value import NOT_SET, TypedValue, value_of_message
from rostether.ros2.rcl_interfaces import rcl_interfaces
from rostether.serde.values import Message

PARAMETER_EVENTS = "/parameter_events"

Answer = Callable[[ParameterStore, Message], Mapping[str, Any]]

# Long enough for a busy node, and short enough that users do not think that the command hangs.
CALL_TIMEOUT_S = 3.0

LIST_SERVICE = "list_parameters"


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
        for verb, (name, answer) in _SERVICES.items():
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
_SERVICES: dict[str, tuple[str, Answer]] = {
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


class ParameterClient:
    """Reads and sets the parameters of other nodes.

    All methods raise GraphError if a node does not answer or refuses, and SerializationError if its answer is
    invalid.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    async def names(self, node: str) -> list[str]:
        """Return the names of a node's parameters, including those that are declared but not set."""
        answer = await self._call(node, LIST_SERVICE, {})
        return list(answer.result.names)

    async def get(self, node: str, names: Sequence[str]) -> dict[str, TypedValue]:
        """Return the values of the parameters that are set."""
        answer = await self._call(node, "get_parameters", {"names": list(names)})
        if len(answer.values) == len(names):
            values = zip(names, map(value_of_message, answer.values), strict=True)
            return {name: value for name, value in values if value != NOT_SET}
        # rclcpp and rclpy return nothing if one of the names is not set.
        found: dict[str, TypedValue] = {}
        for name in names if len(names) > 1 else ():
            found |= await self.get(node, [name])
        return found

    async def describe(self, node: str, names: Sequence[str]) -> list[Message]:
        """Return an rcl_interfaces/ParameterDescriptor for each existing parameter."""
        answer = await self._call(node, "describe_parameters", {"names": list(names)})
        return list(answer.descriptors)

    async def set(self, node: str, values: Mapping[str, TypedValue]) -> None:
        """Set parameters; `NOT_SET` deletes.

        Whole numbers and empty lists get the type that the parameter has, because texts, YAML and JSON often
        do not distinguish 2 and 2.0. A GraphError has the reason for the first refusal.
        """
        types = await self._types(node, [name for name, value in values.items() if value.may_have_other_type])
        fitting = {name: value.as_type(types.get(name)) for name, value in values.items()}
        parameters = [{"name": name, "value": value.to_fields()} for name, value in fitting.items()]
        answer = await self._call(node, "set_parameters", {"parameters": parameters})
        for name, result in zip(values, answer.results, strict=False):
            if not result.successful:
                reason = fold_line(result.reason) or "no reason given"
                raise GraphError(f"node {node} refused to set its parameter {name}: {reason}")

    async def _types(self, node: str, names: Sequence[str]) -> dict[str, int]:
        if not names:
            return {}
        try:
            answer = await self._call(node, "get_parameter_types", {"names": list(names)})
        except ServiceUnavailableError:
            # The node decides which values it accepts.
            return {}
        # rclcpp returns nothing if one of the names is not declared.
        return dict(zip(names, answer.types, strict=True)) if len(answer.types) == len(names) else {}

    async def _call(self, node: str, verb: str, request: Mapping[str, Any]) -> Message:
        name, _ = _SERVICES[verb]
        interfaces = rcl_interfaces()
        payload = interfaces.codec(f"{name}Request").encode(request)
        try:
            answer = await self._graph.call_service(
                f"{node}/{verb}", interfaces.service(name), payload, timeout_s=CALL_TIMEOUT_S
            )
        except ServiceUnavailableError as error:
            raise ServiceUnavailableError(
                f"node {node} does not give access to its parameters: {error}"
            ) from None
        return interfaces.codec(f"{name}Response").decode(answer)
