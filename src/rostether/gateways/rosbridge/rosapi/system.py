"""rosapi's services about types, the time, and which ROS this is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from rostether.errors import RostetherError
from rostether.gateways.rosbridge.rosapi.type_details import message_details
from rostether.gateways.rosbridge.type_names import short_type
from rostether.graph.ports import Graph
from rostether.msgdef.registry import Registry

DEFAULT_DISTROS: Final = {1: "noetic", 2: "jazzy"}
"""The answer if neither graph nor environment names a release: those of the bundled definitions."""

_DISTRO_PARAMETER = "/rosdistro"


class SystemAnswers:
    """Answers that need no more than definitions, clock and environment."""

    def __init__(
        self, graph: Graph, registry: Registry, environ: Mapping[str, str], *, is_ros2: bool
    ) -> None:
        self._graph = graph
        self._registry = registry
        self._environ = environ
        self._version = 2 if is_ros2 else 1

    async def message(self, name: str) -> list[dict[str, Any]]:
        """Return a message and all below it. Raises UnknownTypeError, DefinitionError."""
        return message_details(self._registry, short_type(name))

    async def request(self, name: str) -> list[dict[str, Any]]:
        """Return a service's request and all below it. Raises as `message`."""
        return message_details(self._registry, self._registry.service(short_type(name)).request.full_name)

    async def response(self, name: str) -> list[dict[str, Any]]:
        """Return a service's response and all below it. Raises as `message`."""
        return message_details(self._registry, self._registry.service(short_type(name)).response.full_name)

    async def time(self) -> dict[str, int]:
        """Return ROS time, as clients send it."""
        now = self._graph.now()
        return {"secs": now.secs, "nsecs": now.nsecs}

    async def ros_version(self) -> tuple[int, str]:
        """Return 1 or 2, and the name of the release."""
        distro = ""
        if self._version == 1:
            try:
                distro = str(await self._graph.get_param(_DISTRO_PARAMETER)).strip()
            except RostetherError:
                # A master that was not started by roscore does not say it.
                distro = ""
        return self._version, distro or self._environ.get("ROS_DISTRO", "") or DEFAULT_DISTROS[self._version]
