"""Which network addresses may connect to a listener."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ipaddress import IPv4Network, IPv6Network


class AllowList:
    """A set of networks such as `192.168.1.0/24`; an empty one allows everybody."""

    def __init__(self, networks: Iterable[str] = ()) -> None:
        self._networks: list[IPv4Network | IPv6Network] = []
        for network in networks:
            from ipaddress import ip_network  # only who limits a listener pays for the import

            self._networks.append(ip_network(network, strict=False))

    def allows(self, host: str) -> bool:
        """Tell whether a numeric address may connect; an IPv4 address mapped into IPv6 counts as IPv4."""
        if not self._networks:
            return True
        from ipaddress import IPv6Address, ip_address

        try:
            address = ip_address(host.partition("%")[0])
        except ValueError:
            return False
        if isinstance(address, IPv6Address) and address.ipv4_mapped is not None:
            address = address.ipv4_mapped
        return any(address in network for network in self._networks)
