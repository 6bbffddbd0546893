from __future__ import annotations

import pytest

from rostether.gateways.foxglove.admission import Admission


@pytest.mark.parametrize(
    "origin",
    [
        "",
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
def test_viewers_may_connect(origin: str) -> None:
    assert Admission().refusal("/", {"Origin": origin, "Host": "10.0.0.7:8765"}) is None


@pytest.mark.parametrize(
    "origin",
    [
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
    refusal = Admission().refusal("/", {"Origin": origin, "Host": "rebound.example:8765"})
    assert refusal is not None
    assert f"--origin {origin}" in refusal


def test_the_user_may_allow_pages() -> None:
    headers = {"Origin": "https://panel.example"}
    assert Admission(origins=["https://panel.example/"]).refusal("/", headers) is None
    assert Admission(origins=["*"]).refusal("/", {"Origin": "null"}) is None
    assert Admission(origins=["https://other.example"]).refusal("/", headers) is not None


def test_the_token_is_asked_for() -> None:
    admission = Admission(token="s3cret")
    assert admission.refusal("/?token=s3cret", {}) is None
    assert admission.refusal("/", {"Authorization": "Bearer s3cret"}) is None
    for path, headers in (
        ("/", {}),
        ("/?token=wrong", {}),
        ("/?token=", {}),
        ("/", {"Authorization": "Basic s3cret"}),
        ("/?token=\xff", {}),
    ):
        refusal = admission.refusal(path, headers)
        assert refusal is not None
        assert "s3cret" not in refusal
