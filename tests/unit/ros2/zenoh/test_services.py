"""Services with peers of other programs, and calls that fail."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator, Callable

import pytest
import pytest_asyncio
import zenoh

from contract.graphs import SET_BOOL, string
from contract.zenoh_graphs import open_router, open_session, ros2_types
from rostether.errors import (
    SerializationError,
    ServiceCallError,
    ServiceTimeoutError,
    ServiceUnavailableError,
    TypeMismatchError,
)
from rostether.ros2.zenoh import service_server
from rostether.ros2.zenoh.attachment import Attachment, parse_attachment
from rostether.ros2.zenoh.session import ZenohSession
from rostether.ros2.zenoh.tokens import data_key
from waiting import until

SUPPORT = ros2_types().service(SET_BOOL)
KEY = data_key(0, "/switch", "std_srvs::srv::dds_::SetBool_", SUPPORT.type_hash)
TRIGGER = ros2_types().registry.service_type("std_srvs/Trigger")
REQUEST = SUPPORT.request.to_cdr(b"\x01")
GID = bytes(range(16))


@pytest_asyncio.fixture
async def session() -> AsyncIterator[ZenohSession]:
    session, _ = await open_router()
    yield session
    await session.close()


async def agree(request: bytes) -> bytes:
    return request + string("agreed")


async def ask(session: ZenohSession, payload: bytes | None, attachment: bytes | None) -> list[zenoh.Reply]:
    """Call like a peer that follows no convention."""
    return await asyncio.to_thread(
        lambda: list(session.zenoh.get(KEY, payload=payload, attachment=attachment, timeout=60.0))
    )


async def test_a_reply_repeats_sequence_and_gid(session: ZenohSession) -> None:
    node = await session.join("server")
    await node.advertise_service("/switch", SET_BOOL, agree)
    (reply,) = await ask(session, REQUEST, Attachment(77, 5, GID).encode())
    assert reply.ok is not None
    assert reply.ok.attachment is not None
    attachment = parse_attachment(reply.ok.attachment.to_bytes())
    assert attachment is not None
    assert (attachment.sequence, attachment.gid) == (77, GID)
    assert attachment.stamp_ns > 1_600_000_000_000_000_000
    assert SUPPORT.response.from_cdr(reply.ok.payload.to_bytes()) == b"\x01" + string("agreed")


async def test_invalid_calls_are_refused(session: ZenohSession) -> None:
    node = await session.join("server")
    await node.advertise_service("/switch", SET_BOOL, agree)
    good = Attachment(1, 5, GID).encode()
    for payload, attachment in (
        (REQUEST, None),
        (REQUEST, b"short"),
        (None, good),
        (b"", good),
        (b"x", good),
    ):
        (reply,) = await ask(session, payload, attachment)
        assert reply.ok is None
    (reply,) = await ask(session, REQUEST, good)
    assert reply.ok is not None


async def test_a_call_fails_when_its_server_ends(session: ZenohSession) -> None:
    server, client = await session.join("server"), await session.join("client")
    called = asyncio.Event()

    async def hang(_: bytes) -> bytes:
        called.set()
        await asyncio.Event().wait()
        raise AssertionError

    handle = await server.advertise_service("/switch", SET_BOOL, hang)
    call = asyncio.ensure_future(client.call_service("/switch", SET_BOOL, b"\x01"))
    await called.wait()
    await handle.close()
    with pytest.raises(ServiceCallError, match="/switch was shut down during the call"):
        await asyncio.wait_for(call, 60)


async def test_a_call_fails_when_the_machine_of_its_server_has_ended(session: ZenohSession) -> None:
    near, port = await open_router()
    far = await open_session(port, is_router=False)
    server, client = await far.join("server"), await near.join("client")
    called = asyncio.Event()

    async def hang(_: bytes) -> bytes:
        called.set()
        await asyncio.Event().wait()
        raise AssertionError

    await server.advertise_service("/switch", SET_BOOL, hang)
    call = asyncio.ensure_future(client.call_service("/switch", SET_BOOL, b"\x01"))
    await called.wait()
    await asyncio.to_thread(far.zenoh.close)
    with pytest.raises(ServiceCallError):
        await asyncio.wait_for(call, 60)
    await near.close()
    await far.close()


async def test_a_listed_service_without_a_route_is_reported(
    session: ZenohSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rostether.ros2.zenoh.service_client.REACH_S", 0.05)
    client = await session.join("client")
    token = (
        "@ros2_lv/0/abc/0/1/SS/%/%/ghost/%switch/std_srvs::srv::dds_::SetBool_/"
        f"{SUPPORT.type_hash}/::,10:,:,:,,"
    )
    declared = session.zenoh.liveliness().declare_token(token)
    await until(lambda: "/switch" in session.graph.snapshot().services)
    with pytest.raises(ServiceUnavailableError, match="cannot reach it"):
        await client.call_service("/switch", SET_BOOL, b"\x01")
    declared.undeclare()


async def test_wrong_types_and_requests_are_refused(session: ZenohSession) -> None:
    node = await session.join("node")
    await node.advertise_service("/switch", SET_BOOL, agree)
    with pytest.raises(TypeMismatchError, match="has type std_srvs/srv/SetBool, not std_srvs/srv/Trigger"):
        await node.call_service("/switch", TRIGGER, b"")
    with pytest.raises(SerializationError):
        await node.call_service("/switch", SET_BOOL, b"too long")


async def test_a_late_answer_is_ignored(session: ZenohSession) -> None:
    server, client = await session.join("server"), await session.join("client")
    go_on = asyncio.Event()

    async def slow(request: bytes) -> bytes:
        await go_on.wait()
        return request + string("late")

    await server.advertise_service("/switch", SET_BOOL, slow)
    calls = [client.call_service("/switch", SET_BOOL, b"\x01", timeout_s=0.05) for _ in range(20)]
    for result in await asyncio.gather(*calls, return_exceptions=True):
        assert isinstance(result, ServiceTimeoutError)
    go_on.set()
    assert await client.call_service("/switch", SET_BOOL, b"\x00", timeout_s=60) == b"\x00" + string("late")


async def test_clients_are_listed_and_forgotten(
    session: ZenohSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rostether.ros2.zenoh.endpoint_handles.MAX_CLIENTS", 2)
    node = await session.join("node")
    for name in ("/a", "/b", "/c", "/a"):
        if name not in session.graph.snapshot().services:
            await node.advertise_service(name, SET_BOOL, agree)
        assert await node.call_service(name, SET_BOOL, b"\x01", timeout_s=60)
    found = await session.query_tokens("@ros2_lv/0/*/*/*/SC/**", 1.0)
    assert sorted(text.split("/")[9] for text in found) == ["%a", "%c"]


async def test_a_caller_that_hangs_does_not_delay_others(
    session: ZenohSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    room = threading.Event()
    waiting = threading.Event()

    def wait_for_room(query: zenoh.Query, say: Callable[[], object]) -> None:
        waiting.set()
        assert room.wait(60)
        finish(query, say)

    finish = service_server._finish
    server, client = await session.join("server"), await session.join("client")
    handle = await server.advertise_service("/switch", SET_BOOL, agree)
    monkeypatch.setattr(service_server, "_finish", wait_for_room)
    call = asyncio.ensure_future(client.call_service("/switch", SET_BOOL, b"\x01"))
    await until(waiting.is_set)
    assert not call.done()
    room.set()
    assert await asyncio.wait_for(call, 60) == b"\x01" + string("agreed")
    await handle.close()
