"""A master at its limits: no request holds its event loop for 50 ms."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

import pytest

from effort import effort
from loop_watch import CallbackWatch
from rostether.ros1.master import registrations
from rostether.ros1.master.registrations import MAX_OF_ONE_NODE, MAX_WATCHES
from rostether.ros1.master.server import MasterServer
from rostether.ros1.xmlrpc_client import XmlRpcClient
from rostether.xmlrpc.document_reader import MAX_VALUES
from rostether.xmlrpc.values import XmlRpcValue

pytestmark = pytest.mark.slow

# A value of a struct takes more bytes than one of an array; the document is below 16 MiB.
MANY = 160_000


@pytest.fixture
async def master() -> AsyncIterator[MasterServer]:
    server = await MasterServer.start(port=0)
    yield server
    await server.close()


@pytest.fixture
async def client(master: MasterServer) -> AsyncIterator[XmlRpcClient]:
    client = XmlRpcClient(master.uri, timeout_s=60.0)
    yield client
    await client.close()


async def succeeds(client: XmlRpcClient, method: str, *args: XmlRpcValue) -> None:
    code, text, _ = await client.call_status(method, "/node", *args)
    assert code == 1, text


def filled(kind: str) -> XmlRpcValue:
    if kind == "list":
        return [1] * (MAX_VALUES - 10)
    if kind == "structs":
        return [{}] * MANY
    if kind == "namespaces":
        return {f"a{first}": {f"b{number}": {"c": 1} for number in range(100)} for first in range(600)}
    return {f"k{number}": number for number in range(MANY)}


@pytest.mark.parametrize("kind", effort(["namespaces", "flat"], ["list", "structs", "namespaces", "flat"]))
async def test_parameters_as_many_as_a_master_holds(
    kind: str, client: XmlRpcClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch = CallbackWatch(monkeypatch)
    value = filled(kind)
    for method, args in (
        ("setParam", ["/big", value]),
        ("setParam", ["/big", value]),
        ("getParam", ["/"]),
        ("getParamNames", []),
        ("deleteParam", ["/big"]),
    ):
        await succeeds(client, method, *args)
        watch.check(f"{method} of {kind}")


async def test_as_many_watchers_as_a_master_allows(
    master: MasterServer, client: XmlRpcClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    methods = master.api.dispatch()
    for number in range(MAX_WATCHES):
        name, api = f"/n{number % 25}", f"http://127.0.0.1:{number % 25 + 1}/"
        assert methods["subscribeParam"](name, api, f"/w/{number}")[0] == 1
    code, text, _ = await client.call_status("subscribeParam", "/n0", "http://127.0.0.1:1/", "/more")
    assert (code, text) == (
        -1,
        f"Error: invalid arguments: {MAX_WATCHES} parameters are watched, the limit; read them with getParam",
    )
    watch = CallbackWatch(monkeypatch)
    for method, args in (
        ("setParam", ["/w/5", 1]),
        ("setParam", ["/w", {"5": 1}]),
        ("setParam", ["/", {"w": {"5": 1}}]),
        ("deleteParam", ["/w"]),
    ):
        await succeeds(client, method, *args)
        watch.check(f"{method} {args[0]}")


async def test_a_node_with_as_many_topics_as_a_master_allows_is_replaced(
    master: MasterServer, client: XmlRpcClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    # No node is at these addresses: a master that found out would forget them.
    monkeypatch.setattr(master._node_calls, "ping", lambda _api: None)
    methods = master.api.dispatch()
    topics = [f"/t{number}" for number in range(MAX_OF_ONE_NODE)]
    for kind in ("Publisher", "Subscriber"):
        for topic in topics:
            methods[f"register{kind}"](f"/{kind}", topic, "std_msgs/Empty", f"http://127.0.0.1:{len(kind)}/")
    reported: dict[str, list[str]] = {}
    monkeypatch.setattr(
        master._node_calls, "publisher_update", lambda _api, topic, apis: reported.setdefault(topic, apis)
    )
    watch = CallbackWatch(monkeypatch)
    code, text, _ = await client.call_status(
        "registerPublisher", "/Publisher", "/t0", "std_msgs/Empty", "http://127.0.0.1:3/"
    )
    assert code == 1, text
    async with asyncio.timeout(150):
        while len(reported) < len(topics):
            await asyncio.sleep(0)
    watch.check("the new registration")
    assert reported["/t0"] == ["http://127.0.0.1:3/"]
    assert reported["/t1"] == []


async def test_one_node_has_a_limit(
    master: MasterServer, client: XmlRpcClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(registrations, "MAX_OF_ONE_NODE", 2)
    methods = master.api.dispatch()
    answers = [
        methods["registerPublisher"]("/n", f"/t{number}", "std_msgs/Empty", "http://127.0.0.1:1/")
        for number in range(3)
    ]
    assert [answer[0] for answer in answers] == [1, 1, -1]
    assert "/n has 2 registrations, the limit" in answers[2][1]


async def test_the_nodes_have_a_limit_and_are_pinged_in_slices(
    master: MasterServer, client: XmlRpcClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    methods = master.api.dispatch()
    pinged: list[str] = []
    monkeypatch.setattr(master._node_calls, "ping", pinged.append)
    codes = [
        methods["registerPublisher"](
            f"/n{number}", f"/t{number}", "std_msgs/Empty", f"http://127.0.0.1:{number + 1}/"
        )[0]
        for number in range(registrations.MAX_NODES + 1)
    ]
    assert codes == [1] * registrations.MAX_NODES + [-1]
    pinged.clear()
    watch = CallbackWatch(monkeypatch)
    master._ping_all()
    async with asyncio.timeout(60):
        while len(pinged) < registrations.MAX_NODES:
            await asyncio.sleep(0)
    watch.check("pinging")
    for method, args in (("getSystemState", []), ("getPublishedTopics", [""]), ("getTopicTypes", [])):
        await succeeds(client, method, *args)
        watch.check(method)
