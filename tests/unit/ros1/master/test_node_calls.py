"""Calls from the master to nodes: order, replaced updates, retries, and nodes that have ended."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from typing import Any

import pytest

from rostether.ros1.master import node_calls as module
from rostether.ros1.master.node_calls import NodeCallQueue
from rostether.ros1.xmlrpc_server import XmlRpcServer
from waiting import until


class FakeNode:
    """A node that records the calls; `gate` delays its answers."""

    def __init__(self) -> None:
        self.received: list[tuple[Any, ...]] = []
        self.gate = asyncio.Event()
        self.gate.set()
        self.answer: list[Any] = [1, "", 0]
        self.server = XmlRpcServer(
            {name: self._method(name) for name in ("publisherUpdate", "paramUpdate", "shutdown", "getPid")}
        )

    def _method(self, name: str) -> Callable[..., Any]:
        async def method(caller: str, *args: Any) -> list[Any]:
            assert caller == "/master"
            self.received.append((name, *args))
            await self.gate.wait()
            return self.answer

        return method


@pytest.fixture
async def node() -> AsyncIterator[FakeNode]:
    node = FakeNode()
    await node.server.start()
    yield node
    node.gate.set()
    await node.server.close()


@pytest.fixture
def gone() -> list[str]:
    """Collect the URIs reported as gone."""
    return []


@pytest.fixture
async def queue(gone: list[str], monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[NodeCallQueue]:
    monkeypatch.setattr(module, "_FIRST_RETRY_S", 0.02)
    monkeypatch.setattr(module, "_CALL_TIMEOUT_S", 60.0)
    queue = NodeCallQueue(gone.append)
    yield queue
    await queue.close()


async def test_updates_arrive_in_order(node: FakeNode, queue: NodeCallQueue) -> None:
    for number in range(5):
        queue.param_update(node.server.uri, f"/{number}/", number)
    await until(lambda: len(node.received) == 5)
    assert node.received == [("paramUpdate", f"/{number}/", number) for number in range(5)]


async def test_only_the_newest_update_of_a_topic_waits(node: FakeNode, queue: NodeCallQueue) -> None:
    node.gate.clear()
    api = node.server.uri
    queue.publisher_update(api, "/t", ["http://0/"])
    await until(lambda: node.received)
    for number in range(1, 100):
        queue.publisher_update(api, "/t", [f"http://{number}/"])
        queue.param_update(api, "/p/", number)
    node.gate.set()
    await until(lambda: len(node.received) == 3)
    assert node.received[1:] == [
        ("publisherUpdate", "/t", ["http://99/"]),
        ("paramUpdate", "/p/", 99),
    ]


async def test_a_newer_update_is_sent_after_updates_in_between(node: FakeNode, queue: NodeCallQueue) -> None:
    node.gate.clear()
    api = node.server.uri
    queue.ping(api)
    await until(lambda: node.received)
    queue.param_update(api, "/a/b/", 1)
    queue.param_update(api, "/a/", {"b": 2})
    queue.param_update(api, "/a/b/", 3)
    node.gate.set()
    await until(lambda: len(node.received) == 3)
    assert node.received[1:] == [("paramUpdate", "/a/", {"b": 2}), ("paramUpdate", "/a/b/", 3)]


async def test_an_update_during_its_call_is_not_lost(node: FakeNode, queue: NodeCallQueue) -> None:
    node.gate.clear()
    queue.param_update(node.server.uri, "/p/", 1)
    await until(lambda: node.received)
    queue.param_update(node.server.uri, "/p/", 2)
    node.gate.set()
    await until(lambda: len(node.received) == 2)
    assert node.received[1] == ("paramUpdate", "/p/", 2)


async def test_a_hanging_node_does_not_delay_others_and_is_informed_later(
    node: FakeNode, gone: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_FIRST_RETRY_S", 0.02)
    monkeypatch.setattr(module, "_CALL_TIMEOUT_S", 0.5)
    queue = NodeCallQueue(gone.append)
    other = FakeNode()
    await other.server.start()
    node.gate.clear()
    queue.publisher_update(node.server.uri, "/t", [])
    await until(lambda: node.received)
    queue.publisher_update(other.server.uri, "/t", [])
    await until(lambda: other.received)
    assert queue._outboxes[node.server.uri].pending
    # Its call times out and is repeated until it answers.
    await until(lambda: len(node.received) == 2)
    node.gate.set()
    await until(lambda: not queue._outboxes[node.server.uri].pending)
    assert gone == []
    await queue.close()
    await other.server.close()


async def test_a_refused_connection_twice_is_a_node_that_has_ended(
    node: FakeNode, queue: NodeCallQueue, gone: list[str]
) -> None:
    await node.server.close()
    queue.publisher_update(node.server.uri, "/t", [])
    await until(lambda: gone)
    assert gone == [node.server.uri]
    assert queue._outboxes == {}


async def test_one_refusal_is_a_restart(
    node: FakeNode, gone: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_FIRST_RETRY_S", 2.0)
    queue = NodeCallQueue(gone.append)
    await node.server.close()
    queue.publisher_update(node.server.uri, "/t", [])
    await until(lambda: queue._outboxes[node.server.uri].refusals == 1)
    await node.server.start()
    await until(lambda: node.received)
    await queue.close()
    assert gone == []


async def test_the_end_of_a_node_is_detected_by_the_kept_connection(
    node: FakeNode, queue: NodeCallQueue, gone: list[str]
) -> None:
    queue.ping(node.server.uri)
    await until(lambda: not queue._outboxes[node.server.uri].pending)
    await node.server.close()
    await until(lambda: gone)
    assert gone == [node.server.uri]


async def test_a_node_that_closes_idle_connections_is_not_gone(
    node: FakeNode, queue: NodeCallQueue, gone: list[str]
) -> None:
    queue.ping(node.server.uri)
    await until(lambda: not queue._outboxes[node.server.uri].pending)
    for connection in list(node.server._connections):
        connection.abort()
    await until(lambda: len(node.received) == 2)
    assert gone == []


async def test_a_shutdown_replaces_everything_else(node: FakeNode, queue: NodeCallQueue) -> None:
    node.gate.clear()
    api = node.server.uri
    queue.ping(api)
    await until(lambda: node.received)
    queue.publisher_update(api, "/t", [])
    queue.shut_down(api, "why")
    node.gate.set()
    await until(lambda: len(node.received) == 2)
    assert node.received[1] == ("shutdown", "why")


async def test_a_shutdown_of_a_dead_node_is_not_repeated(
    node: FakeNode, queue: NodeCallQueue, gone: list[str]
) -> None:
    await node.server.close()
    queue.shut_down(node.server.uri, "why")
    await until(lambda: queue._outboxes[node.server.uri].task is None)
    assert gone == []


async def test_the_answer_of_a_node_is_ignored(node: FakeNode, queue: NodeCallQueue) -> None:
    node.answer = [-1, "not subscribed", 0]
    for number in (1, 2):
        queue.param_update(node.server.uri, "/p/", number)
        await until(lambda number=number: len(node.received) == number)  # type: ignore[misc]
    assert queue._outboxes[node.server.uri].refusals == 0


async def test_a_fault_is_not_repeated(queue: NodeCallQueue, gone: list[str]) -> None:
    server = XmlRpcServer({})
    await server.start()
    queue.publisher_update(server.uri, "/t", [])
    await until(lambda: queue._outboxes[server.uri].task is None)
    assert queue._outboxes[server.uri].pending == {}
    assert gone == []
    await server.close()


async def test_the_updates_that_wait_for_a_node_are_limited(
    node: FakeNode, queue: NodeCallQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_MAX_PENDING", 3)
    node.gate.clear()
    for number in range(10):
        queue.param_update(node.server.uri, f"/{number}/", number)
    assert [key for _, key in queue._outboxes[node.server.uri].pending] == ["/7/", "/8/", "/9/"]


async def test_few_connections_are_kept(
    node: FakeNode, queue: NodeCallQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_MAX_KEPT_CONNECTIONS", 0)
    queue.ping(node.server.uri)
    await until(lambda: node.received and not node.server._connections)


async def test_unregistered_nodes_are_forgotten(node: FakeNode, queue: NodeCallQueue) -> None:
    node.gate.clear()
    queue.ping(node.server.uri)
    await until(lambda: node.received)
    queue.retain({node.server.uri})
    assert list(queue._outboxes) == [node.server.uri]
    queue.retain(set())
    assert queue._outboxes == {}
    await until(lambda: not node.server._connections)


@pytest.mark.parametrize("api", ["rosrpc://x:1", "http://", "http://x", "nonsense"])
async def test_a_uri_that_cannot_be_called_is_ignored(queue: NodeCallQueue, api: str) -> None:
    queue.publisher_update(api, "/t", [])
    assert queue._outboxes == {}


async def test_a_value_that_cannot_be_sent_is_dropped(node: FakeNode, queue: NodeCallQueue) -> None:
    queue.param_update(node.server.uri, "/big/", 2**40)
    queue.param_update(node.server.uri, "/p/", 1)
    await until(lambda: node.received)
    assert node.received == [("paramUpdate", "/p/", 1)]


async def test_close_ends_running_calls(node: FakeNode, queue: NodeCallQueue) -> None:
    node.gate.clear()
    queue.ping(node.server.uri)
    await until(lambda: node.received)
    await queue.close()
    await until(lambda: not node.server._connections)
    queue.ping(node.server.uri)
    assert queue._outboxes == {}
