from __future__ import annotations

import hashlib
import socket
from typing import Any

import pytest

from rostether.gateways.rosbridge.admission import Admission
from rostether.gateways.rosbridge.settings import RosbridgeSettings

NOW_S = 1_700_000_000.0


@pytest.mark.parametrize(
    ("origin", "host", "is_let_in"),
    [
        (None, "localhost:9090", True),
        (None, "192.168.1.7:9090", True),
        (None, "evil.example:9090", False),
        ("http://localhost:8000", "127.0.0.1:9090", True),
        ("http://127.0.0.1", "localhost:9090", True),
        ("https://[::1]:8443", "localhost:9090", True),
        ("http://192.168.1.7", "192.168.1.7:9090", True),
        (f"http://{socket.gethostname()}:8000", f"{socket.gethostname()}:9090", True),
        ("http://evil.example", "localhost:9090", False),
        ("http://evil.example", "evil.example:9090", False),
        ("http://192.168.1.8", "192.168.1.7:9090", False),
        ("http://localhost.evil.example", "localhost:9090", False),
        ("http://evil.example/localhost", "localhost:9090", False),
        ("null", "localhost:9090", False),
        ("file://", "localhost:9090", False),
        ("", "localhost:9090", False),
        ("http://[", "localhost:9090", False),
        ("http://localhost", "", False),
    ],
)
def test_pages_of_this_machine_alone_may_connect(origin: str | None, host: str, is_let_in: bool) -> None:
    assert Admission(RosbridgeSettings()).allows_origin(origin, host) is is_let_in


def test_origins_that_were_named_may_connect() -> None:
    admission = Admission(RosbridgeSettings(origins=("https://panel.example", "null")))
    assert admission.allows_origin("https://panel.example", "robot:9090")
    assert admission.allows_origin("null", "robot:9090")
    assert not admission.allows_origin("http://panel.example", "robot:9090")
    assert Admission(RosbridgeSettings(origins=("*",))).allows_origin("http://a.b", "robot:9090")


@pytest.mark.parametrize(
    ("path", "authorization", "is_known"),
    [
        ("/?token=abc", "", True),
        ("/?a=1&token=abc", "", True),
        ("/", "Bearer abc", True),
        ("/", "bearer  abc ", True),
        ("/?token=abcd", "", False),
        ("/?token=", "", False),
        ("/", "Basic abc", False),
        ("/", "", False),
        ("/?token=%ff", "", False),
        ("//[?token=abc", "", True),
        ("/?token=abc", "Bearer wrong", False),
        ("/?token=wrong&token=abc", "", False),
    ],
)
def test_the_token_is_in_the_query_or_a_header(path: str, authorization: str, is_known: bool) -> None:
    admission = Admission(RosbridgeSettings(token="abc"))
    assert admission.wants_token
    assert admission.knows_token(path, authorization) is is_known


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
    assert Admission(RosbridgeSettings(token="abc")).authenticates(message, NOW_S) is is_good


def test_a_path_that_was_named_is_the_only_one() -> None:
    assert Admission(RosbridgeSettings()).allows_path("/anything?token=1")
    admission = Admission(RosbridgeSettings(path="/ros"))
    assert admission.allows_path("/ros?token=1")
    assert admission.allows_path("/ros/")
    assert not admission.allows_path("/")
