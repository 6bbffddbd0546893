"""Who may use a gateway for Foxglove: the pages and the token of all gateways, and Foxglove's own pages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rostether.gateways.admission import Headers, PageRule, Token, foreign_host, is_of_program, single_header
from rostether.transports.own_names import OwnNames

FOXGLOVE_SITE = "foxglove.dev"
"""Foxglove's own web application, app.foxglove.dev, is what the gateway is for."""


class Admission:
    """The rules; `origins` are more web pages that may connect, such as `https://robot.example`, or `*`."""

    def __init__(self, origins: Sequence[str] = (), token: str = "", own_names: Iterable[str] = ()) -> None:
        self._pages = PageRule(origins, OwnNames(own_names), FOXGLOVE_SITE)
        self._token = Token(token)

    def refusal(self, path: str, headers: Headers) -> str | None:
        """Return why a connection is refused, None when it is not."""
        origin, host = single_header(headers, "Origin"), single_header(headers, "Host") or ""
        authorization = single_header(headers, "Authorization") or ""
        has_token = self._token.is_wanted and self._token.is_carried_by(path, authorization)
        if not self._pages.admits(origin, host) and not (has_token and is_of_program(origin)):
            if origin is None:
                return foreign_host(host)
            return f"pages of {origin:.200} may not connect: allow them with --origin {origin:.200}"
        if self._token.is_wanted and not has_token:
            return "the token is missing or wrong: connect to ws://HOST:PORT/?token=TOKEN"
        return None

    def page_refusal(self, headers: Headers) -> str | None:
        """Return why a plain request for a file is refused, None when it is not.

        Files are no secret, so they need no token: the page brings it when it connects.
        """
        host = single_header(headers, "Host") or ""
        return None if self._pages.admits_host(host) else foreign_host(host)
