"""The XML-RPC codec, compared with the standard library's and with documents of real ROS peers."""

from __future__ import annotations

import datetime
import math
import xmlrpc.client
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rostether.errors import RemoteProtocolError, SerializationError
from rostether.xmlrpc.document_reader import load_call
from rostether.xmlrpc.document_writer import dump_fault, dump_response
from rostether.xmlrpc.values import MAX_INT, MAX_NESTING, MIN_INT, DateTime, FaultError, XmlRpcValue
from xmlrpc_documents import dump_call, load_response

# Carriage returns are omitted: XML reads them as line feeds.
XML_TEXT = st.text(
    st.characters(
        exclude_categories=["Cs", "Cc"], exclude_characters="\ufffe\uffff", include_characters="\n\t"
    )
)
SCALARS = (
    st.booleans()
    | st.integers(MIN_INT, MAX_INT)
    | st.floats(allow_nan=False)
    | XML_TEXT
    | st.binary(max_size=50)
)
VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(XML_TEXT, inner, max_size=4)
)


def response(value: str) -> bytes:
    return f"<methodResponse><params><param>{value}</param></params></methodResponse>".encode()


def loads_stdlib(document: bytes) -> Any:
    return xmlrpc.client.loads(document, use_builtin_types=True)


@given(st.lists(VALUES, max_size=3))
def test_stdlib_reads_what_we_write(params: list[XmlRpcValue]) -> None:
    assert loads_stdlib(dump_call("setParam", params)) == (tuple(params), "setParam")


@given(st.lists(VALUES, max_size=3))
def test_we_read_what_stdlib_writes(params: list[XmlRpcValue]) -> None:
    document = xmlrpc.client.dumps(tuple(params), "setParam").encode()
    assert load_call(document) == ("setParam", params)


@given(VALUES)
def test_a_response_comes_back(value: XmlRpcValue) -> None:
    answer = load_response(dump_response(value))
    assert answer == value
    assert type(answer) is type(value)


@given(st.binary(max_size=300))
def test_garbage_raises_only_our_error(document: bytes) -> None:
    with pytest.raises(RemoteProtocolError):
        load_call(document)


@given(st.data())
def test_a_damaged_document_raises_only_our_error(data: st.DataObject) -> None:
    document = bytearray(dump_call("m", [data.draw(VALUES)]))
    for _ in range(3):
        document[data.draw(st.integers(0, len(document) - 1))] = data.draw(st.integers(0, 255))
    try:
        load_call(bytes(document))
    except RemoteProtocolError as error:
        assert "\n" not in str(error)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("<value>bare text</value>", "bare text"),
        ("<value></value>", ""),
        ("<value/>", ""),
        ("<value>  kept  </value>", "  kept  "),
        ("<value><string></string></value>", ""),
        ("<value><string/></value>", ""),
        ("<value>\n <i4> -7 </i4>\r\n</value>", -7),
        ("<value><int>+5</int></value>", 5),
        ("<value><i8>12</i8></value>", 12),
        ("<value><boolean>1</boolean></value>", True),
        ("<value><boolean>false</boolean></value>", False),
        ("<value><double>0.10000000000000001</double></value>", 0.1),
        ("<value><double> 3 </double></value>", 3.0),
        ("<value><double>inf</double></value>", math.inf),
        ("<value><base64>\nAAEC\n/w==\n</base64></value>", b"\x00\x01\x02\xff"),
        ("<value><nil/></value>", None),
        ("<value><array><data/></array></value>", []),
        ("<value><array><data></data></array></value>", []),
        ("<value><struct></struct></value>", {}),
        ("<value><struct/></value>", {}),
        (
            "<value><struct><member><name>a</name>\n<value>1</value></member>\t"
            "<member><name>b</name><value><array><data><value>x</value>\n<value><int>2</int></value>"
            "</data></array></value></member></struct></value>",
            {"a": "1", "b": ["x", 2]},
        ),
        ("<value><string>a&lt;b&amp;c&gt;&quot;&apos;&#65;</string></value>", "a<b&c>\"'A"),
        ("<value><string><![CDATA[<x>]]></string></value>", "<x>"),
        ("<value><string>a<!-- note -->b</string></value>", "ab"),
    ],
)
def test_what_peers_send(text: str, value: XmlRpcValue) -> None:
    answer = load_response(response(text))
    assert answer == value
    assert type(answer) is type(value)


def test_nan_arrives() -> None:
    answer = load_response(dump_response(math.nan))
    assert isinstance(answer, float)
    assert math.isnan(answer)


def test_roscpp_call_is_read() -> None:
    # As XmlRpc++ writes it: no white space in the body, line ends around the params.
    document = (
        b'<?xml version="1.0"?>\r\n<methodCall><methodName>getParam</methodName>\r\n<params><param>'
        b"<value>/node</value></param><param><value>/use_sim_time</value></param></params></methodCall>\r\n"
    )
    assert load_call(document) == ("getParam", ["/node", "/use_sim_time"])


def test_call_without_params_is_read() -> None:
    assert load_call(b"<methodCall><methodName> getPid </methodName></methodCall>") == ("getPid", [])


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "iso-8859-1"])
def test_declared_encodings_are_read(encoding: str) -> None:
    text = f"<?xml version='1.0' encoding='{encoding}'?>{response('<value>Grün</value>').decode()}"
    assert load_response(text.encode(encoding)) == "Grün"


def test_dates_are_sent_back_unchanged() -> None:
    date = xmlrpc.client.DateTime(datetime.datetime(2024, 5, 6, 7, 8, 9))
    answer = load_response(xmlrpc.client.dumps((date,), methodresponse=True).encode())
    assert answer == "20240506T07:08:09"
    assert isinstance(answer, DateTime)
    assert xmlrpc.client.loads(dump_response(answer))[0] == (date,)


def test_roscpp_can_read_what_we_write() -> None:
    # roscpp's parser knows five entities, no numeric references, no empty-element tags, no attributes.
    document = dump_response([1, "<\"'&>\n", {}, [], "", True, 0.5]).decode()
    assert "&#" not in document
    assert "/>" not in document
    assert document.count("<array><data></data></array>") == 1


def test_whole_numbers_keep_their_kind() -> None:
    assert [type(value) for value in _list(load_response(dump_response([1.0, 1, True])))] == [
        float,
        int,
        bool,
    ]


def _list(value: XmlRpcValue) -> list[XmlRpcValue]:
    assert isinstance(value, list)
    return value


def test_subclasses_are_written_like_their_base_classes() -> None:
    class Name(str):
        __slots__ = ()

    assert load_response(dump_response((Name("x"), bytearray(b"ab")))) == ["x", b"ab"]


def test_a_fault_is_raised_with_its_code() -> None:
    with pytest.raises(FaultError, match="no such \\? thing") as raised:
        load_response(dump_fault(7, "no such \x1b thing"))
    assert raised.value.code == 7


def test_stdlib_reads_our_fault() -> None:
    with pytest.raises(xmlrpc.client.Fault, match="Fault 3: 'why'"):
        xmlrpc.client.loads(dump_fault(3, "why"))


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (2**31, "32 bits"),
        (-(2**31) - 1, "32 bits"),
        (None, "cannot carry None"),
        ({1: 2}, "key 1"),
        (object(), "cannot carry"),
        ("bell \x07", r"U\+0007"),
        ("\udcff", r"U\+DCFF"),
        ({"\x00": 1}, r"U\+0000"),
    ],
)
def test_what_cannot_be_sent_is_refused(value: object, reason: str) -> None:
    with pytest.raises(SerializationError, match=reason):
        dump_response(value)


def test_too_deep_values_are_not_written() -> None:
    value: XmlRpcValue = 1
    for _ in range(MAX_NESTING):
        value = [value]
    assert load_response(dump_response(value)) == value
    with pytest.raises(SerializationError, match="deeper than 100"):
        dump_response([value])


def test_too_deep_values_are_not_read() -> None:
    deep = "<value><array><data>" * 10_000
    with pytest.raises(RemoteProtocolError, match="deeper than 100"):
        load_response(response(deep))


@pytest.mark.parametrize(
    "declaration",
    [
        "<!DOCTYPE methodResponse>",
        '<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;">]>',
        '<!DOCTYPE x SYSTEM "file:///etc/passwd">',
    ],
)
def test_document_types_are_refused(declaration: str) -> None:
    document = f"<?xml version='1.0'?>{declaration}".encode() + response("<value>&b;</value>")
    with pytest.raises(RemoteProtocolError, match="document type declaration"):
        load_response(document)


@pytest.mark.parametrize(
    ("document", "reason"),
    [
        (b"", "cannot be read"),
        (b"GET / HTTP/1.1", "cannot be read"),
        (b"<html></html>", "no <html>"),
        (response("<value><int>x</int></value>"), "cannot be read"),
        (response("<value><int>2147483648</int></value>"), "32 bits"),
        (response("<value><int>" + "9" * 100_000 + "</int></value>"), "32 bits"),
        (response("<value><boolean>2</boolean></value>"), "cannot be read"),
        (response("<value><base64>A</base64></value>"), "cannot be read"),
        (response("<value><nil>x</nil></value>"), "nil"),
        (response("<value><int>1</int><int>2</int></value>"), "two values"),
        (response("<value><struct><member><value>1</value></member></struct></value>"), "without a name"),
        (response("<value><float>1</float></value>"), "no <float>"),
        (response("<value>1</value>") + b"x", "cannot be read"),
        (b"<methodResponse></methodResponse>", "one value"),
        (b"<methodResponse><params></params></methodResponse>", "one value"),
        (b"<methodResponse><fault><value>text</value></fault></methodResponse>", "not a struct"),
        (dump_call("x", [1]), "not a response"),
    ],
)
def test_invalid_documents_are_refused(document: bytes, reason: str) -> None:
    with pytest.raises(RemoteProtocolError, match=reason):
        load_response(document)


def test_a_response_is_not_a_call() -> None:
    with pytest.raises(RemoteProtocolError, match="not a method call"):
        load_call(dump_response(1))
