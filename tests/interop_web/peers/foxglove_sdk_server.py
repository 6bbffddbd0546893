"""Foxglove's server with one channel, service and parameter of each kind. It prints its port, and ends with
its input.
"""

from __future__ import annotations

import json
import sys

import foxglove
from foxglove import (
    Channel,
    ConnectionGraph,
    Context,
    MessageSchema,
    Parameter,
    ParameterType,
    Schema,
    Service,
    ServiceSchema,
)
from foxglove.websocket import Capability, ServerListener

offer = json.loads(sys.stdin.readline())


def schema(described: dict[str, str]) -> Schema:
    return Schema(name=described["name"], encoding="ros1msg", data=described["text"].encode())


class Listener(ServerListener):
    """Returns the values that it received."""

    def on_get_parameters(
        self, client: object, param_names: list[str], request_id: str | None = None
    ) -> list[Parameter]:
        """Return one parameter of each kind."""
        return [
            Parameter("/bytes", value=b"\0\xff"),
            Parameter("/float", value=1.0),
            Parameter("/floats", value=[1.0, 2.5]),
            Parameter("/int", value=3),
            Parameter("/text", value="text"),
            Parameter("/tree", value={"a": [1, True]}),
            Parameter("/whole", value=2.0, type=ParameterType.Float64),
        ]


context = Context()
server = foxglove.start_server(
    name="rostether",
    port=0,
    capabilities=[
        Capability.ClientPublish,
        Capability.Parameters,
        Capability.Services,
        Capability.ConnectionGraph,
    ],
    server_listener=Listener(),
    supported_encodings=["ros1", "json"],
    context=context,
    asset_handler=lambda uri: b"solid" if uri.endswith(".stl") else None,
)
channel = Channel("/chatter", schema=schema(offer["message"]), message_encoding="ros1", context=context)
schemas = {
    each: MessageSchema(encoding="ros1", schema=schema(offer[each])) for each in ("request", "response")
}
service_schema = ServiceSchema("std_srvs/SetBool", request=schemas["request"], response=schemas["response"])
server.add_services([Service("/motor", schema=service_schema, handler=lambda _: b"\1\0\0\0\0")])
graph = ConnectionGraph()
graph.set_published_topic("/chatter", ["/robot"])
graph.set_advertised_service("/motor", ["/robot"])
server.publish_connection_graph(graph)
print(server.port, flush=True)
sys.stdin.readline()
channel.log(b"\5\0\0\0hello", log_time=123456789)
sys.stdin.read()
server.stop()
