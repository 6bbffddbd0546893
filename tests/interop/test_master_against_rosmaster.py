"""Debian's rosmaster and rostether's master give the same answers to the same random calls.

The sequences avoid intended differences: rosmaster does not notify the subscribers of a replaced node,
never forgets a node whose service another node has replaced, and does not notify the watchers below a
namespace that a plain value has replaced.
"""

from __future__ import annotations

import asyncio
import contextlib
import copy
import random
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
import pytest_asyncio

from effort import effort
from interop.ros1_peers import Ros1Peers, free_port
from rostether.errors import GraphError
from rostether.ros1.master.parameter_tree import ParameterTree
from rostether.ros1.master.server import MasterServer
from rostether.ros1.xmlrpc_client import XmlRpcClient
from rostether.ros1.xmlrpc_server import XmlRpcServer
from waiting import until

NODES = ["/a", "/b", "/ns/c", "/ns/deep/d"]
TOPICS = ["/t", "/u", "t", "~t", "ns/t", "/ns/t/", "//t"]
TYPES = ["std_msgs/String", "std_msgs/Int32", "*"]
KEYS = ["/p", "/p/q", "/p/q/r", "/p/s", "p", "q", "~x", "~x/y", "p/q", "/ns/p", "/", "/p/", "//p//q/"]
VALUES: list[Any] = [
    1, -5, 0.5, True, False, "", "text", "<&>", b"\x00\xff", [], [1, "a", [2.5]], {}, {"q": 1},
    {"q": {"r": 7, "z": []}, "s": "v"}, {"x": {"y": {"w": False}}},
]  # fmt: skip
INVALID_VALUES: list[Any] = ["", "a b", "http://x:1/", 5, [], {}, "/", True, "no_slash", "a/b/c"]


@dataclass
class FakeNode:
    """A node that answers, and stores the last updates from the master."""

    server: XmlRpcServer
    reported: list[tuple[str, str, Any]] = field(default_factory=list)

    @classmethod
    async def start(cls) -> FakeNode:
        node = cls(XmlRpcServer({}))
        node.server = XmlRpcServer(
            {
                "publisherUpdate": lambda _caller, topic, uris: node.receive("publishers", topic, uris),
                "paramUpdate": lambda _caller, key, value: node.receive("param", key, value),
                "shutdown": lambda _caller, reason: node.receive("shutdown", "", reason),
                "getPid": lambda _caller: [1, "", 1],
            }
        )
        await node.server.start()
        return node

    def receive(self, what: str, key: str, value: Any) -> list[Any]:
        self.reported.append((what, key, value))
        return [1, "", 0]


@dataclass
class Side:
    """A master with its nodes; for comparison, the URIs of nodes in answers are replaced by numbers."""

    master: XmlRpcClient
    nodes: list[FakeNode]

    async def call(self, method: str, args: list[Any]) -> Any:
        try:
            answer = await self.master.call(method, *(self._to_uri(arg) for arg in args))
        except GraphError as error:
            assert "refused" in str(error), str(error)
            return "fault"
        return self.normalized(answer)

    def _to_uri(self, arg: Any) -> Any:
        if isinstance(arg, str) and arg.startswith("uri:"):
            return self.nodes[int(arg[4:])].server.uri
        return arg

    def normalized(self, value: Any) -> Any:
        if isinstance(value, list):
            return [self.normalized(item) for item in value]
        if isinstance(value, dict):
            return {key: self.normalized(item) for key, item in value.items()}
        if isinstance(value, str):
            for index, node in enumerate(self.nodes):
                value = value.replace(node.server.uri, f"uri:{index}")
        return value

    def last_publishers(self) -> list[dict[str, Any]]:
        """Return, for each running node, the last reported publishers of each topic."""
        return [
            {topic: self.normalized(uris) for what, topic, uris in node.reported if what == "publishers"}
            for node in self.nodes[: len(NODES)]
        ]


@pytest_asyncio.fixture
async def sides(tmp_path: Path) -> AsyncIterator[tuple[Side, Side]]:
    """rostether's master and Debian's, both new."""
    async with contextlib.AsyncExitStack() as stack:
        rostether = await MasterServer.start(port=0)
        stack.push_async_callback(rostether.close)
        uri = f"http://localhost:{free_port()}/"
        peers = Ros1Peers(uri, tmp_path)
        stack.push_async_callback(peers.close)
        await peers.start("rosmaster", "--core", "-p", uri.rpartition(":")[2].strip("/"))
        both = []
        for master_uri in (rostether.uri, uri):
            nodes = [await FakeNode.start() for _ in range(len(NODES) * 2)]
            for node in nodes:
                stack.push_async_callback(node.server.close)
            client = XmlRpcClient(master_uri)
            stack.push_async_callback(client.close)
            both.append(Side(client, nodes))
        async with asyncio.timeout(60):
            while True:
                with contextlib.suppress(GraphError):
                    await both[1].master.call("getPid", "/test")
                    break
                await asyncio.sleep(0.05)
        for name in ("/run_id", "/rosdistro", "/rosversion"):
            await both[0].master.call("deleteParam", "/test", name)
        yield both[0], both[1]


class Sequence:
    """A random sequence of calls; half of the nodes' URIs are those after a restart."""

    def __init__(self, seed: int, *, replaces_nodes: bool) -> None:
        self._random = random.Random(seed)
        self._replaces_nodes = replaces_nodes

    def next(self) -> tuple[str, list[Any]]:
        choose = self._random.choice
        index = self._random.randrange(len(NODES))
        caller = NODES[index]
        is_restarted = self._replaces_nodes and self._random.random() < 0.1
        uri = f"uri:{index + len(NODES) * is_restarted}"
        # No two nodes offer the same service: see the module's docstring.
        service = f"/service{index}_{self._random.randrange(2)}"
        service_api = f"rosrpc://host:{index}"
        topic, key = choose(TOPICS), choose(KEYS)
        calls: list[tuple[str, list[Any]]] = [
            ("registerPublisher", [topic, choose(TYPES), uri]),
            ("registerPublisher", [topic, choose(TYPES), uri]),
            ("unregisterPublisher", [topic, uri]),
            ("registerSubscriber", [topic, choose(TYPES), uri]),
            ("registerSubscriber", [topic, choose(TYPES), uri]),
            ("unregisterSubscriber", [topic, uri]),
            ("registerService", [service, service_api, uri]),
            ("unregisterService", [service, choose([service_api, "rosrpc://other:1"])]),
            ("lookupService", [choose([service, "/none", "~s"])]),
            ("lookupNode", [choose([*NODES, "a", "/none", "~"])]),
            ("getPublishedTopics", [choose(["", "/", "/ns", "/ns/", "ns", "~"])]),
            ("getTopicTypes", []),
            ("getSystemState", []),
            ("setParam", [key, choose(VALUES)]),
            ("setParam", [key, choose(VALUES)]),
            ("getParam", [key]),
            ("deleteParam", [key]),
            ("hasParam", [key]),
            ("searchParam", [choose([*KEYS, "r", "x/y", "none"])]),
            ("getParamNames", []),
            ("subscribeParam", [uri, key]),
            ("unsubscribeParam", [uri, key]),
        ]
        method, args = choose(calls)
        args = [caller, *args]
        if self._random.random() < 0.08:
            self._corrupt(args)
        return method, args

    def _corrupt(self, args: list[Any]) -> None:
        position = self._random.randrange(len(args))
        if self._random.random() < 0.3:
            del args[position]
        elif self._random.random() < 0.3:
            args.append("one too many")
        elif position > 0:
            args[position] = self._random.choice(INVALID_VALUES)
        else:
            args[0] = self._random.choice([7, [], "relative", ""])


@pytest.mark.parametrize("seed", range(effort(1, thorough=3)))
async def test_the_same_calls_get_the_same_answers(sides: tuple[Side, Side], seed: int) -> None:
    rostether, debian = sides
    sequence = Sequence(seed, replaces_nodes=True)
    codes: dict[Any, int] = {}
    for step in range(1200):
        method, args = sequence.next()
        rostether_answer, debian_answer = await asyncio.gather(
            rostether.call(method, args), debian.call(method, args)
        )
        if debian_answer[0] != 1 or method == "unregisterService":
            # The texts of errors may differ.
            rostether_answer[1] = debian_answer[1]
        assert rostether_answer == debian_answer, f"step {step}: {method}{tuple(args)}"
        codes[debian_answer[0]] = codes.get(debian_answer[0], 0) + 1
    assert codes[1] > 500
    assert codes[-1] > 50


def known_value(node: FakeNode, key: str) -> Any:
    """Return a parameter's value as the node knows it from all updates, in order."""
    tree = ParameterTree()
    for what, name, value in node.reported:
        if what == "param":
            tree.set(name, copy.deepcopy(value))
    return without_empty(tree.get(key)) if tree.has(key) else {}


def without_empty(value: Any) -> Any:
    """Return a tree without empty namespaces, which are the same as unset parameters."""
    if not isinstance(value, dict):
        return value
    inner = {key: without_empty(item) for key, item in value.items()}
    return {key: item for key, item in inner.items() if item != {}}


@pytest.mark.parametrize("seed", range(3))
async def test_nodes_receive_the_current_values(sides: tuple[Side, Side], seed: int) -> None:
    rng = random.Random(seed)
    keys = ["/p", "/p/q", "/p/q/r", "/p/q/z", "/p/s"]
    watched: set[tuple[int, str]] = set()
    for _ in range(250):
        index, topic, key = rng.randrange(len(NODES)), rng.choice(TOPICS[:2]), rng.choice(keys)
        uri = f"uri:{index}"
        calls: list[tuple[str, str, list[Any]]] = [
            (NODES[index], "registerPublisher", [topic, "std_msgs/String", uri]),
            (NODES[index], "unregisterPublisher", [topic, uri]),
            (NODES[index], "registerSubscriber", [topic, "std_msgs/String", uri]),
            (NODES[index], "subscribeParam", [uri, key]),
            ("/setter", "setParam", [rng.choice(keys[2:]), rng.randrange(100)]),
            ("/setter", "setParam", ["/p", {"q": {"r": rng.randrange(100)}, "s": rng.randrange(100)}]),
            ("/setter", "setParam", ["/p/q", {"z": rng.randrange(100)}]),
            ("/setter", "deleteParam", [key]),
        ]
        caller, method, args = rng.choice(calls)
        for side in sides:
            answer = await side.call(method, [caller, *args])
            if method == "subscribeParam":
                watched.add((index, key))
                side.nodes[index].receive("param", key, answer[2])
    for side in sides:
        for index, key in watched:
            code, _, value = await side.call("getParam", ["/test", key])
            current = without_empty(value) if code == 1 else {}
            await until(
                lambda node=side.nodes[index], key=key, current=current: known_value(node, key) == current,  # type: ignore[misc]
                f"node {index} to know {key} = {current}",
            )
    rostether, debian = sides
    await until(lambda: rostether.last_publishers() == debian.last_publishers())
    assert sum(map(len, rostether.last_publishers())) > len(NODES)


async def test_a_replaced_node_is_shut_down_by_both(sides: tuple[Side, Side]) -> None:
    for side in sides:
        for uri in ("uri:0", "uri:4"):
            await side.call("registerSubscriber", ["/a", "/t", "std_msgs/String", uri])
        await until(lambda side=side: side.nodes[0].reported)  # type: ignore[misc]
        reason = "[/a] Reason: new node registered with same name"
        assert side.nodes[0].reported == [("shutdown", "", reason)]
        assert side.nodes[4].reported == []
