"""rosapi: services that show the graph to web pages and give access to its parameters.

The services are the same as in the package rosapi, under `/rosapi`. rosbridge's clients get their answers
directly from here; `offering_rosapi` also offers them to the graph, as a node.
"""

from __future__ import annotations

import os
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from typing import Any, Final, TypeAlias

from msgspec import Struct

from rostether.errors import RostetherError
from rostether.gateways.rosbridge.form_source import Style
from rostether.gateways.rosbridge.request import fields_by_name
from rostether.gateways.rosbridge.rosapi.graph_answers import GraphAnswers
from rostether.gateways.rosbridge.rosapi.parameters import ParameterServices
from rostether.gateways.rosbridge.rosapi.system import SystemAnswers
from rostether.gateways.rosbridge.service_types import AskServer
from rostether.gateways.rosbridge.settings import RosbridgeSettings
from rostether.gateways.rosbridge.values import JsonForm
from rostether.gateways.type_names import short_type
from rostether.graph.ports import Graph, JoinGraph, ServiceHandler
from rostether.mechanisms.block_end import closed_at_end
from rostether.serde.codec import Codec
from rostether.serde.store import TypeStore
from rostether.serde.values import Message

NODE_NAME: Final = "/rosapi"
PACKAGE: Final = "rosapi"

# The package of the same services in ROS 2.
_ROS2_PACKAGE: Final = "rosapi_msgs"

LocalAnswer: TypeAlias = Callable[[Any], Awaitable[dict[str, Any]]]


class Rosapi:
    """The handlers of rosapi's services, on one node's graph.

    `ask_type` and `ask_host` ask the server of a service, because a ROS 1 master does not know them.
    """

    def __init__(
        self,
        graph: Graph,
        store: TypeStore,
        *,
        style: Style = Style.ROS1,
        settings: RosbridgeSettings | None = None,
        ask_type: AskServer | None = None,
        ask_host: AskServer | None = None,
        environ: Mapping[str, str] | None = None,
    ) -> None:
        limits = settings or RosbridgeSettings()
        is_ros2 = style is Style.ROS2
        self._graph = graph
        self._store = store
        self._form = JsonForm(style)
        about_graph = GraphAnswers(
            graph, store.registry, limits, is_ros2=is_ros2, ask_type=ask_type, ask_host=ask_host
        )
        parameters = ParameterServices(graph, limits.params_glob, is_ros2=is_ros2)
        system = SystemAnswers(
            graph, store.registry, os.environ if environ is None else environ, is_ros2=is_ros2
        )
        rows = _service_rows(about_graph, parameters, system)
        known = {short_type(name) for name in store.registry.services(_ROS2_PACKAGE)} if is_ros2 else set()
        self._package = _ROS2_PACKAGE if known else PACKAGE
        self._rows = {
            f"{NODE_NAME}/{row.name}": row
            for row in rows
            if not known or f"{_ROS2_PACKAGE}/{row.type_name}" in known
        }
        about_graph.known_types = self.services

    @property
    def services(self) -> dict[str, str]:
        """The full names of all services, with their types."""
        return {name: f"{self._package}/{row.type_name}" for name, row in self._rows.items()}

    def find(self, service: str) -> LocalAnswer | None:
        """Return the handler of a service by its full name; it accepts and returns JSON values.

        It raises SerializationError for a request that does not fit, and GraphError.
        """
        row = self._rows.get(service)
        if row is None:
            return None
        (request, response), handle = self._codecs(row), self.handler(service)

        async def answer(args: Any) -> dict[str, Any]:
            payload = self._form.from_json(request, _by_name(request, args), self._graph.now())
            return self._form.to_json(response, await handle(payload))

        return answer

    def handler(self, service: str) -> ServiceHandler:
        """Return the handler of a service on the graph, for payloads."""
        row = self._rows[service]
        request, response = self._codecs(row)
        has_success_field = any(member.name == "successful" for member in response.tree.members)

        async def handle(payload: bytes) -> bytes:
            fields = await row.answer(request.decode(payload), has_success_field=has_success_field)
            return self._form.from_json(response, fields, self._graph.now())

        return handle

    async def offer(self, graph: Graph) -> None:
        """Offer all services on a node, which ends them when it leaves. Raises GraphError."""
        registry = self._store.registry
        for name, type_name in self.services.items():
            await graph.advertise_service(name, registry.service_type(type_name), self.handler(name))

    def _codecs(self, row: Row) -> tuple[Codec, Codec]:
        service = self._store.registry.service_type(f"{self._package}/{row.type_name}")
        return self._store.codec(service.request.name), self._store.codec(service.response.name)


@asynccontextmanager
async def offering_rosapi(
    rosapi: Rosapi, join: JoinGraph, graph: Graph, is_live: Callable[[str], Awaitable[bool]] | None = None
) -> AsyncIterator[bool]:
    """Run the node `/rosapi` within the block, unless `graph` already has one.

    `is_live` returns whether a listed node still runs, because a killed node stays listed. Yields whether the
    node was started here. Raises GraphError.
    """
    is_listed = NODE_NAME in (await graph.snapshot()).nodes
    if is_listed and (is_live is None or await is_live(NODE_NAME)):
        yield False
        return
    async with closed_at_end(await join(NODE_NAME)) as node:
        await rosapi.offer(node)
        yield True


def _by_name(request: Codec, args: Any) -> Any:
    """Return the request's fields by name; ROS 1's `default` is `default_value` in ROS 2."""
    fields = fields_by_name(request, args)
    if "default" in fields and any(member.name == "default_value" for member in request.tree.members):
        return {"default_value" if name == "default" else name: value for name, value in fields.items()}
    return fields


class Row(Struct, frozen=True):
    """One service: the fields of its response, and `ask`, which returns the field's value or a tuple of them.

    `ask` gets the values of the request's fields in their order. `own_type` is set where the name of the type
    does not follow from the name of the service.
    """

    name: str
    fields: tuple[str, ...]
    ask: Callable[..., Awaitable[Any]]
    own_type: str = ""

    @property
    def type_name(self) -> str:
        """The name of its type, without the package: `topic_type` is a `TopicType`."""
        return self.own_type or self.name.title().replace("_", "")

    async def answer(self, request: Message, *, has_success_field: bool) -> dict[str, Any]:
        """Return the fields of the response. Raises RostetherError, unless the response reports it."""
        success: dict[str, Any] = {"successful": True} if has_success_field else {}
        try:
            found = await self.ask(*(getattr(request, name) for name, _ in request._fields))
        except RostetherError as error:
            if not has_success_field:
                raise
            return {"successful": False, "reason": str(error)}
        if len(self.fields) == 1:
            return {self.fields[0]: found} | success
        return dict(zip(self.fields, found or (), strict=True)) | success


def _service_rows(
    graph: GraphAnswers, parameters: ParameterServices, system: SystemAnswers
) -> tuple[Row, ...]:
    return (
        Row("topics", ("topics", "types"), graph.topics),
        Row("topics_and_raw_types", ("topics", "types", "typedefs_full_text"), graph.topics_and_texts),
        Row("topics_for_type", ("topics",), graph.topics_for_type),
        Row("topic_type", ("type",), graph.topic_type),
        Row("publishers", ("publishers",), graph.publishers),
        Row("subscribers", ("subscribers",), graph.subscribers),
        Row("nodes", ("nodes",), graph.nodes),
        Row("node_details", ("subscribing", "publishing", "services"), graph.node_details),
        Row("services", ("services",), graph.services),
        Row("services_for_type", ("services",), graph.services_for_type),
        Row("service_type", ("type",), graph.service_type),
        Row("service_node", ("node",), graph.service_node),
        Row("service_host", ("host",), graph.service_host),
        Row("service_providers", ("providers",), graph.service_providers),
        Row("action_servers", ("action_servers",), graph.action_servers, "GetActionServers"),
        Row("message_details", ("typedefs",), system.message),
        Row("service_request_details", ("typedefs",), system.request),
        Row("service_response_details", ("typedefs",), system.response),
        Row("get_time", ("time",), system.time),
        Row("get_ros_version", ("version", "distro"), system.ros_version, "GetROSVersion"),
        Row("get_param", ("value",), parameters.get),
        Row("set_param", (), parameters.set),
        Row("has_param", ("exists",), parameters.has),
        Row("delete_param", (), parameters.delete),
        Row("search_param", ("global_name",), parameters.search),
        Row("get_param_names", ("names",), parameters.names),
    )
