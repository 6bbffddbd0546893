"""The definitions of types in ROS 2 recordings."""

from __future__ import annotations

from collections.abc import Iterable

from rostether.msgdef.full_text import split_full_text
from rostether.msgdef.ros2.action_parts import ActionParts
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.msgdef.ros2.parse import parse_message
from rostether.msgdef.ros2.spec import Ros2Message, Ros2Service
from rostether.recording.recorded import Ros2Origin

ROS2MSG = "ros2msg"


class RecordedDefinitions(Ros2Definitions):
    """The definitions of a recording; missing ones are those of `others`, by default of the environment.

    The first definition of a name is used.
    """

    def __init__(self, others: Ros2Definitions | None = None) -> None:
        self._others = others or Ros2Definitions.from_environment()
        super().__init__(bundled=False, distro=self._others.distro)
        self._texts: dict[str, str] = {}

    def learn(self, origin: Ros2Origin) -> None:
        """Add the definition texts of a topic. Raises DefinitionError."""
        if origin.encoding != ROS2MSG or not origin.definition:
            return
        for name, text in split_full_text(origin.type_name, origin.definition).items():
            package, _, rest = name.partition("/")
            self._texts.setdefault(f"{package}/msg/{rest.removeprefix('msg/')}", text)

    def add(self, messages: Iterable[Ros2Message]) -> None:
        """Add other definitions; known ones are not replaced."""
        self._others.add(messages)

    @property
    def searched_folders(self) -> str:
        """The searched folders, as text for errors."""
        return self._others.searched_folders

    def message(self, name: str) -> Ros2Message:
        """Return a message by `package/msg/Name`. Raises UnknownTypeError, DefinitionError."""
        text = self._texts.get(name)
        if text is None:
            return self._others.message(name)
        found = self._messages.get(name)
        if found is None:
            package, _, short_name = name.partition("/msg/")
            found = self._messages[name] = parse_message(text, package=package, name=short_name)
        return found

    def text(self, name: str) -> str:
        """Return a message's own text. Raises the same errors as `message`."""
        return self._texts.get(name) or self._others.text(name)

    def service(self, name: str) -> Ros2Service:
        """Return a service by `package/srv/Name`. Raises UnknownTypeError, DefinitionError."""
        return self._others.service(name)

    def action(self, name: str) -> ActionParts:
        """Return an action by `package/action/Name`. Raises UnknownTypeError, DefinitionError."""
        return self._others.action(name)

    def has(self, name: str) -> bool:
        """Return whether a message or service is known."""
        return name in self._texts or self._others.has(name)
