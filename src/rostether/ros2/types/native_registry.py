"""A registry of ROS 2 types, for programs and tools on a ROS 2 graph.

`std_msgs/Header` has no `seq` here and a stamp of `sec` and `nanosec`, as in `ros2 topic echo`. Names may be
full (`std_msgs/msg/String`) or short (`std_msgs/String`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from rostether.errors import DefinitionError, UnknownTypeError
from rostether.msgdef.definition_files import Kind
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definition_files import declares_ros2
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.msgdef.ros2.parse import REQUEST_SUFFIX, RESPONSE_SUFFIX
from rostether.msgdef.ros2.spec import Ros2Message, Ros2Service
from rostether.msgdef.ros2.to_ros1 import as_ros1_specs, ros1_name
from rostether.msgdef.spec import MessageSpec, ServiceSpec
from rostether.ros2.types.paired_definitions import PairedDefinitions

_NAME_PARTS = 3
_SUFFIXES = {"Request": REQUEST_SUFFIX, "Response": RESPONSE_SUFFIX}


def short_name(name: str) -> str:
    """Return a type's name without its middle part: `std_msgs/msg/String` -> `std_msgs/String`."""
    return ros1_name(name) if len(name.split("/")) == _NAME_PARTS else name


class NativeRegistry(Registry):
    """ROS 2 definitions in ROS 1's form; types that only ROS 1 defines are converted to ROS 2."""

    def __init__(self, definitions: Ros2Definitions, ros1: Registry) -> None:
        super().__init__(bundled=False)
        self.definitions = definitions
        self._ros1 = ros1
        self.source = PairedDefinitions(ros1, definitions)

    @classmethod
    def from_environment(
        cls, msg_paths: Iterable[Path | str] = (), environ: Mapping[str, str] | None = None
    ) -> NativeRegistry:
        """Use the folders of --msg-path and of the environment variables of ROS 1 and ROS 2.

        Raises ConfigError for a missing folder.
        """
        paths = tuple(msg_paths)
        return cls(
            Ros2Definitions.from_environment(paths, environ), Registry.from_environment(paths, environ)
        )

    def can_answer(self, query: Callable[[], object]) -> bool:
        """Return whether the folders have already been searched."""
        return self.definitions.is_searched and self._ros1.can_answer(query)

    def search(self) -> None:
        """Search all folders now. It may take seconds."""
        self.definitions.search()
        self._ros1.search()

    def ros2_message(self, name: str) -> Ros2Message:
        """Return a message, request or response as ROS 2 defines it.

        Raises UnknownTypeError, DefinitionError.
        """
        package, _, rest = short_name(name).partition("/")
        full_name = f"{package}/msg/{rest}"
        if self._is_of_action(package, rest):
            return self.definitions.message(f"{package}/action/{rest}")
        if not self.definitions.has(full_name):
            for ending, suffix in _SUFFIXES.items():
                service = rest.removesuffix(ending)
                if service not in (rest, "") and self._has_service(package, service):
                    found = self.ros2_service(f"{package}/{service}")
                    return found.request if suffix == REQUEST_SUFFIX else found.response
            if not _is_known(lambda: self._ros1.message(short_name(name))):
                return self.definitions.message(full_name)
        return self.source.message(full_name)

    def ros2_service(self, name: str) -> Ros2Service:
        """Return a service as ROS 2 defines it. Raises UnknownTypeError, DefinitionError."""
        package, _, rest = short_name(name).partition("/")
        if self._is_of_action(package, rest):
            return self.definitions.service(f"{package}/action/{rest}")
        full_name = f"{package}/srv/{rest}"
        if not self.definitions.has(full_name) and self._has_service(package, rest):
            return self.source.service_counterpart(self._ros1.service_type(f"{package}/{rest}"))
        return self.definitions.service(full_name)

    def message_type(self, name: str) -> MessageType:
        """Return a message's type in ROS 1's form. Raises the same errors as `ros2_message`."""
        return super().message_type(short_name(name))

    def service_type(self, name: str) -> ServiceType:
        """Return a service's type in ROS 1's form. Raises the same errors as `ros2_service`."""
        return super().service_type(short_name(name))

    def packages(self) -> list[str]:
        """Return the names of all packages that have ROS 2 definitions, sorted."""
        return self.definitions.packages()

    def messages(self, package: str | None = None) -> list[str]:
        """Return all messages, or those of a package, by ROS 2's names, sorted."""
        return self.definitions.names(Kind.MESSAGE, package)

    def services(self, package: str | None = None) -> list[str]:
        """Return all services, or those of a package, by ROS 2's names, sorted."""
        return self.definitions.names(Kind.SERVICE, package)

    def _load_message(self, name: str) -> MessageSpec:
        return as_ros1_specs(self.ros2_message(name), self.source)[0]

    def _load_service(self, name: str) -> ServiceSpec:
        service = self.ros2_service(name)
        request, response = (
            as_ros1_specs(message, self.source)[0] for message in (service.request, service.response)
        )
        text = f"{request.text}---\n{response.text}"
        return ServiceSpec(service.package, service.name, request, response, text)

    def _is_of_action(self, package: str, name: str) -> bool:
        """Return whether a name is a part of an action, such as `Fibonacci_Goal`; no other type has a `_`."""
        return "_" in name and self.definitions.has(f"{package}/action/{name}")

    def _has_service(self, package: str, name: str) -> bool:
        if self.definitions.has(f"{package}/srv/{name}"):
            return True
        return _is_known(lambda: self._ros1.service(f"{package}/{name}"))


def _is_known(look: Callable[[], object]) -> bool:
    try:
        look()
    except UnknownTypeError:
        return False
    except DefinitionError as error:
        if not error.file or not declares_ros2(Path(error.file)):
            raise
        # The definition in ROS 2's syntax belongs to a ROS 2 package near the current folder.
        return False
    return True
