"""All types of one registry with their layouts and codecs, each compiled on demand."""

from __future__ import annotations

from rostether.msgdef.registry import Registry
from rostether.serde.codec import Codec
from rostether.serde.layout import Layout
from rostether.serde.type_tree import TypeTrees
from rostether.serde.values import MessageClasses


class TypeStore:
    """Layouts and codecs by type name; a service has the types `package/NameRequest` and `NameResponse`.

    A type keeps the definition of its first use.
    """

    def __init__(self, registry: Registry, classes: MessageClasses | None = None) -> None:
        self.registry = registry
        self._trees = TypeTrees(registry)
        self._classes = MessageClasses() if classes is None else classes
        self._layouts: dict[str, Layout] = {}
        self._codecs: dict[str, Codec] = {}

    def for_registry(self, registry: Registry) -> TypeStore:
        """Return a store of another registry's types, whose values are of the same kind."""
        return TypeStore(registry, self._classes.for_other_types())

    def layout(self, name: str) -> Layout:
        """Return the layout of `package/Name`. Raises UnknownTypeError, DefinitionError."""
        layout = self._layouts.get(name)
        if layout is None:
            layout = self._layouts[name] = Layout(self._trees.struct(name))
        return layout

    def codec(self, name: str) -> Codec:
        """Return the codec of `package/Name`. Raises UnknownTypeError, DefinitionError."""
        codec = self._codecs.get(name)
        if codec is None:
            codec = self._codecs[name] = Codec(self._trees.struct(name), self._classes, self.layout(name))
        return codec

    def service_codecs(self, name: str) -> tuple[Codec, Codec]:
        """Return the codecs of a service's request and response. Raises the same errors as `codec`."""
        return self.codec(f"{name}Request"), self.codec(f"{name}Response")
