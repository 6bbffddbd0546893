"""The byte strings are examples of Digi's manuals, or worked out by hand from their tables."""

from __future__ import annotations

import pytest

from rostether.transports.xbee.packets import (
    AtAnswer,
    RadioPacket,
    RadioReport,
    TransmitStatus,
    encode_at,
    encode_packet,
    parse_report,
    status_text,
)
from rostether.transports.xbee.radio_address import parse_radio_address, show_radio_address


@pytest.mark.parametrize(
    ("destination", "is_mesh", "frame"),
    [
        (0x5001, False, "7E000A010150010048656C6C6FB8"),
        (0x0013A200400A0127, False, "7E 0010 00 01 0013A200400A0127 00 48656C6C6F E3"),
        (0x0013A200400A0127, True, "7E 00 7D33 10 01 0013A200400A0127 FFFE 00 00 48656C6C6F D6"),
    ],
)
def test_encode_a_packet(destination: int, is_mesh: bool, frame: str) -> None:
    encoded = encode_packet(destination, b"Hello", frame_id=1, is_mesh=is_mesh, limit_bytes=100)
    # In mode 2, 13 is escaped.
    assert encoded == bytes.fromhex(frame).replace(b"\x00\x13\xa2", b"\x00\x7d\x33\xa2")


def test_encode_refuses_a_payload_that_fits_in_no_packet() -> None:
    with pytest.raises(ValueError, match="100 bytes, not 101"):
        encode_packet(1, bytes(101), frame_id=1, limit_bytes=100)


def test_encode_an_at_command() -> None:
    assert encode_at("DL", frame_id=1) == bytes.fromhex("7E00040801444C66")


@pytest.mark.parametrize(
    ("frame", "report"),
    [
        ("815001280048656C6C6F", RadioPacket(0x5001, b"Hello", -0x28)),
        ("800013A200400A0127320048", RadioPacket(0x0013A200400A0127, b"H", -0x32)),
        ("900013A200400A0127FFFE0148", RadioPacket(0x0013A200400A0127, b"H", None, is_mesh=True)),
        ("890100", TransmitStatus(1, 0, None)),
        ("8B01FFFE022100", TransmitStatus(1, 0x21, 2)),
        ("880142440000000006", AtAnswer(1, "BD", True, b"\x00\x00\x00\x06")),
        ("88014E4802", AtAnswer(1, "NH", False, b"")),
        ("8A06", None),
        ("8150012", None),
        ("", None),
    ],
)
def test_parse(frame: str, report: RadioReport | None) -> None:
    assert parse_report(bytes.fromhex(frame + "0" * (len(frame) % 2))[: len(frame) // 2]) == report


def test_a_status_in_words() -> None:
    assert [status_text(each) for each in (0, 1, 2, 0x77)] == [
        "delivered",
        "no acknowledgement",
        "the channel is busy",
        "status 0x77",
    ]


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("1", 1),
        ("0x2a", 42),
        ("0013A20040A1B2C3", 0x0013A20040A1B2C3),
        ("0x0013a20040a1b2c3", 0x0013A20040A1B2C3),
        ("0xffff", None),
        ("65536", None),
        ("-1", None),
        ("one", None),
        ("000000000000ffff", None),
        ("", None),
    ],
)
def test_addresses(text: str, address: int | None) -> None:
    assert parse_radio_address(text) == address
    if address is not None:
        assert parse_radio_address(show_radio_address(address)) == address
