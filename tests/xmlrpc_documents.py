"""Reads and writes XML-RPC documents in one step; rostether does it in pieces."""

from __future__ import annotations

from collections.abc import Sequence

from rostether.xmlrpc.document_reader import DocumentReader
from rostether.xmlrpc.document_writer import DocumentWriter, call_steps
from rostether.xmlrpc.values import XmlRpcValue


def load_response(document: bytes) -> XmlRpcValue:
    """Return the value of a methodResponse. Raises FaultError, RemoteProtocolError."""
    reader = DocumentReader(document)
    for _ in reader.steps():
        pass
    return reader.response()


def dump_call(method: str, params: Sequence[object]) -> bytes:
    """Return a methodCall document. Raises SerializationError for a value XML-RPC cannot carry."""
    writer = DocumentWriter()
    for _ in call_steps(writer, method, params):
        pass
    return writer.document()
