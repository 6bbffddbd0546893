"""XML files of robots as a tree that knows its lines; DTDs and entities are refused, not expanded."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

from rostether.errors import RobotModelError

MAX_XML_BYTES = 64 << 20  # the largest robots with inlined meshes' names have a few MB
_MAX_DEPTH = 256  # URDF nests six levels; a bound keeps a hostile text from growing the stack


@dataclass(slots=True)
class XmlElement:
    """One element: its tag with prefix, attributes, text right below it, children, and line (from 1)."""

    tag: str
    attributes: dict[str, str]
    line: int
    text: str = ""
    children: list[XmlElement] = field(default_factory=list)

    def all(self, tag: str) -> Iterator[XmlElement]:
        """Yield the children with a tag."""
        return (child for child in self.children if child.tag == tag)

    def first(self, tag: str) -> XmlElement | None:
        """Return the first child with a tag."""
        return next(self.all(tag), None)

    def get(self, name: str) -> str | None:
        """Return an attribute; None where it is not given."""
        return self.attributes.get(name)


def parse_xml(text: str | bytes, *, file: str) -> XmlElement:
    """Return the outermost element. Raises RobotModelError with file and line."""
    data = text.encode() if isinstance(text, str) else text
    if len(data) > MAX_XML_BYTES:
        raise RobotModelError(f"{file}: larger than {MAX_XML_BYTES} bytes, not a robot description")
    return _Builder(file, "utf-8" if isinstance(text, str) else None).build(data.lstrip())


class _Builder:
    def __init__(self, file: str, encoding: str | None) -> None:
        self._file = file
        self._parser = expat.ParserCreate(encoding)
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._characters
        self._parser.StartDoctypeDeclHandler = self._refuse_dtd
        self._parser.EntityDeclHandler = self._refuse_dtd
        self._root: XmlElement | None = None
        self._open: list[XmlElement] = []

    def build(self, data: bytes) -> XmlElement:
        try:
            self._parser.Parse(data, True)
        except expat.ExpatError as error:
            reason = expat.ErrorString(error.code)
            raise RobotModelError(f"{self._file}:{error.lineno}: not XML ({reason})") from error
        assert self._root is not None
        return self._root

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        if len(self._open) >= _MAX_DEPTH:
            raise RobotModelError(f"{self._file}: elements nest deeper than {_MAX_DEPTH}")
        element = XmlElement(tag, attributes, self._parser.CurrentLineNumber)
        if self._open:
            self._open[-1].children.append(element)
        elif self._root is None:
            self._root = element
        self._open.append(element)

    def _end(self, _tag: str) -> None:
        self._open.pop()

    def _characters(self, text: str) -> None:
        self._open[-1].text += text

    def _refuse_dtd(self, *_: object) -> None:
        raise RobotModelError(f"{self._file}: declares a DTD or an entity, which is not allowed; remove it")
