"""Who may connect: by network, by the web page that a browser runs, and by a token.

Any page that a browser shows may open a WebSocket to this machine, loopback or not; only the `Origin` that
browsers send tells which page it is. Pages of this very machine may connect, and those that the user names.
"""

from __future__ import annotations

import hashlib
import hmac
import socket
from ipaddress import ip_address
from typing import Any
from urllib.parse import parse_qs, urlsplit

from rostether.gateways.rosbridge.settings import RosbridgeSettings
from rostether.transports.allow_list import AllowList

ANY_ORIGIN = "*"
_LOOPBACK_NAMES = ("localhost", "127.0.0.1", "::1")
_BEARER = "bearer "

MAX_CLOCK_OFFSET_S = 5.0
"""How old a MAC may be, as in rosauth: who has overheard one cannot use it later."""


class Admission:
    """The rules of one server."""

    def __init__(self, settings: RosbridgeSettings) -> None:
        self._settings = settings
        self._allow = AllowList(settings.allow)
        self._own_name = socket.gethostname().lower()

    def allows_host(self, host: str, own_host: str) -> bool:
        """Tell whether a machine may connect."""
        return self._allow.allows_connection(host, own_host)

    def allows_origin(self, origin: str | None, host_header: str) -> bool:
        """Tell whether a page may connect; programs that are no browsers name no origin."""
        if origin is None or ANY_ORIGIN in self._settings.origins or origin in self._settings.origins:
            return True
        page = _host_of(origin)
        server = _host_of(f"ws://{host_header}")
        if not page or not server:
            return False
        if page in _LOOPBACK_NAMES and server in _LOOPBACK_NAMES:
            return True
        # A name that somebody else's name server resolves to us must not count as ours.
        return page == server and self._is_ours(server)

    def allows_path(self, path: str) -> bool:
        """Tell whether the path of a request is the one that is served; without one, all are."""
        return not self._settings.path or urlsplit(path).path.strip("/") == self._settings.path.strip("/")

    @property
    def wants_token(self) -> bool:
        """Whether clients must say who they are."""
        return bool(self._settings.token)

    def knows_token(self, path: str, authorization: str) -> bool:
        """Tell whether a request carries the token: as `?token=` or as `Authorization: Bearer`."""
        given = parse_qs(urlsplit(path).query).get("token", [])
        if authorization.lower().startswith(_BEARER):
            given.append(authorization[len(_BEARER) :].strip())
        return any(_equal(each, self._settings.token) for each in given)

    def authenticates(self, fields: dict[str, Any], now_s: float) -> bool:
        """Tell whether an `auth` message is good: with the token itself, or rosauth's MAC made with it."""
        token = fields.get("token")
        if isinstance(token, str):
            return _equal(token, self._settings.token)
        names = ("client", "dest", "rand", "t", "level", "end")
        mac, parts = fields.get("mac"), [fields.get(name) for name in names]
        if not isinstance(mac, str) or not all(isinstance(part, str | int | float) for part in parts):
            return False
        try:
            sent_s, end_s = float(fields["t"]), float(fields["end"])
        except ValueError:
            return False
        text = self._settings.token + "".join(map(str, parts))
        expected = hashlib.sha512(text.encode("utf-8", "surrogatepass")).hexdigest()
        return _equal(mac.lower(), expected) and abs(now_s - sent_s) <= MAX_CLOCK_OFFSET_S and end_s > now_s

    def _is_ours(self, host: str) -> bool:
        if host.lower() in (self._own_name, f"{self._own_name}.local", self._settings.host):
            return True
        try:
            ip_address(host.strip("[]"))
        except ValueError:
            return False
        return True


def _host_of(url: str) -> str:
    try:
        return (urlsplit(url).hostname or "").lower()
    except ValueError:
        return ""


def _equal(given: str, wanted: str) -> bool:
    return hmac.compare_digest(
        given.encode("utf-8", "surrogatepass"), wanted.encode("utf-8", "surrogatepass")
    )
