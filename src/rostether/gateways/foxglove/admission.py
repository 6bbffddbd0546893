"""Who may use a gateway for Foxglove: the pages and the token of all gateways, and Foxglove's own pages."""

from __future__ import annotations

from collections.abc import Sequence

from rostether.gateways.admission import Headers, PageRule, Token, single_header

FOXGLOVE_SITE = "foxglove.dev"
"""Foxglove's own web application, app.foxglove.dev, is what the gateway is for."""


class Admission:
    """The rules; `origins` are more web pages that may connect, such as `https://robot.example`, or `*`."""

    def __init__(self, origins: Sequence[str] = (), token: str = "") -> None:
        self._pages = PageRule(origins, viewer_site=FOXGLOVE_SITE)
        self._token = Token(token)

    def refusal(self, path: str, headers: Headers) -> str | None:
        """Return why a connection is refused, None when it is not."""
        origin = single_header(headers, "Origin")
        if not self._pages.admits(origin, single_header(headers, "Host") or ""):
            return f"pages of {origin:.200} may not connect: allow them with --origin {origin:.200}"
        if self._token.is_wanted and not self._token.is_carried_by(
            path, single_header(headers, "Authorization") or ""
        ):
            return "the token is missing or wrong: connect to ws://HOST:PORT/?token=TOKEN"
        return None
