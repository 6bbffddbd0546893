"""XML-RPC documents: refused with our errors; what is read can be written and is then read alike."""

from __future__ import annotations

import contextlib

from rostether.errors import RostetherError, SerializationError
from rostether.xmlrpc.document_reader import load_call, load_response
from rostether.xmlrpc.document_writer import dump_call, dump_fault, dump_response


def seeds() -> list[bytes]:
    """Return calls, responses, a fault, and a bomb of entities."""
    return [
        dump_call("registerPublisher", ["/node", "/topic", "std_msgs/String", "http://host:1/"]),
        dump_call("setParam", ["/n", "/p", {"a": [1, 2.5, True, "x"], "b": b"\0"}]),
        dump_response([1, "ok", {"k": [[]]}]),
        dump_fault(1, "no"),
        b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "bb">]><methodCall>&b;</methodCall>',
        b"<methodCall><methodName>a</methodName><params><param>" + b"<value><array><data>" * 40,
    ]


def run(data: bytes) -> None:
    """Read as a call and as a response."""
    with contextlib.suppress(RostetherError):
        method, params = load_call(data)
        with contextlib.suppress(SerializationError):
            assert repr(load_call(dump_call(method, params))) == repr((method, params))
    with contextlib.suppress(RostetherError):
        value = load_response(data)
        with contextlib.suppress(SerializationError):
            assert repr(load_response(dump_response(value))) == repr(value)
