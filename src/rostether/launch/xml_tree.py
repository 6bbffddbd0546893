"""Launch XML as a tree whose elements know their line. Any DTD is refused before it is expanded."""

from __future__ import annotations

from dataclasses import dataclass, field
from xml.parsers import expat

from rostether.errors import LaunchError

MAX_FILE_BYTES = 1 << 24  # a launch file may hold a URDF or a parameter set inline; no real one nears 16 MB
_MAX_DEPTH = 64  # real files nest a few groups; a bound keeps a hostile one from growing the stack


@dataclass(frozen=True, slots=True)
class Element:
    """One element; `text` is what stands directly in it, `line` counts from 1."""

    tag: str
    attributes: dict[str, str]
    file: str
    line: int
    children: list[Element] = field(default_factory=list)
    pieces: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The element's own text, without that of its children."""
        return "".join(self.pieces)

    def error(self, message: str) -> LaunchError:
        """Return an error that points at this element."""
        return LaunchError(message, file=self.file, line=self.line)


def parse_launch_xml(data: bytes, *, file: str) -> Element:
    """Return the root of a launch file, which is its <launch>.

    Raises LaunchError with file and line: too large, not XML, a DTD or entity, another root.
    """
    if file.endswith(".launch.py"):
        raise LaunchError("a launch file of ROS 2 in Python; only ROS 1's XML is read here", file=file)
    if len(data) > MAX_FILE_BYTES:
        raise LaunchError(f"larger than {MAX_FILE_BYTES} bytes, not a launch file", file=file)
    builder = _Builder(file)
    builder.read(data)
    assert builder.root is not None
    if builder.root.tag != "launch":
        raise builder.root.error(f"the outermost element is <{builder.root.tag}>, not <launch>")
    return builder.root


class _Builder:
    def __init__(self, file: str) -> None:
        self.root: Element | None = None
        self._file = file
        self._open: list[Element] = []
        self._parser = expat.ParserCreate()

    def read(self, data: bytes) -> None:
        parser = self._parser
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._characters
        parser.StartDoctypeDeclHandler = self._refuse_dtd
        parser.EntityDeclHandler = self._refuse_dtd
        try:
            parser.Parse(data, True)
        except expat.ExpatError as error:
            reason = expat.ErrorString(error.code)
            raise LaunchError(f"not XML: {reason}", file=self._file, line=error.lineno) from None

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes, self._file, self._parser.CurrentLineNumber)
        if len(self._open) >= _MAX_DEPTH:
            raise element.error(f"elements nest deeper than {_MAX_DEPTH}")
        if self._open:
            self._open[-1].children.append(element)
        else:
            self.root = element
        self._open.append(element)

    def _end(self, _tag: str) -> None:
        self._open.pop()

    def _characters(self, text: str) -> None:
        self._open[-1].pieces.append(text)

    def _refuse_dtd(self, *_: object) -> None:
        raise LaunchError(
            "declares a DTD or an entity, which is not allowed; remove it",
            file=self._file,
            line=self._parser.CurrentLineNumber,
        )
