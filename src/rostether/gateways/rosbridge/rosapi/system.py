"""rosapi's services about types, the time, and the ROS version."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from rostether.errors import RostetherError
from rostether.gateways.rosbridge.rosapi.type_details import message_details
from rostether.gateways.rosbridge.type_names import short_type
from rostether.graph.ports import Graph
from rostether.msgdef.registry import Registry
from rostether.ros2.distribution import find_distribution

_DEFAULT_ROS1_DISTRO: Final = "noetic"
_DISTRO_PARAMETER = "/rosdistro"


class SystemAnswers:
    """Answers that need only definitions, clock and environment."""

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
        """Return a service's request and all types in it. Raises as `message`."""
        return message_details(self._registry, self._registry.service(short_type(name)).request.full_name)

    async def response(self, name: str) -> list[dict[str, Any]]:
        """Return a service's response and all types in it. Raises as `message`."""
        return message_details(self._registry, self._registry.service(short_type(name)).response.full_name)

    async def time(self) -> dict[str, int]:
        """Return ROS time, in the form of clients."""
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
