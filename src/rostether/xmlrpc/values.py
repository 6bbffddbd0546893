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
from collections.abc import Mapping, Sequence
from typing import TypeAlias

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
