"""Reads XML-RPC documents: calls, responses and faults, with limits on all that a peer can make large."""

from __future__ import annotations

import binascii
from collections.abc import Callable, Iterator, Mapping
from xml.parsers import expat

from rostether.errors import RemoteProtocolError
from rostether.xmlrpc.values import MAX_INT, MAX_NESTING, MIN_INT, DateTime, FaultError, XmlRpcValue

# Reading, checking and storing them takes a few tenths of a second; points and images are sent on topics.
MAX_VALUES = 262_144
# The bytes that are read in one step, which takes about 2 ms.
STEP_BYTES = 16 * 1024
# Tags of ROS peers have about 20 bytes, and expat reads an incomplete one again in each step.
MAX_TAG_BYTES = 64 * 1024


def load_call(document: bytes) -> tuple[str, list[XmlRpcValue]]:
    """Return the method name and the arguments of a methodCall. Raises RemoteProtocolError."""
    reader = DocumentReader(document)
    for _ in reader.steps():
        pass
    return reader.call()


def _read_int(text: str) -> int:
    # A sign, ten digits, spaces and leading zeros fit; int() takes quadratic time for a longer text.
    value = int(text) if len(text) <= 64 else MAX_INT + 1
    if not MIN_INT <= value <= MAX_INT:
        raise ValueError(f"{text:.40} does not fit in 32 bits")
    return value


def _read_boolean(text: str) -> bool:
    return {"0": False, "1": True, "false": False, "true": True}[text.strip().lower()]


def _read_nil(text: str) -> None:
    if text.strip():
        raise ValueError("nil with content")


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


class DocumentReader:
    """Reads one document in `steps` of a few ms, which do not block the event loop, then returns its content.

    `params` are the call's arguments, or the one value of a response or fault. A value is complete at its end
    tag and goes into the innermost container: `params` at the bottom, then one list or dict for each array or
    struct that is open.
    """

    def __init__(self, document: bytes) -> None:
        self._document = document
        self._count = 0
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

    def steps(self) -> Iterator[None]:
        """Read a part of the document in each step; called once. Raises RemoteProtocolError."""
        document = self._document
        # Not an attribute: it refers to this object, and its 12 KB would wait for the garbage collector.
        parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.StartDoctypeDeclHandler = _refuse_doctype
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._text.append
        try:
            for start in range(0, len(document), STEP_BYTES):
                end = start + STEP_BYTES
                parser.Parse(document[start:end], False)
                if min(end, len(document)) - parser.CurrentByteIndex > MAX_TAG_BYTES:
                    raise RemoteProtocolError(
                        f"an XML-RPC document must not have tags of more than {MAX_TAG_BYTES} bytes"
                    )
                yield
            parser.Parse(b"", True)
        except (expat.ExpatError, ValueError, LookupError) as error:
            raise RemoteProtocolError(f"the XML-RPC document cannot be read: {error}") from None

    def call(self) -> tuple[str, list[XmlRpcValue]]:
        """Return the method name and the arguments of a methodCall. Raises RemoteProtocolError."""
        if self.method is None or self.root != "methodCall":
            raise RemoteProtocolError("the XML-RPC document is not a method call")
        return self.method, self.params

    def response(self) -> XmlRpcValue:
        """Return the value of a methodResponse. Raises FaultError, RemoteProtocolError for anything else."""
        if self.root != "methodResponse" or len(self.params) != 1:
            raise RemoteProtocolError("the XML-RPC document is not a response with one value")
        value = self.params[0]
        if not self.is_fault:
            return value
        if not isinstance(value, dict):
            raise RemoteProtocolError("the XML-RPC fault is not a struct")
        code = value.get("faultCode")
        text = str(value.get("faultString", "no reason given"))
        raise FaultError(code if isinstance(code, int) else -1, text)

    def _start(self, tag: str, _attributes: Mapping[str, str]) -> None:
        parent = self._path[-1]
        if tag not in _CHILDREN.get(parent, _NO_CHILDREN):
            raise RemoteProtocolError(f"an XML-RPC document has no <{tag:.40}> in <{parent}>")
        self._path.append(tag)
        self._text.clear()
        if parent == "value" and self._has_value:
            raise RemoteProtocolError("an XML-RPC value contains two values")
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
        self._count += 1
        if self._count > MAX_VALUES:
            raise RemoteProtocolError(f"an XML-RPC document has at most {MAX_VALUES} values")
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
