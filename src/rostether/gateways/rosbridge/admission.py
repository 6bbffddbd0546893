"""Who may use a rosbridge server: the pages and the token of all gateways, a path, and rosauth's messages."""

from __future__ import annotations

import hashlib
import os
from typing import Any

from rostether.gateways.admission import PageRule, Token, is_same_secret
from rostether.gateways.rosbridge.settings import RosbridgeSettings
from rostether.transports.own_names import OwnNames

MAX_CLOCK_OFFSET_S = 5.0
"""How old a MAC may be, as in rosauth: who has overheard one cannot use it later."""


class Admission:
    """The rules of one server."""

    def __init__(self, settings: RosbridgeSettings) -> None:
        self._pages = PageRule(
            settings.origins, OwnNames((settings.host, os.environ.get("ROS_HOSTNAME", "")))
        )
        self._token = Token(settings.token)
        self._path = settings.path.strip("/")

    def allows_origin(self, origin: str | None, host_header: str) -> bool:
        """Tell whether a page, or a program without an origin, may connect to this host."""
        return self._pages.admits(origin, host_header)

    def allows_path(self, path: str) -> bool:
        """Tell whether the path of a request is the one that is served; without one, all are."""
        return not self._path or path.partition("?")[0].strip("/") == self._path

    @property
    def wants_token(self) -> bool:
        """Whether clients must say who they are."""
        return self._token.is_wanted

    def knows_token(self, path: str, authorization: str) -> bool:
        """Tell whether a request carries the token: as `Authorization: Bearer` or as `?token=`."""
        return self._token.is_carried_by(path, authorization)

    def authenticates(self, fields: dict[str, Any], now_s: float) -> bool:
        """Tell whether an `auth` message is good: with the token itself, or rosauth's MAC made with it."""
        token = fields.get("token")
        if isinstance(token, str):
            return self._token.is_same(token)
        names = ("client", "dest", "rand", "t", "level", "end")
        mac, parts = fields.get("mac"), [fields.get(name) for name in names]
        if not isinstance(mac, str) or not all(isinstance(part, str | int | float) for part in parts):
            return False
        try:
            sent_s, end_s = float(fields["t"]), float(fields["end"])
        except (ValueError, OverflowError):
            return False
        text = self._token.secret + "".join(map(str, parts))
        expected = hashlib.sha512(text.encode("utf-8", "surrogatepass")).hexdigest()
        is_fresh = abs(now_s - sent_s) <= MAX_CLOCK_OFFSET_S and end_s > now_s
        return is_same_secret(mac.lower(), expected) and is_fresh
