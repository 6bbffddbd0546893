from __future__ import annotations

from rostether.ros2.zenoh.attachment import Attachment, gid_of, parse_attachment

GID = bytes(range(16))


def test_the_33_bytes() -> None:
    data = Attachment(1, 0x0102030405060708, GID).encode()
    assert data == b"\1" + bytes(7) + bytes.fromhex("0807060504030201") + b"\x10" + GID
    assert parse_attachment(data) == Attachment(1, 0x0102030405060708, GID)


def test_invalid_attachments_are_none() -> None:
    good = Attachment(7, 8, GID).encode()
    assert parse_attachment(b"") is None
    assert parse_attachment(good[:-1]) is None
    assert parse_attachment(good[:16] + b"\x0f" + good[17:]) is None
    assert parse_attachment(good + b"more") == Attachment(7, 8, GID)


def test_a_gid_is_the_tokens_hash_low_half_first() -> None:
    # XXH3-128's own value for the empty text is 99aa06d3014798d8 6001c324468d497f (high, low).
    assert gid_of("").hex() == "7f498d4624c30160" + "d8984701d306aa99"
    assert gid_of("@ros2_lv/0/a") != gid_of("@ros2_lv/0/b")
