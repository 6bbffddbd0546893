"""Asks nodes for the definitions of their types with the service `~/get_type_description`.

Source: type_description_interfaces/srv/GetTypeDescription and REP-2016. Nodes of Jazzy and later offer it;
Humble has no hashes of types, and no such service.
"""

from __future__ import annotations

from typing import Any, Final

from rostether.errors import DefinitionError, RostetherError, UnknownTypeError
from rostether.graph.ports import Graph
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.msgdef.ros2.spec import Ros2Message
from rostether.ros2.types.type_hash import described_message, rihs01
from rostether.ros2.types.type_support import Ros2Types
from rostether.serde.store import TypeStore

SERVICE: Final = "get_type_description"
SERVICE_TYPE: Final = "type_description_interfaces/srv/GetTypeDescription"

# A node that hangs must not delay a tool longer than waiting for a topic would.
TIMEOUT_S: Final = 3.0


async def learn_type(graph: Graph, types: Ros2Types, node_name: str, name: str, type_hash: str) -> None:
    """Ask a node for the definitions of a type and its nested types, and add them to `types`.

    Raises UnknownTypeError with the reason.
    """
    where = f"{node_name}/{SERVICE}"
    try:
        found = await _ask(graph, types, where, name, type_hash)
        _check(found, name, type_hash)
    except RostetherError as error:
        raise UnknownTypeError(f"its node does not describe it: {error}") from None
    types.definitions.add(found)


async def _ask(graph: Graph, types: Ros2Types, service: str, name: str, type_hash: str) -> list[Ros2Message]:
    service_type = types.native_service(SERVICE_TYPE)
    registry = Registry(bundled=False)
    for message in (service_type.request, service_type.response):
        registry.add_full_text(message.name, message.definition)
    store = TypeStore(registry)
    fields = {"type_name": name, "type_hash": type_hash, "include_type_sources": False}
    request = store.codec(service_type.request.name).encode(fields)
    answer = await graph.call_service(service, service_type, request, timeout_s=TIMEOUT_S)
    response: Any = store.codec(service_type.response.name).decode(answer)
    if not response.successful:
        raise UnknownTypeError(f"{service}: {response.failure_reason}")
    description = response.type_description
    return [
        described_message(each.type_name, each.fields)
        for each in (description.type_description, *description.referenced_type_descriptions)
    ]


def _check(messages: list[Ros2Message], name: str, type_hash: str) -> None:
    """Check that the descriptions are complete and have the requested hash."""
    source = Ros2Definitions(bundled=False)
    source.add(messages)
    if not source.has(name) or rihs01(source.message(name), source.message) != type_hash:
        raise DefinitionError(f"it does not describe {name} with the hash {type_hash}")
