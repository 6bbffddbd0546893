"""Writes XML-RPC documents: calls, responses and faults, in short steps and of limited length.

roscpp's parser is not a full XML parser: it knows five entities, but no numeric character references,
no attributes and no `<data/>`, so these are never written.
"""

from __future__ import annotations

import binascii
from collections.abc import Iterator, Mapping, Sequence

from rostether.errors import SerializationError
from rostether.xmlrpc.values import MAX_INT, MAX_NESTING, MIN_INT, NOT_XML, DateTime

# The limits of one step, about a millisecond of work.
STEP_BYTES = 64 * 1024
STEP_VALUES = 1024

_SCALARS = (str, bool, int, float, bytes, bytearray)
_PROLOG = "<?xml version='1.0'?>"


class DocumentTooLargeError(SerializationError):
    """The document would need more bytes than its limit."""


class DocumentWriter:
    """Writes texts and values into a document of at most `max_bytes`.

    Containers are copied level by level during the writing, so a tree may change between two steps.
    """

    def __init__(self, max_bytes: int | None = None) -> None:
        self._max_bytes = max_bytes
        self._byte_count = 0
        self._chunks: list[bytes] = []
        self._parts: list[str] = []

    def document(self) -> bytes:
        """Return the document. Raises DocumentTooLargeError."""
        self._flush()
        return b"".join(self._chunks)

    def mark(self) -> int:
        """Return a position for `rewind`. Raises DocumentTooLargeError."""
        self._flush()
        return len(self._chunks)

    def rewind(self, mark: int) -> None:
        """Remove everything after a position of `mark`."""
        self._parts.clear()
        self._byte_count -= sum(map(len, self._chunks[mark:]))
        del self._chunks[mark:]

    def begin_response_array(self) -> None:
        """Begin a methodResponse whose value is an array; its values are written next."""
        self._parts.append(f"{_PROLOG}<methodResponse><params><param><value><array><data>")

    def end_response_array(self) -> None:
        """End the array of `begin_response_array`."""
        self._parts.append("</data></array></value></param></params></methodResponse>")

    def write_text(self, text: str) -> None:
        """Append text that is already XML."""
        self._parts.append(text)

    def write_value(self, value: object) -> None:
        """Append a value in one step; see `value_steps`."""
        for _ in self.value_steps(value):
            pass

    def value_steps(self, value: object) -> Iterator[None]:  # noqa: C901, PLR0912 - one branch for each kind of value
        """Append a value; a large one takes several steps.

        An iterator is written as an array, without its elements that are None.
        Raises SerializationError for a value that XML-RPC cannot express, DocumentTooLargeError.
        """
        outer: list[tuple[Iterator[object], Iterator[object] | None]] = []
        items, names = iter((value,)), None
        size, count = 0, 0
        while True:
            for item in items:
                count += 1
                if size >= STEP_BYTES or count >= STEP_VALUES:
                    size = count = 0
                    self._flush()
                    yield
                if names is not None:
                    self._parts.append(f"<member><name>{_escape_name(next(names))}</name>")
                if isinstance(item, (str, bytes, bytearray)) and len(item) > STEP_BYTES:
                    yield from self._long_scalar_steps(item)
                elif isinstance(item, _SCALARS):
                    text = _scalar(item)
                    size += len(text)
                    self._parts.append(text)
                elif isinstance(item, (list, tuple, Mapping, Iterator)):
                    if len(outer) >= MAX_NESTING:
                        raise SerializationError(
                            f"XML-RPC values are nested deeper than {MAX_NESTING} levels; flatten them"
                        )
                    outer.append((items, names))
                    items, names = self._open(item)
                    break
                elif item is not None or not isinstance(items, _Lazy):
                    raise SerializationError(
                        f"XML-RPC cannot carry {item!r:.80}: "
                        "send a bool, int, float, str, bytes, list or mapping"
                    )
                if names is not None:
                    self._parts.append("</member>")
            else:
                if not outer:
                    return
                self._parts.append("</data></array></value>" if names is None else "</struct></value>")
                items, names = outer.pop()
                if names is not None:
                    self._parts.append("</member>")

    def _open(
        self, container: Sequence[object] | Mapping[object, object] | Iterator[object]
    ) -> tuple[Iterator[object], Iterator[object] | None]:
        if isinstance(container, Mapping):
            self._parts.append("<value><struct>")
            return iter(list(container.values())), iter(list(container))
        self._parts.append("<value><array><data>")
        return (_Lazy(container) if isinstance(container, Iterator) else iter(container)), None

    def _long_scalar_steps(self, value: str | bytes | bytearray) -> Iterator[None]:
        tag = "base64" if not isinstance(value, str) else _string_tag(value)
        self._parts.append(f"<value><{tag}>")
        # A multiple of three bytes has no padding in base64.
        piece_size = STEP_BYTES - STEP_BYTES % 3
        for start in range(0, len(value), piece_size):
            piece = value[start : start + piece_size]
            self._parts.append(_escape(piece) if isinstance(piece, str) else _base64(piece))
            self._flush()
            yield
        self._parts.append(f"</{tag}></value>")

    def _flush(self) -> None:
        chunk = "".join(self._parts).encode()
        self._parts.clear()
        self._chunks.append(chunk)
        self._byte_count += len(chunk)
        if self._max_bytes is not None and self._byte_count > self._max_bytes:
            raise DocumentTooLargeError(f"the XML-RPC document would need more than {self._max_bytes} bytes")


class _Lazy(Iterator[object]):
    """Marks an array that is computed while it is written."""

    def __init__(self, items: Iterator[object]) -> None:
        self._items = items

    def __next__(self) -> object:
        return next(self._items)


def call_steps(writer: DocumentWriter, method: str, params: Sequence[object]) -> Iterator[None]:
    """Write a methodCall document. Raises SerializationError for a value that XML-RPC cannot express."""
    writer.write_text(f"{_PROLOG}<methodCall><methodName>{_escape(method)}</methodName><params>")
    for param in params:
        writer.write_text("<param>")
        yield from writer.value_steps(param)
        writer.write_text("</param>")
    writer.write_text("</params></methodCall>")


def dump_response(value: object) -> bytes:
    """Return a methodResponse document. Raises SerializationError for a value that XML-RPC cannot express."""
    writer = DocumentWriter()
    for _ in response_steps(writer, value):
        pass
    return writer.document()


def response_steps(writer: DocumentWriter, value: object) -> Iterator[None]:
    """Write a methodResponse document. Raises the same errors as `DocumentWriter.value_steps`."""
    writer.write_text(f"{_PROLOG}<methodResponse><params><param>")
    yield from writer.value_steps(value)
    writer.write_text("</param></params></methodResponse>")


def fault(code: int, text: str) -> dict[str, object]:
    """Return the struct of a fault; characters that XML does not allow become `?`."""
    return {"faultCode": code, "faultString": NOT_XML.sub("?", text)}


def dump_fault(code: int, text: str) -> bytes:
    """Return a methodResponse document with a fault, see `fault`."""
    writer = DocumentWriter()
    writer.write_text(f"{_PROLOG}<methodResponse><fault>")
    writer.write_value(fault(code, text))
    writer.write_text("</fault></methodResponse>")
    return writer.document()


def _scalar(value: str | bool | int | float | bytes | bytearray) -> str:
    if isinstance(value, str):
        tag = _string_tag(value)
        return f"<value><{tag}>{_escape(value)}</{tag}></value>"
    if isinstance(value, bool):
        return f"<value><boolean>{value:d}</boolean></value>"
    if isinstance(value, int):
        if not MIN_INT <= value <= MAX_INT:
            raise SerializationError(
                f"{value} does not fit in the 32 bits of an XML-RPC integer; send a float or a string"
            )
        return f"<value><int>{value:d}</int></value>"
    if isinstance(value, float):
        return f"<value><double>{float(value)!r}</double></value>"
    return f"<value><base64>{_base64(value)}</base64></value>"


def _string_tag(value: str) -> str:
    return "dateTime.iso8601" if isinstance(value, DateTime) else "string"


def _base64(value: bytes | bytearray) -> str:
    return binascii.b2a_base64(value, newline=False).decode()


def _escape_name(name: object) -> str:
    if not isinstance(name, str):
        raise SerializationError(f"the key {name!r:.80} of an XML-RPC struct must be a string")
    return _escape(name)


def _escape(text: str) -> str:
    if bad := NOT_XML.search(text):
        raise SerializationError(f"the character U+{ord(bad[0]):04X} cannot be sent as XML; remove it")
    if "&" in text:
        text = text.replace("&", "&amp;")
    if "<" in text:
        text = text.replace("<", "&lt;")
    if ">" in text:
        text = text.replace(">", "&gt;")
    return text
