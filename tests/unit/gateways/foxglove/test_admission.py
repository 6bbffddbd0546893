from __future__ import annotations

import pytest
from websockets.datastructures import Headers

from rostether.gateways.foxglove.admission import Admission


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
    assert Admission().refusal("/", headers) is None


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
        # Its name leads here, but the page is a stranger's.
        "http://rebound.example:8765",
        "http://10.0.0.8",
        "http://[broken",
    ],
)
def test_other_pages_may_not(origin: str) -> None:
    refusal = Admission().refusal("/", Headers({"Origin": origin, "Host": "rebound.example:8765"}))
    assert refusal is not None
    assert f"--origin {origin}" in refusal


def test_the_user_may_allow_pages() -> None:
    headers = Headers({"Origin": "https://panel.example"})
    assert Admission(origins=["https://panel.example/"]).refusal("/", headers) is None
    assert Admission(origins=["*"]).refusal("/", Headers({"Origin": "null"})) is None
    assert Admission(origins=["https://other.example"]).refusal("/", headers) is not None


@pytest.mark.parametrize("origin", ["file://", "chrome-extension://abcdef"])
def test_programs_and_extensions_need_the_token_or_to_be_named(origin: str) -> None:
    headers = Headers({"Origin": origin, "Host": "localhost:8765"})
    assert Admission().refusal("/?token=", headers) is not None
    assert Admission(token="s3cret").refusal("/", headers) is not None
    assert Admission(token="s3cret").refusal("/?token=s3cret", headers) is None
    assert Admission(origins=[origin]).refusal("/", headers) is None


def test_a_page_needs_more_than_the_token() -> None:
    headers = Headers({"Origin": "https://evil.example", "Host": "localhost:8765"})
    assert Admission(token="s3cret").refusal("/?token=s3cret", headers) is not None


def test_another_machines_name_is_refused() -> None:
    headers = Headers({"Host": "rebound.example:8765"})
    refusal = Admission().refusal("/?token=", headers)
    assert refusal is not None
    assert "'rebound.example:8765' is no name of this machine" in refusal
    assert Admission(own_names=["rebound.example"]).refusal("/", headers) is None
    assert Admission(token="s3cret").refusal("/?token=s3cret", headers) is None


def test_the_token_is_asked_for() -> None:
    admission = Admission(token="s3cret")
    assert admission.refusal("/?token=s3cret", Headers()) is None
    assert admission.refusal("/", Headers({"Authorization": "Bearer s3cret"})) is None
    refused: list[tuple[str, dict[str, str]]] = [
        ("/", {}),
        ("/?token=wrong", {}),
        ("/?token=", {}),
        ("/", {"Authorization": "Basic s3cret"}),
        ("/?token=\xff", {}),
    ]
    for path, fields in refused:
        refusal = admission.refusal(path, Headers(fields))
        assert refusal is not None
        assert "s3cret" not in refusal
