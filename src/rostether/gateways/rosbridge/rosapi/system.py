"""The services of rosapi for types, the time, and the ROS version."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from rostether.errors import RostetherError
from rostether.gateways.type_names import short_type
from rostether.graph.ports import Graph
from rostether.msgdef.registry import Registry
from rostether.msgdef.spec import Field, MessageSpec
from rostether.ros2.endpoint_info import find_distribution

_DEFAULT_ROS1_DISTRO: Final = "noetic"
_DISTRO_PARAMETER = "/rosdistro"

# The limit of nested types; real types have about 30, and definitions also come from peers.
_MAX_TYPES: Final = 512

_STAMPS: Final = ("time", "duration")
_STAMP_DETAILS: Final = {
    "fieldnames": ["secs", "nsecs"],
    "fieldtypes": ["int32", "int32"],
    "fieldarraylen": [-1, -1],
    "examples": ["0", "0"],
    "constnames": [],
    "constvalues": [],
}
_EXAMPLES: Final = {"bool": "False", "string": "", "float32": "0.0", "float64": "0.0"}


class SystemAnswers:
    """Answers that need only definitions, the graph's clock, and the environment."""

    def __init__(
        self, graph: Graph, registry: Registry, environ: Mapping[str, str], *, is_ros2: bool
    ) -> None:
        self._graph = graph
        self._registry = registry
        self._environ = environ
        self._is_ros2 = is_ros2

    async def message(self, name: str) -> list[dict[str, Any]]:
        """Return a message and all types in it. Raises UnknownTypeError, DefinitionError."""
        return message_details(self._registry, short_type(name))

    async def request(self, name: str) -> list[dict[str, Any]]:
        """Return a service's request and all types in it. Raises the same errors as `message`."""
        return message_details(self._registry, self._registry.service(short_type(name)).request.full_name)

    async def response(self, name: str) -> list[dict[str, Any]]:
        """Return a service's response and all types in it. Raises the same errors as `message`."""
        return message_details(self._registry, self._registry.service(short_type(name)).response.full_name)

    async def time(self) -> dict[str, int]:
        """Return ROS time, as clients expect it."""
        now = self._graph.now()
        return {"secs": now.secs, "nsecs": now.nsecs}

    async def ros_version(self) -> tuple[int, str]:
        """Return 1 or 2, and the name of the release."""
        if self._is_ros2:
            return 2, await find_distribution(self._graph, self._environ)
        try:
            distro = str(await self._graph.get_param(_DISTRO_PARAMETER)).strip()
        except RostetherError:
            # Only roscore sets it.
            distro = ""
        return 1, distro or _DEFAULT_ROS1_DISTRO


def message_details(registry: Registry, name: str) -> list[dict[str, Any]]:
    """Return a message and all nested ones as rosapi/TypeDef. Raises UnknownTypeError, DefinitionError."""
    details: list[dict[str, Any]] = []
    waiting = [name]
    seen: set[str] = set()
    while waiting and len(details) < _MAX_TYPES:
        each = waiting.pop(0)
        if each in seen:
            continue
        seen.add(each)
        if each in _STAMPS:
            details.append({"type": each, **_STAMP_DETAILS})
            continue
        spec = registry.message(each)
        details.append(_details(spec))
        # Depth first, as in rosapi.
        waiting[:0] = [field.type.base for field in spec.fields if _has_details(field)]
    return details


def _has_details(field: Field) -> bool:
    return "/" in field.type.base or field.type.base in _STAMPS


def _details(spec: MessageSpec) -> dict[str, Any]:
    return {
        "type": spec.full_name,
        "fieldnames": [field.name for field in spec.fields],
        "fieldtypes": [field.type.base for field in spec.fields],
        "fieldarraylen": [(each.type.length or 0) if each.type.is_array else -1 for each in spec.fields],
        "examples": [_example(field) for field in spec.fields],
        "constnames": [constant.name for constant in spec.constants],
        "constvalues": [str(constant.value) for constant in spec.constants],
    }


def _example(field: Field) -> str:
    if field.type.is_array:
        return "[]"
    return "{}" if _has_details(field) else _EXAMPLES.get(field.type.base, "0")
