from __future__ import annotations

import hashlib
from typing import Any

import pytest

from rostether.gateways.rosbridge.rosauth import authenticates

NOW_S = 1_700_000_000.0


def authentication(**changes: Any) -> dict[str, Any]:
    """Return rosauth's message: the MAC is SHA-512 over the secret and all fields as text."""
    fields = {
        "client": "10.0.0.2",
        "dest": "10.0.0.1",
        "rand": "xyz",
        "t": int(NOW_S),
        "level": "admin",
        "end": int(NOW_S) + 60,
    } | {name: value for name, value in changes.items() if name != "mac"}
    text = "abc" + "".join(str(value) for value in fields.values())
    return {"op": "auth", "mac": changes.get("mac", hashlib.sha512(text.encode()).hexdigest()), **fields}


@pytest.mark.parametrize(
    ("message", "is_good"),
    [
        (authentication(), True),
        (authentication(t=int(NOW_S) - 4), True),
        (authentication(t=int(NOW_S) - 60), False),
        (authentication(end=int(NOW_S) - 1), False),
        (authentication(mac="0" * 128), False),
        (authentication(mac=7), False),
        (authentication(t="soon"), False),
        (authentication() | {"level": "guest"}, False),
        (authentication() | {"rand": None}, False),
        ({"op": "auth", "token": "abc"}, True),
        ({"op": "auth", "token": "ab\ud800"}, False),
        ({"op": "auth"}, False),
    ],
)
def test_an_auth_message_holds_the_token_or_rosauths_mac(message: dict[str, Any], is_good: bool) -> None:
    assert authenticates("abc", message, NOW_S) is is_good
