"""The master's table follows ours, in whatever order the calls arrive."""

from __future__ import annotations

import asyncio

import pytest

from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.registrations import Kind, Registrations

NODE_URI, SERVICE_URI = "http://127.0.0.1:9/", "rosrpc://127.0.0.1:9"


async def nothing() -> None:
    return


@pytest.mark.parametrize("kind", Kind)
@pytest.mark.parametrize("adds_last", [True, False])
async def test_the_last_wish_wins(kind: Kind, adds_last: bool) -> None:
    server = await MasterServer.start(port=0)
    master = MasterClient(server.uri, "/node")
    registrations = Registrations(
        master,
        node_uri=NODE_URI,
        service_uri=SERVICE_URI,
        on_publishers=lambda *_: None,
        register_more=nothing,
        on_replaced=lambda _: None,
    )
    for _ in range(20):
        wishes = [registrations.add(kind, "/x", "a/B"), registrations.remove(kind, "/x")]
        wishes += [registrations.add(kind, "/x", "a/B"), registrations.remove(kind, "/x")]
        if adds_last:
            wishes.append(registrations.add(kind, "/x", "a/B"))
        await asyncio.gather(*wishes)
        publishers, subscribers, services = await master.system_state()
        table = {Kind.PUBLISHER: publishers, Kind.SUBSCRIBER: subscribers, Kind.SERVICE: services}[kind]
        assert ("/x" in table) is adds_last
    await registrations.close()
    assert await master.system_state() == ({}, {}, {})
    assert not registrations._locks
    await master.close()
    await server.close()
