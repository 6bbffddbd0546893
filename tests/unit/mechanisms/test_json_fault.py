from __future__ import annotations

from typing import Annotated, Any

import msgspec
import pytest

from rostether.mechanisms.json_fault import explain_fault


class _Settings(msgspec.Struct):
    baud: Annotated[int, msgspec.Meta(ge=1)]
    ports: list[str] = []
    limits: dict[str, Any] | None = None


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('{"baud": "fast"}', "baud: expected integer, got string"),
        ('{"baud": 0}', "baud: expected integer >= 1"),
        ('{"baud": 9, "ports": [true]}', "ports[0]: expected string, got boolean"),
        ('{"baud": 9, "limits": 1.5}', "limits: expected object or null, got number"),
        ("{}", "object missing required field baud"),
        ("[]", "expected object, got array"),
        ("baud", "JSON is malformed: invalid character (byte 0)"),
        ("{", "input data was truncated"),
    ],
)
def test_the_reason_has_the_place_and_the_types_of_json(text: str, reason: str) -> None:
    with pytest.raises(msgspec.DecodeError) as failure:
        msgspec.json.decode(text, type=_Settings)
    assert explain_fault(failure.value) == reason


def test_bytes_that_are_not_utf8_are_named() -> None:
    with pytest.raises(UnicodeDecodeError) as failure:
        msgspec.json.decode(b'["\xe9"]')
    assert explain_fault(failure.value) == "not UTF-8 text at byte 0"
