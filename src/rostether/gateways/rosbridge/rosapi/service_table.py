"""The services of rosapi, row by row: name, type, handler, and the response's fields.

In ROS 2, responses about parameters also contain success and reason.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

from rostether.errors import RostetherError
from rostether.gateways.rosbridge.rosapi.graph_answers import GraphAnswers
from rostether.gateways.rosbridge.rosapi.parameters import ParameterServices
from rostether.gateways.rosbridge.rosapi.system import SystemAnswers
from rostether.serde.values import Message


@dataclass(frozen=True, slots=True)
class Row:
    """One service; `ask` returns the value of its response's field, or a tuple of all its fields' values."""

    name: str
    type_name: str
    ask: Callable[[Message], Awaitable[Any]]
    fields: tuple[str, ...]

    async def answer(self, request: Message, *, tells_success: bool) -> dict[str, Any]:
        """Return the fields of the response. Raises RostetherError, unless the response reports it."""
        success: dict[str, Any] = {"successful": True} if tells_success else {}
        try:
            found = await self.ask(request)
        except RostetherError as error:
            if not tells_success:
                raise
            return {"successful": False, "reason": str(error)}
        if len(self.fields) == 1:
            return {self.fields[0]: found} | success
        return dict(zip(self.fields, found or (), strict=True)) | success


def service_rows(
    graph: GraphAnswers, parameters: ParameterServices, system: SystemAnswers
) -> tuple[Row, ...]:
    """Return all services of rosapi."""
    g, p, s = graph, parameters, system
    return (
        Row("topics", "Topics", lambda _: g.topics(), ("topics", "types")),
        Row(
            "topics_and_raw_types",
            "TopicsAndRawTypes",
            lambda _: g.topics_and_texts(),
            ("topics", "types", "typedefs_full_text"),
        ),
        Row("topics_for_type", "TopicsForType", lambda asked: g.topics_for_type(asked.type), ("topics",)),
        Row("topic_type", "TopicType", lambda asked: g.topic_type(asked.topic), ("type",)),
        Row("publishers", "Publishers", lambda asked: g.publishers(asked.topic), ("publishers",)),
        Row("subscribers", "Subscribers", lambda asked: g.subscribers(asked.topic), ("subscribers",)),
        Row("nodes", "Nodes", lambda _: g.nodes(), ("nodes",)),
        Row(
            "node_details",
            "NodeDetails",
            lambda asked: g.node_details(asked.node),
            ("subscribing", "publishing", "services"),
        ),
        Row("services", "Services", lambda _: g.services(), ("services",)),
        Row(
            "services_for_type",
            "ServicesForType",
            lambda asked: g.services_for_type(asked.type),
            ("services",),
        ),
        Row("service_type", "ServiceType", lambda asked: g.service_type(asked.service), ("type",)),
        Row("service_node", "ServiceNode", lambda asked: g.service_node(asked.service), ("node",)),
        Row("service_host", "ServiceHost", lambda asked: g.service_host(asked.service), ("host",)),
        Row(
            "service_providers",
            "ServiceProviders",
            lambda asked: g.service_providers(asked.service),
            ("providers",),
        ),
        Row("action_servers", "GetActionServers", lambda _: g.action_servers(), ("action_servers",)),
        Row("message_details", "MessageDetails", lambda asked: s.message(asked.type), ("typedefs",)),
        Row(
            "service_request_details",
            "ServiceRequestDetails",
            lambda asked: s.request(asked.type),
            ("typedefs",),
        ),
        Row(
            "service_response_details",
            "ServiceResponseDetails",
            lambda asked: s.response(asked.type),
            ("typedefs",),
        ),
        Row("get_time", "GetTime", lambda _: s.time(), ("time",)),
        Row("get_ros_version", "GetROSVersion", lambda _: s.ros_version(), ("version", "distro")),
        Row("get_param", "GetParam", lambda asked: p.get(asked.name, _default(asked)), ("value",)),
        Row("set_param", "SetParam", lambda asked: p.set(asked.name, asked.value), ()),
        Row("has_param", "HasParam", lambda asked: p.has(asked.name), ("exists",)),
        Row("delete_param", "DeleteParam", lambda asked: p.delete(asked.name), ()),
        Row("search_param", "SearchParam", lambda asked: p.search(asked.name), ("global_name",)),
        Row("get_param_names", "GetParamNames", lambda _: p.names(), ("names",)),
    )


def _default(asked: Message) -> str:
    """Return the value for an unset parameter; `default` is a field of ROS 2's definitions."""
    return str(asked.default_value if hasattr(asked, "default_value") else asked.default)
