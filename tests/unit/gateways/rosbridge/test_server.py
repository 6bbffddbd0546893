from __future__ import annotations

import asyncio
import contextlib
import json
from typing import Any

import pytest
from msgspec.structs import replace
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from rostether.errors import TransportOpenError
from rostether.gateways.rosbridge.png_packing import pack_png
from rostether.gateways.rosbridge.server import RosbridgeServer
from rostether.gateways.rosbridge.settings import RosbridgeLimits, RosbridgeSettings
from rostether.graph.memory_network import MemoryNetwork
from rostether.mechanisms.rate_limits import MAX_LINES
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from unit.gateways.rosbridge.web_client import World, world
from waiting import until

STRING = "std_msgs/String"
SETTINGS = RosbridgeSettings(host="127.0.0.1", port=0)


async def test_fragments_both_ways_and_pictures_in(there: World) -> None:
    publisher = await there.graph.publisher("/chatter", STRING)
    async with there.client() as client:
        await client.say("subscribe", topic="/chatter", fragment_size=50)
        await client.settled()
        publisher.publish(data="x" * 100)
        pieces = [await client.receive("fragment")]
        while len(pieces) < pieces[0]["total"]:
            pieces.append(await client.receive("fragment"))
        whole = json.loads("".join(piece["data"] for piece in pieces))
        assert whole["msg"]["data"] == "x" * 100
        await client.say("unsubscribe", topic="/chatter")
        text = json.dumps({"op": "call_service", "service": "/settled", "id": "in pieces"})
        for number in (1, 0):
            await client.say(
                "fragment",
                id="f",
                num=number,
                total=2,
                data=text[number * 20 :][: 20 if not number else None],
            )
        assert (await client.receive("service_response"))["id"] == "in pieces"
        await client.connection.send(pack_png(text.replace("pieces", "a picture")))
        assert (await client.receive("service_response"))["id"] == "in a picture"


async def test_pages_of_other_sites_are_refused_with_a_hint(there: World) -> None:
    with pytest.raises(InvalidStatus) as caught:
        async with there.client(origin="http://evil.example"):
            pass
    assert caught.value.response.status_code == 403
    body = bytes(caught.value.response.body or b"").decode()
    assert body == (
        "pages of http://evil.example may not connect; allow them with --origin http://evil.example\n"
    )
    async with there.client(origin="http://localhost:8000") as client:
        assert await client.settled() == []


async def test_a_token_must_be_given() -> None:
    async with world(replace(SETTINGS, token="abc")) as there:
        async with there.client("/?token=abc") as client:
            assert await client.settled() == []
        async with there.client() as client:
            await client.say("auth", token="abc")
            assert await client.settled() == []
        async with there.client("/?token=wrong") as client:
            await client.say("subscribe", topic="/chatter")
            assert "this server requires a token" in (await client.receive("status"))["msg"]
            with pytest.raises(ConnectionClosed) as caught:
                await client.receive()
            assert caught.value.rcvd is not None
            assert caught.value.rcvd.code == 1008
        assert "/chatter" not in there.network.snapshot().topics


async def test_names_outside_of_the_globs_are_refused() -> None:
    settings = replace(SETTINGS, topics_glob=("/open/*",), services_glob=("/open/*",))
    async with world(settings) as there, there.client() as client:
        await client.say("subscribe", topic="/open/a", type=STRING)
        await client.say("advertise", topic="/open/a", type=STRING)
        await client.say("call_service", service="/secret", id="c")
        assert "does not let clients use" in (await client.receive("service_response"))["values"]
        refused: list[tuple[str, dict[str, Any]]] = [
            ("subscribe", {"topic": "/secret"}),
            ("advertise", {"topic": "/secret", "type": STRING}),
            ("publish", {"topic": "secret", "msg": {}}),
            ("advertise_service", {"service": "/secret", "type": "std_srvs/Trigger"}),
        ]
        for op, fields in refused:
            await client.say(op, **fields)
            status = await client.receive("status")
            assert status["level"] == "error"


async def test_clients_are_counted_and_bounded() -> None:
    async with world(replace(SETTINGS, limits=RosbridgeLimits(clients=1))) as there:
        await clients_are_counted_and_bounded(there)


async def clients_are_counted_and_bounded(there: World) -> None:
    counts = aiter(there.graph.messages("/client_count"))
    assert (await anext(counts)).data == 0
    async with there.client():
        assert (await anext(counts)).data == 1
        with pytest.raises(InvalidStatus) as caught:
            async with there.client():
                pass
        assert caught.value.response.status_code == 503
    assert (await anext(counts)).data == 0
    await counts.aclose()


async def test_the_oldest_silent_connection_makes_room() -> None:
    async with world(replace(SETTINGS, limits=RosbridgeLimits(clients=2, others=1))) as there:
        silent = [await asyncio.open_connection("127.0.0.1", there.server.port) for _ in range(4)]
        with contextlib.suppress(ConnectionError):
            assert await silent[0][0].read() == b""
        assert not any(reader.at_eof() for reader, _ in silent[1:])
        for _, writer in silent:
            writer.close()


async def test_many_clients_come_and_go_and_nothing_stays(there: World) -> None:
    async def visit(number: int) -> None:
        async with there.client() as client:
            await client.say("subscribe", topic="/chatter", type=STRING)
            await client.say("advertise", topic="/chatter", type=STRING)
            if number % 2:
                client.connection.transport.abort()

    for start in range(0, 100, 20):
        await asyncio.gather(*(visit(number) for number in range(start, start + 20)))
    await there.wait_until_all_left()
    assert "/rosbridge_websocket" not in there.network.snapshot().topics["/chatter"].subscribers


async def test_the_node_that_is_shut_down_ends_the_server(there: World) -> None:
    async with there.client() as client:
        graph = there.server._context.graph  # only the server uses the node
        await graph.close()
        await there.server.wait_ended()
        with pytest.raises(ConnectionClosed):
            await client.receive()
    assert "its node was shut down" in there.warnings[0]


async def test_a_port_that_is_taken_is_reported_with_what_to_do(there: World) -> None:
    network = MemoryNetwork()
    graph = await network.join("/second")
    second = RosbridgeServer(
        graph, TypeStore(Registry()), RosbridgeSettings(host="127.0.0.1", port=there.server.port)
    )
    with pytest.raises(
        TransportOpenError, match=r"port \d+ is already in use on 127.0.0.1; stop the program"
    ):
        await second.start()
    await second.close()
    third = RosbridgeServer(graph, TypeStore(Registry()), RosbridgeSettings(host="203.0.113.1", port=0))
    with pytest.raises(TransportOpenError, match=r"203.0.113.1 is not an address of this machine"):
        await third.start()
    await graph.close()


async def test_clients_that_connect_all_the_time_cause_few_lines(there: World) -> None:
    for _ in range(MAX_LINES):
        async with connect(there.server.uri):
            pass
    await until(lambda: not there.server._clients, "the end of the connections")
    assert len(there.log) == MAX_LINES
    assert "connected" in there.log[-1][1]


async def test_localhost_is_both_loopback_addresses() -> None:
    async with world(RosbridgeSettings(port=0)) as there:
        assert there.server.uri == f"ws://localhost:{there.server.port}"
        async with connect(there.server.uri):
            pass
        sockets = [sock for server in there.server._server._servers for sock in server.sockets]
        hosts = {sock.getsockname()[0] for sock in sockets}
        assert hosts in ({"127.0.0.1", "::1"}, {"127.0.0.1"})
