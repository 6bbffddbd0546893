"""Who may connect: which web pages, and who knows the token."""

from __future__ import annotations

import hmac
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from urllib.parse import parse_qs, urlsplit

FOXGLOVE_SITE = "foxglove.dev"
"""Foxglove's own web application, app.foxglove.dev, is what the gateway is for."""

_LOOPBACK_HOSTS = frozenset({"localhost", "127.0.0.1", "::1"})


@dataclass(frozen=True, slots=True)
class Admission:
    """The rules; `origins` are more web pages that may connect, such as `https://robot.example`, or `*`."""

    origins: Sequence[str] = ()
    token: str = ""

    def refusal(self, path: str, headers: Mapping[str, str]) -> str | None:
        """Return why a connection is refused, None when it is not.

        Programs send no Origin and may connect; browsers send that of the page. Pages of this machine, of the
        address that is connected to, and of Foxglove may, and so may desktop applications.
        """
        origin = headers.get("Origin", "")
        if origin and not self._takes(origin, headers.get("Host", "")):
            return f"pages of {origin} may not connect: allow them with --origin {origin}"
        if self.token and not hmac.compare_digest(self.token.encode(), _token(path, headers).encode()):
            return "the token is missing or wrong: connect to ws://HOST:PORT/?token=TOKEN"
        return None

    def _takes(self, origin: str, host: str) -> bool:
        if "*" in self.origins or origin.rstrip("/") in [each.rstrip("/") for each in self.origins]:
            return True
        try:
            page = urlsplit(origin)
            connected_to = urlsplit(f"//{host}").hostname
        except ValueError:
            return False
        name = page.hostname or ""
        if page.scheme not in ("http", "https"):
            # "null" is what any page may make of itself; file: and the like only a program can.
            return bool(page.scheme)
        if page.scheme == "https" and (name == FOXGLOVE_SITE or name.endswith(f".{FOXGLOVE_SITE}")):
            return True
        # A page under a name that only leads to loopback is another page, with another Host.
        return name in _LOOPBACK_HOSTS or (name == connected_to and name.replace(".", "").isdigit())


def _token(path: str, headers: Mapping[str, str]) -> str:
    scheme, _, credentials = headers.get("Authorization", "").partition(" ")
    if scheme.lower() == "bearer":
        return credentials.strip()
    return parse_qs(urlsplit(path).query).get("token", [""])[0]
