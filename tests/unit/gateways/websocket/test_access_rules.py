from __future__ import annotations

import socket
from collections.abc import Sequence
from http import HTTPStatus

import pytest
from websockets.datastructures import Headers

from rostether.gateways.websocket.access_rules import AccessRules, Rights
from rostether.gateways.websocket.settings import ServedProtocol, ServerSettings
from rostether.transports.own_names import OwnNames


def foxglove_rules(
    origins: Sequence[str] = (), token: str = "", own_names: Sequence[str] = ()
) -> AccessRules:
    """The rules of a gateway for Foxglove."""
    settings = ServerSettings(origins=tuple(origins), token=token)
    return AccessRules(settings, ServedProtocol("foxglove", viewer_site="foxglove.dev"), OwnNames(own_names))


def rosbridge_rules(token: str = "", *, path: str = "", wants_token_first: bool = True) -> AccessRules:
    """The rules of a rosbridge server."""
    protocol = ServedProtocol("rosbridge", path=path, wants_token_first=wants_token_first)
    return AccessRules(ServerSettings(token=token), protocol, OwnNames())


def reason(rules: AccessRules, path: str, headers: Headers) -> str | None:
    refused = rules.refusal(path, headers)
    return None if refused is None else refused[1]


@pytest.mark.parametrize(
    "origin",
    [
        None,
        "https://app.foxglove.dev",
        "https://foxglove.dev",
        "http://localhost:3000",
        "http://127.0.0.1:8080",
        "http://[::1]:8080",
        "http://10.0.0.7:80",
    ],
)
def test_viewers_may_connect(origin: str | None) -> None:
    headers = Headers({"Host": "10.0.0.7:8765"} | ({"Origin": origin} if origin is not None else {}))
    assert reason(foxglove_rules(), "/", headers) is None


@pytest.mark.parametrize(
    "origin",
    [
        "",
        "https://evil.example",
        "null",
        "file://",
        "foxglove://app",
        "chrome-extension://abcdef",
        "http://app.foxglove.dev",
        "https://foxglove.dev.evil.example",
        "https://evilfoxglove.dev",
        # The name of the page's host leads here, but the page is from another server.
        "http://rebound.example:8765",
        "http://10.0.0.8",
        "http://[broken",
    ],
)
def test_other_pages_may_not(origin: str) -> None:
    refusal = reason(foxglove_rules(), "/", Headers({"Origin": origin, "Host": "rebound.example:8765"}))
    assert refusal is not None
    assert f"--origin {origin}" in refusal


def test_the_user_may_allow_pages() -> None:
    headers = Headers({"Origin": "https://panel.example"})
    assert reason(foxglove_rules(origins=["https://panel.example/"]), "/", headers) is None
    assert reason(foxglove_rules(origins=["*"]), "/", Headers({"Origin": "null"})) is None
    assert reason(foxglove_rules(origins=["https://other.example"]), "/", headers) is not None


@pytest.mark.parametrize("origin", ["file://", "chrome-extension://abcdef"])
def test_programs_and_extensions_need_the_token_or_to_be_named(origin: str) -> None:
    headers = Headers({"Origin": origin, "Host": "localhost:8765"})
    assert reason(foxglove_rules(), "/?token=", headers) is not None
    assert reason(foxglove_rules(token="s3cret"), "/", headers) is not None
    assert reason(foxglove_rules(token="s3cret"), "/?token=s3cret", headers) is None
    assert reason(foxglove_rules(origins=[origin]), "/", headers) is None


def test_a_page_needs_more_than_the_token() -> None:
    headers = Headers({"Origin": "https://evil.example", "Host": "localhost:8765"})
    assert reason(foxglove_rules(token="s3cret"), "/?token=s3cret", headers) is not None


def test_another_machines_name_is_refused() -> None:
    headers = Headers({"Host": "rebound.example:8765"})
    refusal = reason(foxglove_rules(), "/?token=", headers)
    assert refusal is not None
    assert "'rebound.example:8765' is not a name of this machine" in refusal
    assert reason(foxglove_rules(own_names=["rebound.example"]), "/", headers) is None
    assert reason(foxglove_rules(token="s3cret"), "/?token=s3cret", headers) is None


def test_the_token_is_asked_for() -> None:
    rules = rosbridge_rules("s3cret")
    assert reason(rules, "/?token=s3cret", Headers()) is None
    assert reason(rules, "/", Headers({"Authorization": "Bearer s3cret"})) is None
    refused: list[tuple[str, dict[str, str]]] = [
        ("/", {}),
        ("/?token=wrong", {}),
        ("/?token=", {}),
        ("/", {"Authorization": "Basic s3cret"}),
        ("/?token=\xff", {}),
    ]
    for path, fields in refused:
        refusal = reason(rules, path, Headers(fields))
        assert refusal is not None
        assert "s3cret" not in refusal


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
    headers = Headers({"Host": host} | ({} if origin is None else {"Origin": origin}))
    assert (rosbridge_rules().refusal("/", headers) is None) is is_let_in


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
        ("//[?token=abc", "Basic x", True),
        ("/?token=ab\ud800", "", False),
    ],
)
def test_the_token_is_in_the_query_or_a_header(path: str, authorization: str, is_known: bool) -> None:
    headers = Headers({"Authorization": authorization} if authorization else {})
    assert rosbridge_rules("abc").rights(path, headers) is (Rights.FULL if is_known else None)
    assert (rosbridge_rules("abc").refusal(path, headers) is None) is is_known
    assert rosbridge_rules("abc", wants_token_first=False).refusal(path, headers) is None


def test_a_path_that_was_named_is_the_only_one() -> None:
    assert rosbridge_rules().refusal("/anything?token=1", Headers()) is None
    rules = rosbridge_rules(path="/ros")
    assert rules.refusal("/ros?token=1", Headers()) is None
    assert rules.refusal("/ros/", Headers()) is None
    refused = rules.refusal("/", Headers())
    assert refused is not None
    assert refused[0] == HTTPStatus.NOT_FOUND
