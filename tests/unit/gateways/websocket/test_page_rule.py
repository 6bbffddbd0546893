from __future__ import annotations

import pytest
from websockets.datastructures import Headers

from rostether.gateways.websocket.access_rules import PageRule, single_header
from rostether.transports.own_names import OwnNames

REBOUND = "stranger.example"
"""A name whose owner lets it lead to this machine once the page is there."""


@pytest.mark.parametrize("viewer_site", ["", "viewer.example"])
@pytest.mark.parametrize(
    ("origin", "host", "is_admitted"),
    [
        (None, "robot:1", True),
        ("http://localhost:3000", "127.0.0.1:1", True),
        ("http://10.0.0.7", "10.0.0.7:1", True),
        ("http://[fd00::7]", "[fd00::7]:1", True),
        ("http://robot", "robot:1", True),
        (f"http://{REBOUND}", f"{REBOUND}:1", False),
        ("http://10.0.0.8", "10.0.0.7:1", False),
        ("http://robot", "10.0.0.7:1", False),
        ("null", "localhost:1", False),
        ("", "localhost:1", False),
        ("http://", ":1", False),
        ("http://[", "localhost:1", False),
        ("http://10.0.0.7", "[", False),
    ],
)
def test_pages_whose_address_is_ours_may_connect(
    origin: str | None, host: str, viewer_site: str, is_admitted: bool
) -> None:
    assert PageRule((), OwnNames(("robot",)), viewer_site).admits(origin, host) is is_admitted


@pytest.mark.parametrize(
    "origin",
    ["https://viewer.example", "https://app.viewer.example", "http://localhost:3000"],
)
def test_a_viewer_may_connect_where_a_gateway_is_made_for_it(origin: str) -> None:
    assert PageRule(viewer_site="viewer.example").admits(origin, "robot:1")
    assert not PageRule().admits(origin, "robot:1")


@pytest.mark.parametrize("origin", ["file://", "chrome-extension://abcdef", "viewer://app", "data:x"])
def test_what_is_not_a_web_page_must_be_named(origin: str) -> None:
    assert not PageRule(viewer_site="viewer.example").admits(origin, "localhost:1")
    assert PageRule((origin,)).admits(origin, "localhost:1")


def test_a_program_asks_for_a_name_of_this_machine() -> None:
    rule = PageRule(own_names=OwnNames(("robot",)))
    for host in ("", "robot:1", "localhost:1", "10.0.0.7:1", "[::1]:1"):
        assert rule.admits(None, host)
    assert not rule.admits(None, REBOUND)
    assert PageRule(("*",)).admits(None, REBOUND)


def test_pages_that_were_named_may_connect() -> None:
    rule = PageRule(("https://panel.example/", "null"))
    assert rule.admits("https://panel.example", "robot:1")
    assert rule.admits("null", "robot:1")
    assert not rule.admits("http://panel.example", "robot:1")
    assert PageRule(("*",)).admits("http://a.b", "robot:1")


def test_a_header_that_is_there_twice_is_nothing_that_is_known() -> None:
    headers = Headers([("Origin", "http://localhost"), ("Origin", "http://a.b"), ("Host", "robot")])
    assert single_header(headers, "Origin") == "null"
    assert single_header(headers, "Host") == "robot"
    assert single_header(headers, "Authorization") is None
