from __future__ import annotations

import asyncio

import pytest

from rostether.errors import TransportOpenError
from rostether.transports import mdns


async def test_a_listener_is_found_by_its_service_type() -> None:
    """Over loopback, which no other machine receives."""
    zeroconf = pytest.importorskip("zeroconf")
    from zeroconf.asyncio import AsyncServiceInfo, AsyncZeroconf

    try:
        announcement = await mdns.ListenerAnnouncement.start(
            "0.0.0.0", 11411, interfaces=["127.0.0.1"], machine="lab.x"
        )
    except TransportOpenError as error:
        pytest.skip(f"no multicast here: {error}")
    browser = AsyncZeroconf(interfaces=["127.0.0.1"], ip_version=zeroconf.IPVersion.V4Only)
    try:
        assert announcement.name.startswith("rostether on lab")
        info = AsyncServiceInfo(mdns.SERVICE_TYPE, f"{announcement.name}.{mdns.SERVICE_TYPE}")
        async with asyncio.timeout(60):
            assert await info.async_request(browser.zeroconf, 8000)
        assert (info.port, info.server, info.parsed_addresses()) == (
            11411,
            "rostether-lab.local.",
            ["127.0.0.1"],
        )
    finally:
        await browser.async_close()
        await announcement.close()


@pytest.mark.parametrize(
    ("host", "reachable"),
    [("0.0.0.0", True), ("192.168.1.2", True), ("127.0.0.1", False), ("::1", False), ("localhost", False)],
)
def test_addresses_that_the_network_reaches(host: str, reachable: bool) -> None:
    assert mdns.is_reachable(host) is reachable


async def test_a_machine_without_a_network_is_reported() -> None:
    with pytest.raises(TransportOpenError, match="no network address"):
        await mdns.ListenerAnnouncement.start("127.0.0.1", 11411)
