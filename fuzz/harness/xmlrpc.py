"""XML-RPC documents: refused with our errors; a document that is read can be written, with the same values.

Limits are low. If Python's own reader also accepts a document, the values must be the same.
"""

from __future__ import annotations

import contextlib
import random
import xmlrpc.client
from collections.abc import Sequence

from fuzz.grammar import near
from fuzz.lowering import lowered
from rostether.errors import RostetherError, SerializationError
from rostether.xmlrpc import document_reader
from rostether.xmlrpc.document_reader import DocumentReader, load_call
from rostether.xmlrpc.document_writer import DocumentWriter, call_steps, dump_fault, dump_response
from rostether.xmlrpc.values import XmlRpcValue

MAX_VALUES, MAX_NESTING = 40, 8
_CALL = "<methodCall><methodName>a</methodName><params>%s</params></methodCall>"


def dump_call(method: str, params: Sequence[object]) -> bytes:
    """Return a methodCall document."""
    writer = DocumentWriter()
    for _ in call_steps(writer, method, params):
        pass
    return writer.document()


def load_response(document: bytes) -> XmlRpcValue:
    """Return the value of a methodResponse. Raises FaultError, RemoteProtocolError."""
    reader = DocumentReader(document)
    for _ in reader.steps():
        pass
    return reader.response()


def seeds() -> list[bytes]:
    """Return calls, responses, a fault, and a document whose entities expand exponentially."""
    return [
        dump_call("registerPublisher", ["/node", "/topic", "std_msgs/String", "http://host:1/"]),
        dump_call("setParam", ["/n", "/p", {"a": [1, 2.5, True, "x"], "b": b"\0"}]),
        dump_response([1, "ok", {"k": [[]]}]),
        dump_fault(1, "no"),
        b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "bb">]><methodCall>&b;</methodCall>',
        b"<methodCall><methodName>a</methodName><params><param>" + b"<value><array><data>" * 40,
    ]


def generate(source: random.Random) -> bytes:
    """Return a call with values of all kinds, and numbers and depths near the limits."""
    chance = source.random()
    if chance < 0.2:
        depth = near(source, MAX_NESTING) % 12
        values = ["<array><data><value>" * depth + "<int>1</int>" + "</value></data></array>" * depth]
    elif chance < 0.4:
        values = ["<int>1</int>"] * (near(source, MAX_VALUES) % 60)
    else:
        values = [_value(source, 0) for _ in range(source.randint(0, 5))]
    params = "".join(f"<param><value>{value}</value></param>" for value in values)
    doctype = "<!DOCTYPE a>" if source.random() < 0.05 else ""
    return (doctype + _CALL % params).encode()


def _value(source: random.Random, depth: int) -> str:
    match source.randrange(9 if depth < 4 else 6):
        case 0:
            number = source.choice(
                (0, -1, 2**31 - 1, 2**31, -(2**31), -(2**31) - 1, 10**70, near(source, 2**31))
            )
            return f"<{(tag := source.choice(('int', 'i4', 'i8')))}>{number}</{tag}>"
        case 1:
            return f"<boolean>{source.choice(('0', '1', '2', 'true', ''))}</boolean>"
        case 2:
            return f"<double>{source.choice(('1.5', '-0.0', '1e400', 'nan', 'x', ''))}</double>"
        case 3:
            return source.choice(("plain", "<string>a&lt;b</string>", "<string/>", "<nil/>", "&#228;"))
        case 4:
            return f"<base64>{source.choice(('AAEC', 'A', '====', ''))}</base64>"
        case 5:
            return "<dateTime.iso8601>20200101T00:00:00</dateTime.iso8601>"
        case 6:
            members = "".join(
                f"<member><name>{name}</name><value>{_value(source, depth + 1)}</value></member>"
                for name in source.sample("abc", source.randint(0, 3))
            )
            return f"<struct>{members}</struct>"
        case _:
            items = "".join(
                f"<value>{_value(source, depth + 1)}</value>" for _ in range(source.randint(0, 3))
            )
            return f"<array><data>{items}</data></array>"


def run(data: bytes) -> None:
    """Read the data as a call and as a response."""
    with lowered(document_reader, MAX_VALUES=MAX_VALUES, MAX_NESTING=MAX_NESTING):
        _read(data)


def _read(data: bytes) -> None:
    with contextlib.suppress(RostetherError):
        method, params = load_call(data)
        assert b"<!DOCTYPE" not in data, "a document type declaration was read"
        _check(params)
        with contextlib.suppress(SerializationError):
            assert repr(load_call(dump_call(method, params))) == repr((method, params))
        with contextlib.suppress(Exception):
            theirs, _ = xmlrpc.client.loads(data, use_builtin_types=True)
            if _is_plain(list(theirs)):
                assert repr(list(theirs)) == repr(params), "the values differ from those of Python's reader"
    with contextlib.suppress(RostetherError):
        value = load_response(data)
        with contextlib.suppress(SerializationError):
            assert repr(load_response(dump_response(value))) == repr(value)


def _check(params: Sequence[object]) -> None:
    """Check that the values respect the limits."""
    count, level = 0, list[object](params)
    depth = 0
    while level:
        count += len(level)
        assert count <= MAX_VALUES, "more values than allowed"
        for value in level:
            if isinstance(value, int) and not isinstance(value, bool):
                assert -(2**31) <= value < 2**31, "a number of more than 32 bits"
        containers = [value for value in level if isinstance(value, list | dict)]
        depth += bool(containers)
        level = [
            inner for value in containers for inner in (value.values() if isinstance(value, dict) else value)
        ]
    assert depth <= MAX_NESTING, "nested deeper than allowed"


def _is_plain(value: object) -> bool:
    """Return whether both readers have the same types for a value: Python's does not return bytes."""
    if isinstance(value, list):
        return all(map(_is_plain, value))
    if isinstance(value, dict):
        return all(map(_is_plain, value.values()))
    return isinstance(value, int | str | None)
