"""Several sessions: routers that start, end and start again, and domains."""

from __future__ import annotations

import pytest

from contract.graphs import STRING, Inbox, string
from contract.zenoh_graphs import open_router, open_session, ros2_types
from interop.ros1_peers import free_port
from rostether.errors import InvalidNameError, MasterUnreachableError
from rostether.ros2.environment import Ros2Environment
from rostether.ros2.zenoh import configuration
from rostether.ros2.zenoh import session as session_module
from rostether.ros2.zenoh.session import ZenohSession
from rostether.ros2.zenoh_reach import RouterChoice, ZenohReach
from waiting import until


async def test_domains_are_separate() -> None:
    here, port = await open_router(1)
    there = await open_session(port, is_router=False, domain_id=2)
    one, other, inbox = await here.join("one"), await there.join("other"), Inbox()
    publisher = await one.advertise("/chat", STRING)
    await other.subscribe("/chat", STRING, inbox.store)
    same = Inbox()
    await one.subscribe("/chat", STRING, same.store)
    await until(lambda: publisher.subscriber_count == 1)
    publisher.publish_raw([string("x")])
    await until(lambda: same.payloads)
    assert "/one" not in (await other.snapshot()).nodes
    assert inbox.payloads == []
    await there.close()
    await here.close()


async def test_after_a_routers_restart_messages_arrive_once() -> None:
    router, port = await open_router()
    # Peers that do not listen can connect only through the router.
    left, right = await _client(port), await _client(port)
    talker, listener = await left.join("talker"), await right.join("listener")
    inbox = Inbox()
    publisher = await talker.advertise("/chat", STRING)
    subscriber = await listener.subscribe("/chat", STRING, inbox.store, on_connection=inbox.store_header)

    async def answer(request: bytes) -> bytes:
        return request

    echo = ros2_types().registry.service_type("std_srvs/Empty")
    await talker.advertise_service("/echo", echo, answer)
    await until(lambda: publisher.subscriber_count == 1 and subscriber.publisher_count == 1)
    publisher.publish_raw([string("before")])
    await until(lambda: inbox.payloads == [string("before")])

    await router.close()
    await until(lambda: publisher.subscriber_count == 0 and subscriber.publisher_count == 0)
    # Nodes may leave after their endpoints.
    await until(lambda: "/talker" not in right.graph.snapshot().nodes)
    assert "/talker" in (await talker.snapshot()).nodes
    problem = f"the zenoh router at tcp/127.0.0.1:{port} does not answer"
    await until(lambda: left.graph.snapshot().problem == problem)
    publisher.publish_raw([string("without a subscriber")])

    router = await open_session(port, is_router=True)
    await until(lambda: publisher.subscriber_count == 1 and subscriber.publisher_count == 1)
    publisher.publish_raw([string("after"), string("last")])
    await until(lambda: len(inbox.payloads) >= 3)
    assert await listener.call_service("/echo", echo, b"", timeout_s=60) == b""
    assert inbox.payloads == [string("before"), string("after"), string("last")]
    assert len(inbox.headers) == 2
    await until(lambda: left.graph.snapshot().problem == "")
    assert (await _nodes(router)) == {"/talker", "/listener"}
    for session in (left, right, router):
        await session.close()


async def test_after_a_routers_restart_latched_messages_arrive_once() -> None:
    router, port = await open_router()
    left, right = await _client(port), await _client(port)
    talker, listener = await left.join("talker"), await right.join("listener")
    inbox = Inbox()
    publisher = await talker.advertise("/map", STRING, latch=True)
    publisher.publish_raw([string("first")])
    subscriber = await listener.subscribe("/map", STRING, inbox.store)
    await until(lambda: inbox.payloads)
    for text in ("second", "third"):
        await router.close()
        await until(lambda: subscriber.publisher_count == 0)
        # Published while there is no router: the latched message is kept.
        publisher.publish_raw([string(text)])
        router = await open_session(port, is_router=True)
        await until(lambda: inbox.payloads[-1] == string(text))  # noqa: B023 - awaited at once
    await until(lambda: publisher.subscriber_count == 1)
    publisher.publish_raw([string("last")])
    await until(lambda: inbox.payloads[-1] == string("last"))
    assert inbox.payloads == [string(text) for text in ("first", "second", "third", "last")]
    for session in (left, right, router):
        await session.close()


async def test_a_session_that_starts_before_the_router_finds_it() -> None:
    port = free_port()
    early = await open_session(port, is_router=False)
    talker, inbox = await early.join("talker"), Inbox()
    publisher = await talker.advertise("/map", STRING, latch=True)
    publisher.publish_raw([string("kept")])
    router = await open_session(port, is_router=True)
    listener = await router.join("listener")
    await listener.subscribe("/map", STRING, inbox.store)
    await until(lambda: inbox.payloads)
    assert inbox.payloads == [string("kept")]
    await early.close()
    await router.close()


async def test_a_session_becomes_the_router_if_there_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    monkeypatch.setattr(configuration, "ROUTER_ENDPOINT", endpoint)
    monkeypatch.setattr(session_module, "ROUTER_ENDPOINT", endpoint)
    first = await ZenohSession.open(Ros2Environment(), ros2_types())
    second = await ZenohSession.open(Ros2Environment(), ros2_types())
    assert (first.is_router, second.is_router) == (True, False)
    node = await first.join("node")
    await until(lambda: "/node" in second.graph.snapshot().nodes)
    with pytest.raises(MasterUnreachableError, match="cannot listen"):
        await ZenohSession.open(Ros2Environment(), ros2_types(), reach=ZenohReach(RouterChoice.ALWAYS))
    await first.close()
    assert await node.wait_closed() == "the session ended"
    await second.close()


async def test_a_closed_session_accepts_no_nodes() -> None:
    session, _ = await open_router()
    with pytest.raises(InvalidNameError):
        await session.join("no-name")
    await session.close()
    await session.close()
    with pytest.raises(MasterUnreachableError, match="closed"):
        await session.join("node")


async def test_initial_parameters_are_the_nodes() -> None:
    session, _ = await open_router()
    node = await session.join("board", parameters={"gain": 2.5})
    assert await node.get_param("~gain") == 2.5
    await session.close()


async def test_a_named_router_that_does_not_answer_is_reported(caplog: pytest.LogCaptureFixture) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    # Without the default endpoint, where a router of this machine may run.
    overrides = (("listen/endpoints", "[]"), ("connect/endpoints", f'["{endpoint}"]'))
    environment = Ros2Environment(zenoh_overrides=overrides)
    reach = ZenohReach(RouterChoice.NEVER, connect=(endpoint,))
    session = await ZenohSession.open(environment, ros2_types(), reach=reach)
    await until(lambda: f"no zenoh router answers at {endpoint} yet" in caplog.text)
    await session.close()


async def test_a_router_reports_unreachable_routers(caplog: pytest.LogCaptureFixture) -> None:
    other, port = await open_router()
    silent = f"tcp/127.0.0.1:{free_port()}"
    reach = ZenohReach(
        RouterChoice.ALWAYS,
        connect=(f"tcp/127.0.0.1:{port}", silent),
        listen=(f"tcp/127.0.0.1:{free_port()}",),
    )
    session = await ZenohSession.open(Ros2Environment(), ros2_types(), reach=reach)
    assert session.is_router
    await until(lambda: f"no zenoh router answers at {silent} yet" in caplog.text)
    await session.close()
    await other.close()


async def test_a_second_router_has_another_endpoint(monkeypatch: pytest.MonkeyPatch) -> None:
    other, port = await open_router()
    monkeypatch.setattr(configuration, "ROUTER_ENDPOINT", f"tcp/127.0.0.1:{port}")
    place = f"tcp/127.0.0.1:{free_port()}"
    reach = ZenohReach(RouterChoice.ALWAYS, listen=(place,))
    session = await ZenohSession.open(Ros2Environment(), ros2_types(), reach=reach)
    assert await configuration.is_router_there(place)
    await session.close()
    await other.close()


async def _client(port: int) -> ZenohSession:
    overrides = (("mode", '"client"'), ("connect/endpoints", f'["tcp/127.0.0.1:{port}"]'))
    environment = Ros2Environment(
        zenoh_overrides=(
            *overrides,
            ("listen/endpoints", "[]"),
            ("connect/timeout_ms", "-1"),
            ("connect/retry", "{period_init_ms: 100, period_max_ms: 200, period_increase_factor: 2}"),
        )
    )
    return await ZenohSession.open(environment, ros2_types(), reach=ZenohReach(RouterChoice.NEVER))


async def _nodes(session: ZenohSession) -> set[str]:
    return set(session.graph.snapshot().nodes)
