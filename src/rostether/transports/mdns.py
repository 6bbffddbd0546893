"""Announces TCP listeners by mDNS as `_rosserial._tcp`, so that boards need no configured address.

Needs zeroconf, which is an extra: `pip install rostether[mdns]`.
"""

from __future__ import annotations

import socket
from collections.abc import Iterable, Sequence

import ifaddr
from zeroconf import IPVersion, NonUniqueNameException
from zeroconf.asyncio import AsyncServiceInfo, AsyncZeroconf

from rostether.errors import TransportOpenError
from rostether.mechanisms.loopback import is_loopback
from rostether.transports.sockets import explain_reason

SERVICE_TYPE = "_rosserial._tcp.local."
# DNS labels have at most 63 bytes, and these contain more than the name.
_MAX_MACHINE_BYTES = 48
_ANY = ("0.0.0.0", "::", "")  # noqa: S104 - only compared with


def is_reachable(host: str) -> bool:
    """Return whether boards on the network can reach a listener at this host."""
    return bool(host) and not is_loopback(host)


class ListenerAnnouncement:
    """One listener, announced until `close`; made by `start`."""

    def __init__(self, zeroconf: AsyncZeroconf, info: AsyncServiceInfo) -> None:
        self._zeroconf = zeroconf
        self._info = info

    @classmethod
    async def start(
        cls, host: str, port: int, *, interfaces: Sequence[str] | None = None, machine: str | None = None
    ) -> ListenerAnnouncement:
        """Announce a listener of `machine` on the local addresses `interfaces` (None: those of `host`).

        Raises TransportOpenError if the network does not permit it.
        """
        machine = (machine or socket.gethostname()).partition(".")[0] or "rostether"
        addresses = list(interfaces) if interfaces is not None else [*_addresses_of(host)]
        if not addresses:
            raise TransportOpenError("mDNS: this machine has no network address; connect it to a network")
        machine = machine.encode()[:_MAX_MACHINE_BYTES].decode(errors="ignore")
        info = AsyncServiceInfo(
            SERVICE_TYPE,
            f"rostether on {machine}.{SERVICE_TYPE}",
            port=port,
            parsed_addresses=addresses,
            properties={"txtvers": "1"},
            # The machine's responder (Avahi, Bonjour) already uses the machine's name, and would report a
            # conflict.
            server=f"rostether-{machine}.local.",
        )
        version = IPVersion.V4Only if all(":" not in address for address in addresses) else IPVersion.All
        zeroconf: AsyncZeroconf | None = None
        try:
            zeroconf = AsyncZeroconf(interfaces=addresses, ip_version=version)
            # A number distinguishes two bridges on one machine.
            await zeroconf.async_register_service(info, allow_name_change=True)
        except (OSError, NonUniqueNameException) as error:
            if zeroconf is not None:
                await zeroconf.async_close()
            reason = explain_reason(error) if isinstance(error, OSError) else "the name is in use"
            raise TransportOpenError(f"mDNS: cannot announce port {port}: {reason}") from error
        return cls(zeroconf, info)

    @property
    def name(self) -> str:
        """The name that other machines see: `rostether on lab-pc`."""
        return self._info.name.removesuffix(f".{SERVICE_TYPE}")

    async def close(self) -> None:
        """Withdraw the announcement."""
        await self._zeroconf.async_unregister_all_services()
        await self._zeroconf.async_close()


def _addresses_of(host: str) -> Iterable[str]:
    if host not in _ANY:
        return [host] if is_reachable(host) else []
    ips = [ip for adapter in ifaddr.get_adapters() for ip in adapter.ips if ip.is_IPv4]
    return [ip.ip for ip in ips if isinstance(ip.ip, str) and is_reachable(ip.ip)]
