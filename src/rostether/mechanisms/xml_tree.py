"""XML files as a tree with line numbers. DTDs and entities are rejected before they are expanded."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import TypeAlias
from xml.parsers import expat

from msgspec import Struct, field

# Robots, launch files and package descriptions nest a few levels; the limit keeps a hostile file from
# growing the stack.
MAX_DEPTH = 64

# The length of the shown text around an error; more would not fit on a line.
_CAUSE_BYTES = 120
_CLOSING_TAG = re.compile(r"</([^\s>]{1,60})")
_BARE_AND = re.compile(r"&\w*[^\w;#]")

# Gets the error text and its line (from 1; 0: the whole file), and returns the error to raise.
MakeError: TypeAlias = Callable[[str, int], Exception]


class XmlElement(Struct, frozen=True):
    """One element; `line` counts from 1, and `content` has its texts and children in order."""

    tag: str
    attributes: dict[str, str]
    file: str
    line: int
    make_error: MakeError
    content: list[str | XmlElement] = field(default_factory=list)

    @property
    def children(self) -> list[XmlElement]:
        """The direct child elements."""
        return [each for each in self.content if isinstance(each, XmlElement)]

    @property
    def text(self) -> str:
        """The text directly in it, without that of its children."""
        return "".join(each for each in self.content if isinstance(each, str))

    @property
    def full_text(self) -> str:
        """The text in it, with that of its children."""
        return "".join(each if isinstance(each, str) else each.full_text for each in self.content)

    def all(self, tag: str) -> Iterator[XmlElement]:
        """Yield the children with a tag."""
        return (child for child in self.children if child.tag == tag)

    def first(self, tag: str) -> XmlElement | None:
        """Return the first child with a tag."""
        return next(self.all(tag), None)

    def get(self, name: str) -> str | None:
        """Return an attribute; None if it is not given."""
        return self.attributes.get(name)

    def error(self, text: str) -> Exception:
        """Return an error that points at this element."""
        return self.make_error(text, self.line)


def place_first(kind: type[Exception], file: str) -> MakeError:
    """Return a function that makes errors whose text begins with file and line."""
    return lambda text, line: kind(f"{file}:{line}: {text}" if line else f"{file}: {text}")


def parse_xml(
    data: bytes, *, file: str, max_bytes: int, what: str, make_error: MakeError, encoding: str | None = None
) -> XmlElement:
    """Return the root element of a document.

    Raises the error of `make_error` for a document that is empty, not XML, larger than `max_bytes` or nested
    too deeply, or declares a DTD or an entity. `what` names the kind of document, as in "a launch file".
    Without `encoding`, the document names its encoding.
    """
    if len(data) > max_bytes:
        raise make_error(f"larger than {max_bytes} bytes, so it is not {what}", 0)
    if not data:
        raise make_error(f"empty, so it is not {what}", 1)
    return _Builder(file, make_error, encoding).build(data)


class _Builder:
    def __init__(self, file: str, make_error: MakeError, encoding: str | None) -> None:
        self._file = file
        self._make_error = make_error
        self._root: XmlElement | None = None
        self._open: list[XmlElement] = []
        self._refusal: Exception | None = None
        self._parser = expat.ParserCreate(encoding)
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._characters
        self._parser.StartDoctypeDeclHandler = self._refuse_dtd
        self._parser.EntityDeclHandler = self._refuse_dtd

    def build(self, data: bytes) -> XmlElement:
        try:
            self._parser.Parse(data, True)
        except expat.ExpatError as error:
            cause = self._cause(expat.ErrorString(error.code), data, self._parser.ErrorByteIndex)
            text = f"not XML: {expat.ErrorString(error.code)} at column {error.offset + 1}"
            raise self._make_error(f"{text}: {cause}" if cause else text, error.lineno) from None
        except (ValueError, LookupError) as error:
            if error is self._refusal:
                raise
            # Python looks up encodings that the parser does not know.
            raise self._make_error(f"not XML: its encoding is unknown ({error}); use UTF-8", 0) from None
        assert self._root is not None
        return self._root

    def _cause(self, error: str, data: bytes, offset: int) -> str:
        """Return a hint for the user, or ""; `offset` is the byte at which the parser stopped."""
        before = data[max(offset - _CAUSE_BYTES, 0) : offset].decode(errors="replace")
        after = data[offset : offset + _CAUSE_BYTES].decode(errors="replace")
        last = self._open[-1] if self._open else None
        if last is not None and error in ("mismatched tag", "no element found", "unclosed token"):
            opened = f"<{last.tag}> of line {last.line} is not closed"
            closing = _CLOSING_TAG.match(before[before.rfind("<") :] + after)
            return f"{opened} before </{closing[1]}>" if closing else opened
        if error == "undefined entity":
            return "of the words between & and ; only &amp; &lt; &gt; &quot; and &apos; are known"
        if error == "junk after document element":
            return "only one root element is allowed"
        return _cause_of_token(before, after) if error == "not well-formed (invalid token)" else ""

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element = XmlElement(
            tag, attributes, self._file, self._parser.CurrentLineNumber, make_error=self._make_error
        )
        if len(self._open) >= MAX_DEPTH:
            self._refusal = element.error(f"elements are nested deeper than {MAX_DEPTH} levels")
            raise self._refusal
        if self._open:
            self._open[-1].content.append(element)
        else:
            self._root = element
        self._open.append(element)

    def _end(self, _tag: str) -> None:
        self._open.pop()

    def _characters(self, text: str) -> None:
        self._open[-1].content.append(text)

    def _refuse_dtd(self, *_: object) -> None:
        self._refusal = self._make_error(
            "declares a DTD or an entity, which is not allowed; remove it", self._parser.CurrentLineNumber
        )
        raise self._refusal


def _cause_of_token(before: str, after: str) -> str:
    if before.rstrip().endswith("&") or _BARE_AND.search(before[before.rfind("&") :] + after[:1]):
        return "write &amp; for &"
    if after.startswith("<"):
        return "write &lt; for < in an attribute"
    if before.rstrip().endswith("="):
        return f"the value of an attribute must be in quotes, at {after.split()[0][:30]!r}"
    if before.endswith("--"):
        return "a comment must not contain --"
    if re.search(r"=\s*(?:\"[^\"]*\"|'[^']*')$", before) and after[:1].isalpha():
        return f"write a space before {after.splitlines()[0][:30]!r}"
    return f"at {after.splitlines()[0][:30]!r}" if after.strip() else ""
