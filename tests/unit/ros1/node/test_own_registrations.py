"""The master's table follows ours, in whatever order the calls arrive."""

from __future__ import annotations

import asyncio

import pytest

from rostether.ros1.master.server import MasterServer
from rostether.ros1.node import own_registrations
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.own_registrations import OwnKind, OwnRegistrations

NODE_URI, SERVICE_URI = "http://127.0.0.1:9/", "rosrpc://127.0.0.1:9"


async def nothing() -> None:
    return


@pytest.mark.parametrize("kind", OwnKind)
@pytest.mark.parametrize("adds_last", [True, False])
async def test_the_last_request_wins(kind: OwnKind, adds_last: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    # The node has no server, so the master would remove it in the middle of the test.
    monkeypatch.setattr("rostether.ros1.master.node_calls._REFUSALS_UNTIL_GONE", 10**9)
    server = await MasterServer.start(port=0)
    master = MasterClient(server.uri, "/node")
    registrations = OwnRegistrations(
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
        tables = dict(zip(OwnKind, (publishers, subscribers, services), strict=True))
        assert ("/x" in tables[kind]) is adds_last
    await registrations.close()
    assert await master.system_state() == ({}, {}, {})
    assert not registrations._locks
    await master.close()
    await server.close()


async def test_a_removal_that_was_cancelled_is_done_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.ros1.master.node_calls._REFUSALS_UNTIL_GONE", 10**9)
    server = await MasterServer.start(port=0)
    master = MasterClient(server.uri, "/node")
    registrations = OwnRegistrations(
        master,
        node_uri=NODE_URI,
        service_uri=SERVICE_URI,
        on_publishers=lambda *_: None,
        register_more=nothing,
        on_replaced=lambda _: None,
    )
    names = [f"/x{number}" for number in range(5)]
    for name in names:
        await registrations.add(OwnKind.PUBLISHER, name, "a/B")
    with monkeypatch.context() as patch:
        patch.setattr(MasterClient, "unregister_publisher", lambda *_: asyncio.sleep(60))
        removal = asyncio.ensure_future(registrations.remove(OwnKind.PUBLISHER, names[0]))
        await asyncio.sleep(0)
        removal.cancel()
        await asyncio.wait([removal])
    assert names[0] in (await master.system_state())[0]
    await registrations.close()
    assert await master.system_state() == ({}, {}, {})
    await master.close()
    await server.close()


async def test_nodes_check_the_master_at_different_times(monkeypatch: pytest.MonkeyPatch) -> None:
    server = await MasterServer.start(port=0)
    asked_s: list[float] = []
    clock = asyncio.get_running_loop().time

    async def lookup_node(_master: MasterClient, name: str) -> str:
        asked_s.append(clock())
        return NODE_URI

    monkeypatch.setattr(MasterClient, "lookup_node", lookup_node)
    nodes = []
    for number in range(20):
        master = MasterClient(server.uri, f"/board{number}")
        registrations = OwnRegistrations(
            master,
            node_uri=NODE_URI,
            service_uri=SERVICE_URI,
            on_publishers=lambda *_: None,
            register_more=nothing,
            on_replaced=lambda _: None,
        )
        nodes.append((master, registrations))
    began_s = clock()
    for _, registrations in nodes:
        registrations.start_watch(0.5)
    while len(asked_s) < 20:
        await asyncio.sleep(0.01)
    parts = {int((at_s - began_s) / 0.1) for at_s in asked_s[:20]}
    assert len(parts) >= 3, "they ask in one go"
    for master, registrations in nodes:
        await registrations.close()
        await master.close()
    await server.close()


async def test_with_many_nodes_each_checks_the_master_less_often(monkeypatch: pytest.MonkeyPatch) -> None:
    async def lookup_node(_master: MasterClient, name: str) -> str:
        return NODE_URI

    waits_s: list[float] = []
    sleep = asyncio.sleep

    async def record(wait_s: float) -> None:
        waits_s.append(wait_s)
        await sleep(0 if len(waits_s) < 100 else 60)

    monkeypatch.setattr(MasterClient, "lookup_node", lookup_node)
    monkeypatch.setattr(own_registrations, "MAX_CHECKS_HZ", 4)
    monkeypatch.setattr(asyncio, "sleep", record)
    nodes = [
        OwnRegistrations(
            MasterClient("http://127.0.0.1:9/", f"/board{number}"),
            node_uri=NODE_URI,
            service_uri=SERVICE_URI,
            on_publishers=lambda *_: None,
            register_more=nothing,
            on_replaced=lambda _: None,
        )
        for number in range(20)
    ]
    for node in nodes:
        node.start_watch(2.0)
    while len(waits_s) < 100:
        await sleep(0)
    for node in nodes:
        await node.close()
    assert max(waits_s) == 5.0
    assert sorted(waits_s)[-20:] == [5.0] * 20
