"""Bytes of one side become bytes of the other, and what fits neither is refused with a reason."""

from __future__ import annotations

import struct

import pytest

from rostether.errors import DefinitionError, SerializationError
from rostether.serde.cdr import converter_source
from unit.serde.cdr.pairs import Pairs, own_fields, pair

HEAD = b"\0\1\0\0"


def u32(value: int) -> bytes:
    return struct.pack("<I", value)


def text(value: bytes) -> bytes:
    return u32(len(value)) + value


# Fields of both sides, a ROS 1 payload, and the CDR without its encapsulation.
PAYLOADS = {
    "string": ("string a", "string a", text(b"abc"), u32(4) + b"abc\0"),
    "empty string": ("string a", "string a", u32(0), u32(1) + b"\0"),
    "number behind a number": ("uint8 a\nfloat64 b", "uint8 a\nfloat64 b", b"\7" + bytes(7) + b"\1",
                               b"\7" + bytes(14) + b"\1"),
    "number behind a string": ("string a\nint16 b", "string a\nint16 b", text(b"ab") + b"\1\2",
                               u32(3) + b"ab\0\0\1\2"),
    "bytes behind a string": ("string a\nuint8[] b", "string a\nuint8[] b", text(b"") + text(b"xy"),
                              u32(1) + b"\0\0\0\0" + text(b"xy")),
    "sequence of float64": ("float64[] a", "float64[] a", u32(1) + b"12345678",
                            u32(1) + bytes(4) + b"12345678"),
    "empty sequence of float64, nothing aligned": ("float64[] a\nuint32 b", "float64[] a\nuint32 b",
                                                   u32(0) + u32(9), u32(0) + u32(9)),
    "sequence of float64 already aligned": ("uint32 x\nfloat64[] a", "uint32 x\nfloat64[] a",
                                            u32(5) + u32(1) + b"12345678", u32(5) + u32(1) + b"12345678"),
    "string behind a sequence": ("float64[] a\nstring b", "float64[] a\nstring b",
                                 u32(1) + b"12345678" + text(b"q"),
                                 u32(1) + bytes(4) + b"12345678" + u32(2) + b"q\0"),
    "strings": ("string[] a", "string[] a", u32(2) + text(b"a") + text(b""),
                u32(2) + u32(2) + b"a\0" + b"\0\0" + u32(1) + b"\0"),
    "two strings": ("string[2] a", "string[2] a", text(b"a") + text(b""),
                    u32(2) + b"a\0" + b"\0\0" + u32(1) + b"\0"),
    # As rclpy serializes test_msgs/WStrings with "ab" and an emoji.
    "wstring": ("string a", "wstring a", text("ab\N{GRINNING FACE}".encode()),
                u32(4) + u32(0x61) + u32(0x62) + u32(0xD83D) + u32(0xDE00)),
    "empty wstring": ("string a", "wstring a", u32(0), u32(0)),
    "number behind a wstring": ("uint8 x\nstring a\nfloat64 b", "uint8 x\nwstring a\nfloat64 b",
                                b"\7" + text("ä".encode()) + b"12345678",
                                b"\7\0\0\0" + u32(1) + u32(0xE4) + bytes(4) + b"12345678"),
    "wstrings": ("string[] a\nstring b", "wstring[] a\nwstring b",
                 u32(2) + text(b"a") + text(b"") + text(b"q"),
                 u32(2) + u32(1) + u32(0x61) + u32(0) + u32(1) + u32(0x71)),
    "wstring in another order": ("string a\nuint16 c", "uint16 c\nwstring a",
                                 text(b"xy") + b"\1\2", b"\1\2\0\0" + u32(2) + u32(0x78) + u32(0x79)),
    "stamp": ("time a", "builtin_interfaces/Time a", b"12345678", b"12345678"),
    "durations": ("duration[] a", "builtin_interfaces/Duration[] a", text(b"")[:4], u32(0)),
    "header without its number": ("Header h", "std_msgs/Header h", u32(0) + b"12345678" + text(b"m"),
                                  b"12345678" + u32(2) + b"m\0"),
    "nothing": ("", "", b"", b"\0"),
    "renamed by case": ("float64[2] K", "float64[2] k", b"1234567812345678", b"1234567812345678"),
    "another order": ("uint8 a\nstring b\nuint16 c", "uint16 c\nstring b\nuint8 a",
                      b"\5" + text(b"xy") + b"\1\2", b"\1\2\0\0" + u32(3) + b"xy\0" + b"\5"),
    "byte": ("byte a\nchar b", "byte a\nchar b", b"\xff\xfe", b"\xff\xfe"),
    "bools": ("bool a\nbool[2] b\nbool[] c", "bool a\nbool[2] b\nbool[] c",
              b"\1\0\1" + text(b"\0\1"), b"\1\0\1\0" + text(b"\0\1")),
}  # fmt: skip


@pytest.mark.parametrize("name", PAYLOADS)
def test_payload_and_cdr(name: str) -> None:
    ros1, ros2, payload, cdr = PAYLOADS[name]
    converter = pair(ros1, ros2)
    assert converter.to_cdr(payload) == HEAD + cdr
    assert converter.from_cdr(HEAD + cdr) == payload


@pytest.mark.parametrize("name", [name for name in PAYLOADS if name != "nothing"])
def test_every_cut_and_excess_is_refused(name: str) -> None:
    ros1, ros2, payload, cdr = PAYLOADS[name]
    converter = pair(ros1, ros2)
    for size in range(len(payload)):
        with pytest.raises(SerializationError, match=r"test/M: the payload of \d+ bytes? .* in field"):
            converter.to_cdr(payload[:size])
    with pytest.raises(SerializationError, match="1 byte more than test/M"):
        converter.to_cdr(payload + b"\0")
    for size in range(len(HEAD + cdr)):
        with pytest.raises(SerializationError):
            converter.from_cdr((HEAD + cdr)[:size])


@pytest.mark.parametrize("name", PAYLOADS)
def test_padding_after_cdr_is_not_part_of_it(name: str) -> None:
    ros1, ros2, payload, cdr = PAYLOADS[name]
    assert pair(ros1, ros2).from_cdr(HEAD + cdr + bytes(3)) == payload


def test_fields_of_one_side() -> None:
    converter = pair("uint8 a\nuint16 gone\nstring lost", "uint8 a")
    assert own_fields(converter)[0] == ("gone", "lost")
    assert converter.to_cdr(b"\7\1\1" + text(b"abc")) == HEAD + b"\7"
    assert converter.from_cdr(HEAD + b"\7") == b"\7\0\0" + u32(0)

    converter = pair("uint8 a", 'uint8 a\nfloat64 b 1.5\nstring c "hi"\nint16[] d [1, 2]\nbool e')
    assert own_fields(converter)[1] == ("b", "c", "d", "e")
    cdr = converter.to_cdr(b"\7")
    assert cdr[4:] == (
        b"\7" + bytes(7) + struct.pack("<d", 1.5) + u32(3) + b"hi\0\0" + u32(2) + b"\1\0\2\0" + b"\0"
    )  # fmt: skip
    assert converter.from_cdr(cdr) == b"\7"


def test_records_that_one_side_lacks() -> None:
    inner = "uint8 x\nfloat64 y\nstring[] z"
    pairs = Pairs({"M": "N[] n\nuint8 a", "N": inner}, {"M": "uint8 a"})
    payload = u32(2) + 2 * (bytes(9) + u32(1) + text(b"abc")) + b"\5"
    assert pairs.converter().to_cdr(payload) == HEAD + b"\5"
    pairs = Pairs({"M": "uint8 a"}, {"M": "N[] n\nN[2] m\nuint8 a", "N": inner})
    cdr = pairs.converter().to_cdr(b"\5")
    assert pairs.converter().from_cdr(cdr) == b"\5"
    element = b"\1" + bytes(3) + b"12345678"
    full = u32(1) + element + u32(1) + u32(2) + b"a\0" + b"\1" + bytes(5) + b"12345678" + u32(0)
    full += element + u32(0) + b"\5"
    assert pairs.converter().from_cdr(HEAD + full) == b"\5"


def test_records_with_padding_inside() -> None:
    inner = "uint8 x\nfloat32 y"
    pairs = Pairs({"M": "N[] n", "N": inner}, {"M": "N[] n", "N": inner})
    converter = pairs.converter()
    assert converter.to_cdr(u32(2) + b"\1abcd\2efgh") == HEAD + u32(2) + b"\1\0\0\0abcd\2\0\0\0efgh"
    assert converter.from_cdr(converter.to_cdr(u32(2) + b"\1abcd\2efgh")) == u32(2) + b"\1abcd\2efgh"


def test_record_is_aligned_like_its_first_field() -> None:
    inner = "float32 x\nfloat32 y\nfloat64 z"
    converter = Pairs({"M": "float32 a\nN n", "N": inner}, {"M": "float32 a\nN n", "N": inner}).converter()
    assert converter.to_cdr(b"aaaaxxxxyyyyzzzzzzzz") == HEAD + b"aaaaxxxxyyyy" + bytes(4) + b"zzzzzzzz"


def test_bounds() -> None:
    converter = pair("string a\nuint8[] b", "string<=3 a\nuint8[<=2] b")
    assert converter.to_cdr(text(b"abc") + text(b"12"))
    with pytest.raises(SerializationError, match="4 bytes in field 'a', but ROS 2 allows at most 3"):
        converter.to_cdr(text(b"abcd") + text(b""))
    with pytest.raises(SerializationError, match="3 elements in field 'b', but ROS 2 allows at most 2"):
        converter.to_cdr(text(b"") + text(b"123"))
    wide = pair("string a", "wstring<=2 a")
    assert wide.to_cdr(text("äö".encode()))
    with pytest.raises(SerializationError, match="3 UTF-16 units in field 'a', but ROS 2 allows at most 2"):
        wide.to_cdr(text("äöü".encode()))


def test_wide_strings() -> None:
    wide = pair("uint8 x\nstring a", 'uint8 x\nwstring a\nwstring b "hö"')
    assert wide.to_cdr(b"\1" + text(b"q")) == (
        HEAD + b"\1\0\0\0" + u32(1) + u32(0x71) + u32(2) + u32(0x68) + u32(0xF6)
    )
    big = b"\0\0\0\0" + b"\1\0\0\0" + bytes([0, 0, 0, 1, 0, 0, 0, 0x71]) + bytes(4)
    assert wide.from_cdr(big) == b"\1" + text(b"q")
    # Invalid UTF-16: one surrogate of a pair, a unit of more than 16 bits, more units than bytes.
    head = HEAD + b"\1\0\0\0"
    assert wide.from_cdr(head + u32(1) + u32(0xD83D) + u32(0)) == b"\1" + text("\ufffd".encode())
    for units in (u32(1) + u32(0x10000) + u32(0), u32(1 << 31) + u32(0x71)):
        with pytest.raises(SerializationError):
            wide.from_cdr(head + units)


def test_odd_bools_become_true() -> None:
    converter = pair("bool a\nbool[] b", "bool a\nbool[] b")
    assert converter.to_cdr(b"\x80" + text(b"\2\0")) == HEAD + b"\1\0\0\0" + text(b"\1\0")


def test_strings_of_other_writers() -> None:
    converter = pair("string a\nuint8 b", "string a\nuint8 b")
    assert converter.from_cdr(HEAD + u32(0) + b"\5") == text(b"") + b"\5"
    assert converter.from_cdr(HEAD + u32(2) + b"ab\5") == text(b"ab") + b"\5"
    assert converter.from_cdr(HEAD + u32(3) + b"a\0\0\5") == text(b"a\0") + b"\5"


def test_message_without_fields_may_have_no_byte() -> None:
    converter = pair("", "")
    assert converter.from_cdr(HEAD) == b""
    assert converter.from_cdr(b"\0\0\0\0") == b""


def test_encapsulations() -> None:
    converter = pair("uint16 a\nfloat64[] b\nstring c", "uint16 a\nfloat64[] b\nstring c")
    payload = b"\1\2" + u32(1) + b"12345678" + text(b"hey")
    big = b"\0\0\0\3" + b"\2\1\0\0" + b"\0\0\0\1" + b"87654321" + b"\0\0\0\4" + b"hey\0"
    assert converter.from_cdr(big) == payload
    assert converter.from_cdr(b"\0\1\0\3" + converter.to_cdr(payload)[4:]) == payload
    for head in (b"\0\2\0\0", b"\0\3\0\0", b"\0\7\0\0", b"\1\1\0\0"):
        with pytest.raises(SerializationError, match="00 01 or 00 00"):
            converter.from_cdr(head + bytes(40))
    with pytest.raises(SerializationError, match="ends 1 byte early in field 'c'"):
        converter.from_cdr(big[:-1])


@pytest.mark.timeout(60)
@pytest.mark.parametrize("element", ["uint8", "float64", "string", "bool", "Empty", "Padded", "Texts"])
def test_announced_lengths_cost_nothing(element: str) -> None:
    inner = {"Empty": "", "Padded": "uint8 x\nfloat64 y", "Texts": "string s"}
    definitions = {"M": f"{element}[] a", **inner}
    converter = Pairs(definitions, definitions).converter()
    for count in (0xFFFFFFFF, 0x7FFFFFFF, 100_000_000):
        with pytest.raises(SerializationError):
            converter.to_cdr(u32(count) + bytes(40))
        with pytest.raises(SerializationError):
            converter.from_cdr(HEAD + u32(count) + bytes(40))
        with pytest.raises(SerializationError):
            converter.from_cdr(b"\0\0\0\0" + struct.pack(">I", count) + bytes(40))


def test_batches() -> None:
    converter = pair("string a", "string a")
    payloads = [text(b"a"), text(b"bc")]
    assert [converter.from_cdr(each) for each in converter.to_cdr_all(payloads)] == payloads
    assert converter.to_cdr_all([]) == []


def chain(link: str, length: int, last: str) -> Pairs:
    """Return definitions L0, L1 ... of which each holds the next as `link` says."""
    texts = {f"L{n}": link.replace("NEXT", f"L{n + 1}") for n in range(length)} | {f"L{length}": last}
    return Pairs(texts, texts)


@pytest.mark.timeout(60)
def test_types_that_double_at_each_level_stay_small() -> None:
    converter = chain("NEXT a\nNEXT b", 12, "string s\nuint64 n").converter("L0", "L0")
    payload = 4096 * (text(b"abc") + b"12345678")
    assert converter.from_cdr(converter.to_cdr(payload)) == payload
    converter = chain("NEXT a\nNEXT b", 14, "uint8 s\nuint64 n").converter("L0", "L0")
    payload = (1 << 14) * (b"\7" + b"12345678")
    assert converter.from_cdr(converter.to_cdr(payload)) == payload
    converter = chain("NEXT[] a\nNEXT[] b", 30, "uint8 s\nuint64 n").converter("L0", "L0")
    assert converter.from_cdr(converter.to_cdr(u32(1) + bytes(12))) == u32(1) + bytes(12)


def test_a_type_that_python_cannot_compile_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def gives_up(*_: object) -> None:
        raise RecursionError("maximum recursion depth exceeded during compilation")

    monkeypatch.setattr(converter_source, "compile", gives_up, raising=False)
    with pytest.raises(DefinitionError, match="test/M has too many arrays"):
        pair("float64[] a", "float64[] a")
