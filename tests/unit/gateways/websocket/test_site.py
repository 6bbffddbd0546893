from __future__ import annotations

import gzip
from http import HTTPStatus

import pytest
from websockets.datastructures import Headers
from websockets.http11 import Response

from rostether.gateways.websocket.site import POLICY, Site

SCRIPT = b"console.log('robot');\n" * 200


@pytest.fixture
def site() -> Site:
    return Site({"index.html": b"<!doctype html>", "app.js": SCRIPT, "img/robot.svg": b"<svg/>"})


def asked(site: Site, path: str, *, method: str = "GET", **headers: str) -> Response:
    return site.reply(method, path, Headers({name.replace("_", "-"): text for name, text in headers.items()}))


def header(reply: Response, name: str) -> str | None:
    return reply.headers.get(name)


@pytest.mark.parametrize(
    ("path", "content", "content_type"),
    [
        ("/", b"<!doctype html>", "text/html; charset=utf-8"),
        ("/index.html", b"<!doctype html>", "text/html; charset=utf-8"),
        ("/app.js", SCRIPT, "text/javascript; charset=utf-8"),
        ("/app.js?v=1", SCRIPT, "text/javascript; charset=utf-8"),
        ("/img/robot.svg", b"<svg/>", "image/svg+xml"),
    ],
)
def test_files_are_served_by_their_names(site: Site, path: str, content: bytes, content_type: str) -> None:
    reply = asked(site, path)
    assert (reply.status_code, reply.body) == (HTTPStatus.OK, content)
    assert header(reply, "Content-Length") == str(len(content))
    assert header(reply, "Content-Type") == content_type
    assert header(reply, "Content-Security-Policy") == POLICY
    assert header(reply, "X-Content-Type-Options") == "nosniff"
    assert header(reply, "Referrer-Policy") == "no-referrer"
    assert header(reply, "Cache-Control") == "no-cache"


@pytest.mark.parametrize("accepted", ["gzip", "deflate, GZIP;q=0.5", "*"])
def test_a_browser_gets_it_compressed(site: Site, accepted: str) -> None:
    reply = asked(site, "/app.js", Accept_Encoding=accepted)
    assert header(reply, "Content-Encoding") == "gzip"
    assert header(reply, "Vary") == "Accept-Encoding"
    assert len(reply.body) < len(SCRIPT) / 10
    assert gzip.decompress(reply.body) == SCRIPT


@pytest.mark.parametrize("accepted", ["", "br", "gzip;q=0", "gzip; q=0.0"])
def test_others_get_it_as_it_is(site: Site, accepted: str) -> None:
    assert asked(site, "/app.js", Accept_Encoding=accepted).body == SCRIPT


def test_a_file_that_does_not_shrink_is_not_compressed(site: Site) -> None:
    assert asked(site, "/img/robot.svg", Accept_Encoding="gzip").body == b"<svg/>"


@pytest.mark.parametrize("accepted", ["", "gzip"])
def test_what_a_browser_has_is_not_sent_again(site: Site, accepted: str) -> None:
    tag = header(asked(site, "/app.js", Accept_Encoding=accepted), "ETag")
    assert tag is not None
    for sent in (tag, f'"other", W/{tag}', "*"):
        reply = asked(site, "/app.js", Accept_Encoding=accepted, If_None_Match=sent)
        assert (reply.status_code, reply.body) == (HTTPStatus.NOT_MODIFIED, b"")
        assert header(reply, "ETag") == tag
    assert (
        asked(site, "/app.js", Accept_Encoding=accepted, If_None_Match='"other"').status_code == HTTPStatus.OK
    )


def test_each_content_has_its_own_tag() -> None:
    first, second = (asked(Site({"index.html": text}), "/") for text in (b"one", b"two"))
    assert header(first, "ETag") != header(second, "ETag")


def test_head_has_no_body(site: Site) -> None:
    reply = asked(site, "/app.js", method="HEAD")
    assert (reply.status_code, reply.body) == (HTTPStatus.OK, b"")
    assert header(reply, "Content-Length") == str(len(SCRIPT))
    assert asked(site, "/none", method="HEAD").body == b""


@pytest.mark.parametrize(
    "path",
    [
        "/none.js",
        "",
        "//",
        "/../index.html",
        "/img/../app.js",
        "/%2e%2e/app.js",
        "/etc/passwd",
        "http://x/app.js",
    ],
)
def test_what_is_not_in_the_table_is_not_found(site: Site, path: str) -> None:
    reply = asked(site, path)
    assert (reply.status_code, reply.body) == (HTTPStatus.NOT_FOUND, b"no such file; the page is at /\n")


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "get"])
def test_other_methods_are_not_allowed(site: Site, method: str) -> None:
    reply = asked(site, "/", method=method)
    assert reply.status_code == HTTPStatus.METHOD_NOT_ALLOWED
    assert header(reply, "Allow") == "GET, HEAD"
