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
        "file://",
        "foxglove://app",
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
