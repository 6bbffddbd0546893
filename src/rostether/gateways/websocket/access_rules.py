"""Decides which web pages and clients may connect to a gateway.

A browser lets every web page open WebSockets to this machine, even on loopback. Only the `Origin` header
identifies the page; programs send none.
"""

from __future__ import annotations

import hmac
from collections.abc import Sequence
from enum import Enum
from http import HTTPStatus
from urllib.parse import SplitResult, parse_qs, urlsplit

from msgspec import Struct, field
from websockets.datastructures import Headers

from rostether.gateways.websocket.settings import ServedProtocol, ServerSettings
from rostether.transports.own_names import OwnNames

_ANY_PAGE = "*"

_LOOPBACK_NAMES = frozenset({"localhost", "127.0.0.1", "::1"})
_WEB_SCHEMES = ("http", "https")
_BEARER = "bearer"


class PageRule(Struct, frozen=True):
    """Admits a page to the address that it came from, and pages on loopback to all names of loopback.

    `origins` are pages that the user allows, such as `https://panel.example` (`*`: all). `own_names` are the
    names of this machine. `viewer_site` is the web site of a viewer: its pages may connect, and so may a copy
    of the viewer on the user's own machine.
    """

    origins: Sequence[str] = ()
    own_names: OwnNames = field(default_factory=OwnNames)
    viewer_site: str = ""

    def admits(self, origin: str | None, host: str) -> bool:
        """Return whether a page, or a program without an `origin`, may connect to this Host."""
        if _ANY_PAGE in self.origins:
            return True
        if origin is None:
            return not host or self.own_names.include(host)
        if any(origin in (each, each.rstrip("/")) for each in self.origins):
            return True
        try:
            page = urlsplit(origin)
            server = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        if self.viewer_site and self._is_viewer(page):
            return True
        name = page.hostname or ""
        if name in _LOOPBACK_NAMES and server in _LOOPBACK_NAMES:
            return True
        # DNS rebinding: a foreign name may resolve to this machine, and is not one of its names.
        return bool(name) and name == server and self.own_names.include(name)

    def admits_host(self, host: str) -> bool:
        """Return whether pages are served for this Host: a name of this machine, or of an allowed page."""
        if not host or _ANY_PAGE in self.origins or self.own_names.include(host):
            return True
        return any(urlsplit(origin).netloc == host for origin in self.origins)

    def _is_viewer(self, page: SplitResult) -> bool:
        name = page.hostname or ""
        if page.scheme not in _WEB_SCHEMES:
            return False
        if page.scheme == "https" and (name == self.viewer_site or name.endswith(f".{self.viewer_site}")):
            return True
        return name in _LOOPBACK_NAMES


def _is_of_program(origin: str | None) -> bool:
    """Return whether an Origin is not a web page: it is missing, or has a scheme such as `file:`."""
    return origin is None or (":" in origin and not origin.startswith(("http:", "https:")))


def single_header(headers: Headers, name: str) -> str | None:
    """Return the value of a header, None if it is missing.

    The value of a repeated header is "null", which is neither the Origin of a page nor a valid token.
    """
    values = headers.get_all(name)
    if not values:
        return None
    return values[0] if len(values) == 1 else "null"


def _explain_foreign_host(host: str, remedy: str) -> str:
    return f"{host!r:.200} is not a name of this machine; use its address, set ROS_HOSTNAME, or use {remedy}"


def _given_token(path: str, headers: Headers) -> str:
    """Return the token of a request in `Authorization: Bearer`, or else in `?token=`."""
    scheme, _, credentials = (single_header(headers, "Authorization") or "").partition(" ")
    if scheme.lower() == _BEARER:
        return credentials.strip()
    return parse_qs(path.partition("?")[2]).get("token", [""])[0]


def is_same_secret(given: str, wanted: str) -> bool:
    """Return whether two texts are equal, in a time that does not depend on where they differ."""
    return hmac.compare_digest(
        given.encode("utf-8", "surrogatepass"), wanted.encode("utf-8", "surrogatepass")
    )


class Rights(Enum):
    """The rights of an admitted client."""

    FULL = "full"
    VIEW = "view"


class AccessRules:
    """The rules of one server; `own_names` are the names of this machine."""

    def __init__(self, settings: ServerSettings, protocol: ServedProtocol, own_names: OwnNames) -> None:
        self._token = settings.token
        self._view_token = settings.view_token
        self._pages = PageRule(settings.origins, own_names, protocol.viewer_site)
        self._own_pages = PageRule(settings.origins, own_names)
        self._scheme = "https" if settings.certificate else "http"
        self._path = protocol.path.strip("/")
        self._wants_token_first = protocol.wants_token_first

    def rights(self, path: str, headers: Headers) -> Rights | None:
        """Return the rights that the token in a request gives, None without a valid token.

        Every request has full rights if the server has no token.
        """
        if not self._token:
            return Rights.FULL
        given = _given_token(path, headers)
        if is_same_secret(given, self._token):
            return Rights.FULL
        return Rights.VIEW if self._view_token and is_same_secret(given, self._view_token) else None

    def refusal(self, path: str, headers: Headers) -> tuple[HTTPStatus, str] | None:
        """Return why a WebSocket is refused, None if it is admitted."""
        return self._refusal(path, headers, self._pages)

    def own_refusal(self, path: str, headers: Headers) -> tuple[HTTPStatus, str] | None:
        """Return why a WebSocket is refused, None if it is admitted.

        Unlike `refusal`, this refuses pages of the viewer's site, and clients without the full token.
        """
        if (refused := self._refusal(path, headers, self._own_pages)) is not None:
            return refused
        if self.rights(path, headers) is not Rights.FULL:
            reason = "this needs the full token, not the view token; open the page with the full token"
            return HTTPStatus.FORBIDDEN, reason
        return None

    def _refusal(self, path: str, headers: Headers, pages: PageRule) -> tuple[HTTPStatus, str] | None:
        origin, host = single_header(headers, "Origin"), single_header(headers, "Host") or ""
        rights = self.rights(path, headers)
        is_known_program = bool(self._token) and rights is not None and _is_of_program(origin)
        if not is_known_program and not pages.admits(origin, host):
            if origin is None:
                return HTTPStatus.FORBIDDEN, _explain_foreign_host(host, "--token")
            reason = f"pages of {origin:.200} may not connect; allow them with --origin {origin:.200}"
            return HTTPStatus.FORBIDDEN, reason
        if self._wants_token_first and rights is None:
            reason = "the token is missing or wrong; connect to ws://HOST:PORT/?token=TOKEN"
            return HTTPStatus.FORBIDDEN, reason
        if self._path and path.partition("?")[0].strip("/") != self._path:
            return HTTPStatus.NOT_FOUND, f"nothing is served at {path!r:.200}; connect to /{self._path}"
        return None

    def page_refusal(self, headers: Headers) -> str | None:
        """Return why a plain request for a file is refused, None if it is admitted.

        Files are not secret, so they need no token: the page sends it when it connects.
        """
        host = single_header(headers, "Host") or ""
        if self._pages.admits_host(host):
            return None
        return _explain_foreign_host(host, f"--origin {self._scheme}://{host:.200}")

    def download_refusal(self, path: str, headers: Headers) -> str | None:
        """Return why a request for a recording is refused, None if it is admitted.

        Unlike the page, recordings need the token if one is set, and pages of other sites are refused.
        """
        if (reason := self.page_refusal(headers)) is not None:
            return reason
        if single_header(headers, "Sec-Fetch-Site") in ("cross-site", "same-site"):
            return "pages of other sites may not download recordings; open this address in a new tab"
        if self.rights(path, headers) is None:
            return "the token is missing or wrong; add ?token=TOKEN to the address"
        return None
