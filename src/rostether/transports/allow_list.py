"""Which network addresses may connect to a listener."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from rostether.errors import ConfigError

if TYPE_CHECKING:
    from ipaddress import IPv4Network, IPv6Network


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
