"""XML-RPC documents <-> Python values, as ROS masters and nodes exchange them.

| XML-RPC                   | Python                                       |
| ---                       | ---                                          |
| boolean, int/i4, double   | bool, int (32 bits), float                   |
| string, or a bare value   | str                                          |
| base64                    | bytes                                        |
| dateTime.iso8601          | DateTime, the text as it was sent            |
| array, struct, nil        | list, dict with str keys, None (read only)   |

roscpp's parser is no XML parser: it knows five entities, no numeric character references, no attributes
and no `<data/>`, so nothing of that is ever written. A document type declaration ends the parsing before
any entity is read.
"""

from __future__ import annotations

import binascii
import re
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias
from xml.parsers import expat

from rostether.errors import RemoteProtocolError, SerializationError

XmlRpcValue: TypeAlias = (
    bool | int | float | str | bytes | list["XmlRpcValue"] | dict[str, "XmlRpcValue"] | None
)

# Arrays and structs inside each other: deeper than any parameter tree, and far below the recursion limit.
MAX_NESTING = 100
# XML-RPC integers have 32 bits, and rospy's and roscpp's codecs hold to it.
MIN_INT, MAX_INT = -(2**31), 2**31 - 1

_NOT_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
_PROLOG = "<?xml version='1.0'?>"


class DateTime(str):
    """A dateTime.iso8601 value, kept as the text that was sent, so that it goes back unchanged."""

    __slots__ = ()


class FaultError(RemoteProtocolError):
    """The peer answered a call with a fault; `code` is its faultCode, `text` its faultString."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code
        self.text = text


def dump_call(method: str, params: Sequence[object]) -> bytes:
    """Return a methodCall document. Raises SerializationError for a value XML-RPC cannot carry."""
    parts = [_PROLOG, "<methodCall><methodName>", _escape(method), "</methodName><params>"]
    for param in params:
        parts.append("<param>")
        _write(parts, param, 0)
        parts.append("</param>")
    parts.append("</params></methodCall>")
    return "".join(parts).encode()


def dump_response(value: object) -> bytes:
    """Return a methodResponse document. Raises SerializationError for a value XML-RPC cannot carry."""
    parts = [_PROLOG, "<methodResponse><params><param>"]
    _write(parts, value, 0)
    parts.append("</param></params></methodResponse>")
    return "".join(parts).encode()


def dump_fault(code: int, text: str) -> bytes:
    """Return a methodResponse document that tells of a fault; characters XML cannot carry become `?`."""
    parts = [_PROLOG, "<methodResponse><fault>"]
    _write(parts, {"faultCode": code, "faultString": _NOT_XML.sub("?", text)}, 0)
    parts.append("</fault></methodResponse>")
    return "".join(parts).encode()


def load_call(document: bytes) -> tuple[str, list[XmlRpcValue]]:
    """Return the method name and the arguments of a methodCall. Raises RemoteProtocolError."""
    reader = _Reader(document)
    if reader.method is None or reader.root != "methodCall":
        raise RemoteProtocolError("the XML-RPC document is not a method call")
    return reader.method, reader.params


def load_response(document: bytes) -> XmlRpcValue:
    """Return the value of a methodResponse. Raises FaultError, RemoteProtocolError for nonsense."""
    reader = _Reader(document)
    if reader.root != "methodResponse" or len(reader.params) != 1:
        raise RemoteProtocolError("the XML-RPC document is not a response with one value")
    value = reader.params[0]
    if not reader.is_fault:
        return value
    if not isinstance(value, dict):
        raise RemoteProtocolError("the XML-RPC fault is not a struct")
    code = value.get("faultCode")
    raise FaultError(code if isinstance(code, int) else -1, str(value.get("faultString", "no reason given")))


def _escape(text: str) -> str:
    if bad := _NOT_XML.search(text):
        raise SerializationError(f"the character U+{ord(bad[0]):04X} cannot be sent as XML: remove it")
    if "&" in text:
        text = text.replace("&", "&amp;")
    if "<" in text:
        text = text.replace("<", "&lt;")
    if ">" in text:
        text = text.replace(">", "&gt;")
    return text


def _write(parts: list[str], value: object, nesting: int) -> None:
    if isinstance(value, str):
        tag = "dateTime.iso8601" if isinstance(value, DateTime) else "string"
        parts.append(f"<value><{tag}>{_escape(value)}</{tag}></value>")
    elif isinstance(value, bool):
        parts.append(f"<value><boolean>{value:d}</boolean></value>")
    elif isinstance(value, int):
        if not MIN_INT <= value <= MAX_INT:
            raise SerializationError(
                f"{value} does not fit the 32 bits of an XML-RPC integer: send a float or a string"
            )
        parts.append(f"<value><int>{value:d}</int></value>")
    elif isinstance(value, float):
        parts.append(f"<value><double>{float(value)!r}</double></value>")
    elif isinstance(value, (list, tuple, Mapping)):
        _write_container(parts, value, nesting)
    elif isinstance(value, (bytes, bytearray)):
        text = binascii.b2a_base64(value, newline=False).decode()
        parts.append(f"<value><base64>{text}</base64></value>")
    else:
        raise SerializationError(
            f"XML-RPC cannot carry {value!r:.80}: send a bool, int, float, str, bytes, list or mapping"
        )


def _write_container(
    parts: list[str], value: Sequence[object] | Mapping[object, object], nesting: int
) -> None:
    if nesting >= MAX_NESTING:
        raise SerializationError(f"XML-RPC values nested deeper than {MAX_NESTING} levels: flatten them")
    if isinstance(value, Mapping):
        parts.append("<value><struct>")
        for key, item in value.items():
            if not isinstance(key, str):
                raise SerializationError(f"the key {key!r:.80} of an XML-RPC struct must be a string")
            parts.append(f"<member><name>{_escape(key)}</name>")
            _write(parts, item, nesting + 1)
            parts.append("</member>")
        parts.append("</struct></value>")
        return
    parts.append("<value><array><data>")
    for item in value:
        _write(parts, item, nesting + 1)
    parts.append("</data></array></value>")


def _read_int(text: str) -> int:
    # A sign, ten digits, spaces and leading zeros fit; int() takes quadratic time for a longer text.
    value = int(text) if len(text) <= 64 else MAX_INT + 1
    if not MIN_INT <= value <= MAX_INT:
        raise ValueError(f"{text:.40} does not fit 32 bits")
    return value


def _read_boolean(text: str) -> bool:
    return {"0": False, "1": True, "false": False, "true": True}[text.strip().lower()]


def _read_nil(text: str) -> None:
    if text.strip():
        raise ValueError("nil with a content")


_SCALARS: dict[str, Callable[[str], XmlRpcValue]] = {
    "int": _read_int,
    "i4": _read_int,
    "i1": _read_int,
    "i2": _read_int,
    "i8": _read_int,
    "boolean": _read_boolean,
    "double": float,
    "string": str,
    "base64": binascii.a2b_base64,
    "dateTime.iso8601": lambda text: DateTime(text.strip()),
    "nil": _read_nil,
}
_CHILDREN: dict[str, frozenset[str]] = {
    "": frozenset(("methodCall", "methodResponse")),
    "methodCall": frozenset(("methodName", "params")),
    "methodResponse": frozenset(("params", "fault")),
    "params": frozenset(("param",)),
    "param": frozenset(("value",)),
    "fault": frozenset(("value",)),
    "value": frozenset((*_SCALARS, "array", "struct")),
    "array": frozenset(("data",)),
    "data": frozenset(("value",)),
    "struct": frozenset(("member",)),
    "member": frozenset(("name", "value")),
}
_NO_CHILDREN: frozenset[str] = frozenset()


class _Reader:
    """Reads one document; `params` are the call's arguments, or the one value of a response or fault.

    A value is complete at its end tag and goes into the innermost container: `params` at the bottom, then
    one list or dict for each array or struct that is open.
    """

    def __init__(self, document: bytes) -> None:
        self.root = ""
        self.method: str | None = None
        self.is_fault = False
        self.params: list[XmlRpcValue] = []
        self._path = [""]
        self._containers: list[list[XmlRpcValue] | dict[str, XmlRpcValue]] = [self.params]
        self._names: list[str | None] = []
        self._value: XmlRpcValue = None
        self._has_value = False
        self._text: list[str] = []
        parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.StartDoctypeDeclHandler = _refuse_doctype
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._text.append
        try:
            parser.Parse(document, True)
        except (expat.ExpatError, ValueError, LookupError) as error:
            raise RemoteProtocolError(f"the XML-RPC document cannot be read: {error}") from None

    def _start(self, tag: str, _attributes: Mapping[str, str]) -> None:
        parent = self._path[-1]
        if tag not in _CHILDREN.get(parent, _NO_CHILDREN):
            raise RemoteProtocolError(f"an XML-RPC document has no <{tag:.40}> in <{parent}>")
        self._path.append(tag)
        self._text.clear()
        if parent == "value" and self._has_value:
            raise RemoteProtocolError("an XML-RPC value holds two values")
        if tag == "array":
            self._open([])
        elif tag == "struct":
            self._open({})
        elif tag == "member":
            self._names.append(None)
        elif parent == "":
            self.root = tag
        elif tag == "fault":
            self.is_fault = True

    def _open(self, container: list[XmlRpcValue] | dict[str, XmlRpcValue]) -> None:
        if len(self._containers) > MAX_NESTING:
            raise RemoteProtocolError(f"XML-RPC values are nested deeper than {MAX_NESTING} levels")
        self._containers.append(container)

    def _end(self, tag: str) -> None:
        del self._path[-1]
        if tag == "value":
            self._close_value()
        elif tag in _SCALARS:
            self._value = _SCALARS[tag]("".join(self._text))
            self._has_value = True
        elif tag in ("array", "struct"):
            self._value = self._containers.pop()
            self._has_value = True
        elif tag == "name":
            self._names[-1] = "".join(self._text)
        elif tag == "member":
            del self._names[-1]
        elif tag == "methodName":
            self.method = "".join(self._text).strip()
        self._text.clear()

    def _close_value(self) -> None:
        value = self._value if self._has_value else "".join(self._text)
        self._has_value = False
        container = self._containers[-1]
        if isinstance(container, list):
            container.append(value)
            return
        name = self._names[-1]
        if name is None:
            raise RemoteProtocolError("an XML-RPC struct has a value without a name")
        container[name] = value


def _refuse_doctype(*_declaration: object) -> None:
    raise RemoteProtocolError("an XML-RPC document must not have a document type declaration")
