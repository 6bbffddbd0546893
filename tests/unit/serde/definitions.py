"""Stores of types that tests define in a line or two."""

from __future__ import annotations

from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.registry import Registry
from rostether.msgdef.spec import MessageSpec
from rostether.serde.store import TypeStore


class TextRegistry(Registry):
    """The bundled definitions and some of a test's own."""

    def __init__(self, texts: dict[str, str]) -> None:
        super().__init__()
        self._texts = texts

    def message(self, name: str) -> MessageSpec:
        text = self._texts.get(name)
        if text is None:
            return super().message(name)
        package, _, short_name = name.partition("/")
        return parse_message(text, package=package, name=short_name)


def store_of(**texts: str) -> TypeStore:
    """Return a store in which each text is message `test/<Keyword>`."""
    return TypeStore(TextRegistry({f"test/{name}": text for name, text in texts.items()}))
