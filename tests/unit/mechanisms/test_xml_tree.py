from __future__ import annotations

import pytest

from rostether.mechanisms.xml_tree import MAX_DEPTH, XmlElement, parse_xml

BOMB = b"""<!DOCTYPE a [<!ENTITY x "xxxxxxxxxx"><!ENTITY y "&x;&x;&x;&x;&x;&x;&x;&x;">]><a>&y;</a>"""


def parse(data: bytes, encoding: str | None = None) -> XmlElement:
    return parse_xml(
        data,
        file="arm.xml",
        max_bytes=1000,
        what="an arm",
        make_error=lambda text, line: ValueError(f"{line}: {text}"),
        encoding=encoding,
    )


def test_a_document_becomes_a_tree() -> None:
    root = parse(b'<arm a="1">\n one <b>two</b> three\n <c x:y="z"/><b/></arm>')
    assert (root.tag, root.attributes, root.file, root.line) == ("arm", {"a": "1"}, "arm.xml", 1)
    assert [(child.tag, child.line) for child in root.children] == [("b", 2), ("c", 3), ("b", 3)]
    assert root.text.split() == ["one", "three"]
    assert root.full_text.split() == ["one", "two", "three"]
    assert [child.text for child in root.all("b")] == ["two", ""]
    assert (root.get("a"), root.get("b"), root.first("d")) == ("1", None, None)
    assert str(root.children[1].error("broken")) == "3: broken"


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "empty, so it is not "),
        (b"<a>\n<b></a>", "2: not XML: mismatched tag"),
        (b"\xff\xfe\x00", "not XML"),
        (b"<?xml version='1.0' encoding='utf-7'?><a/>", "0: not XML: its encoding is unknown"),
        (b"<?xml version='1.0' encoding='hex'?><a/>", "0: not XML: its encoding is unknown"),
        (
            b"<a>\n <b>\n</a>",
            "3: not XML: mismatched tag at .*: <b> of line 2 is not closed before </a>",
        ),
        (b"<a>\n <b>", "2: not XML: no element found at column 5: <b> of line 2 is not closed"),
        (b"<a b='x & y'/>", "1: not XML: .* at column 10: write &amp; for &"),
        (b"<a b='x &y z'/>", "write &amp; for &"),
        (b"<a>x & y</a>", "write &amp; for &"),
        (b"<a b='x < y'/>", "write &lt; for < in an attribute"),
        (b"<a b=c/>", "1: not XML: .* at column 6: the value of an attribute must be in quotes, at 'c/>'"),
        (b"<a><!-- x -- y --></a>", "a comment must not contain --"),
        (b"<a/><b/>", "only one root element is allowed"),
        (b"<a>&undefined;</a>", "1: not XML: undefined entity"),
        (BOMB, "1: declares a DTD or an entity, which is not allowed; remove it"),
        (b"\n<!DOCTYPE a SYSTEM 'file:///etc/passwd'><a/>", "2: declares a DTD"),
        (b"<a>" * (MAX_DEPTH + 1), f"1: elements are nested deeper than {MAX_DEPTH}"),
        (b" " * 1001, "0: larger than 1000 bytes, so it is not an arm"),
    ],
)
def test_what_is_refused(data: bytes, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        parse(data)


def test_the_encoding_of_text_that_was_decoded_is_known() -> None:
    data = '<?xml version="1.0" encoding="latin-1"?><a>grün</a>'.encode()
    assert parse(data).text == "grÃ¼n"
    assert parse(data, "utf-8").text == "grün"
