"""Which network addresses may connect to a listener, and the log of refused ones."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from rostether.errors import ConfigError
from rostether.mechanisms.rate_limits import RepeatLimiter

if TYPE_CHECKING:
    from ipaddress import IPv4Network, IPv6Network

_LOG = logging.getLogger(__name__)

# This machine's own programs: an attacker who can run one here needs no network.
ALWAYS_ALLOWED = ("127.0.0.0/8", "::1/128")


def check_networks(networks: Iterable[str], source: str) -> tuple[str, ...]:
    """Check that networks are valid, and return them; `source` is named in errors. Raises ConfigError."""
    from ipaddress import ip_network  # only needed by listeners with a limit

    checked = tuple(networks)
    for network in checked:
        try:
            ip_network(network, strict=False)
        except ValueError:
            raise ConfigError(
                f"{source}: {network!r:.200} is not a network; write for example 192.168.1.0/24 or 10.0.0.7"
            ) from None
    return checked


class AllowList:
    """A set of networks such as `192.168.1.0/24`, and this machine; an empty one allows all."""

    def __init__(self, networks: Iterable[str] = ()) -> None:
        self._networks: list[IPv4Network | IPv6Network] = []
        given = tuple(networks)
        self.is_limiting = bool(given)
        if given:
            from ipaddress import ip_network

            self._networks += (ip_network(each, strict=False) for each in (*given, *ALWAYS_ALLOWED))

    def allows(self, host: str) -> bool:
        """Return whether a numeric address may connect; an IPv4 address mapped into IPv6 counts as IPv4."""
        if not self.is_limiting:
            return True
        from ipaddress import IPv6Address, ip_address

        try:
            address = ip_address(host.partition("%")[0])
        except ValueError:
            return False
        if isinstance(address, IPv6Address) and address.ipv4_mapped is not None:
            address = address.ipv4_mapped
        return any(address in network for network in self._networks)

    def allows_connection(self, host: str, own_host: str) -> bool:
        """Return whether a connection is allowed; if both ends have one address, it is local."""
        return host == own_host or self.allows(host)


class RefusalLog:
    """Counts refused peers, and logs at most one line every ten seconds: they cannot fill the log."""

    def __init__(self, listener: str, clock: Callable[[], float]) -> None:
        self.count = 0
        self._listener = listener
        self._clock = clock
        self._lines = RepeatLimiter()

    def refuse(self, peer: str, reason: str) -> None:
        """Count a refused peer, and log it if the rate permits."""
        self.count += 1
        omitted_count = self._lines.admit("refused", self._clock())
        if omitted_count is None:
            return
        more = f" ({omitted_count} more since the last such line)" if omitted_count else ""
        _LOG.warning("%s refused %s: %s%s", self._listener, peer, reason, more)
