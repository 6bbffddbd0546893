"""The parameters of other nodes, through their services."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rostether.errors import GraphError, ServiceUnavailableError
from rostether.graph.ports import Graph
from rostether.mechanisms.text import fold_line
from rostether.ros2.parameters.services import SERVICES
from rostether.ros2.parameters.typed_value import NOT_SET, TypedValue, value_of_message
from rostether.ros2.rcl_interfaces import rcl_interfaces
from rostether.serde.values import Message

# Long enough for a busy node, and short enough that users do not think that the command hangs.
CALL_TIMEOUT_S = 3.0

LIST_SERVICE = "list_parameters"


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
        name, _ = SERVICES[verb]
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
