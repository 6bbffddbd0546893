"""rosserial_python's message_info_service.py: returns the md5sum and the text of definitions to programs.

message_info (rosserial_msgs/RequestMessageInfo)   service_info (rosserial_msgs/RequestServiceInfo)
"""

from __future__ import annotations

from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.serde.values import Message


async def serve_message_info(graph: TypedGraph, registry: Registry) -> None:
    """Offer both services, until the node leaves the graph. Raises GraphError.

    A call for an unknown type fails with a text that names it.
    """

    def message_info(request: Message) -> dict[str, str]:
        found = registry.message_type(request.type)
        return {"md5": found.md5sum, "definition": found.definition}

    def service_info(request: Message) -> dict[str, str]:
        found = registry.service_type(request.service)
        return {
            "service_md5": found.md5sum,
            "request_md5": found.request.md5sum,
            "response_md5": found.response.md5sum,
        }

    await graph.service_server("message_info", "rosserial_msgs/RequestMessageInfo", message_info)
    await graph.service_server("service_info", "rosserial_msgs/RequestServiceInfo", service_info)
    await graph.raw.wait_closed()
