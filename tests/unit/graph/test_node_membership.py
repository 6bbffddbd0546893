from __future__ import annotations

import asyncio

import pytest

from rostether.errors import GraphError
from rostether.graph.node_membership import NodeMembership


class _Node(NodeMembership):
    def __init__(self) -> None:
        super().__init__("/robot/board", "/robot", {"chatter": "/talk"})
        self.ends = 0
        self.may_end = asyncio.Event()

    async def _end(self) -> None:
        self.ends += 1
        await self.may_end.wait()
        raise GraphError("the master hangs")

    def use(self) -> None:
        self._check_open()


async def test_names_resolve_against_namespace_node_and_remappings() -> None:
    node = _Node()
    assert [node.resolve(name) for name in ("odom", "~rate", "/tf", "chatter")] == [
        "/robot/odom",
        "/robot/board/rate",
        "/tf",
        "/talk",
    ]


async def test_a_node_ends_once_with_the_first_reason_even_if_its_end_fails() -> None:
    node = _Node()
    node.use()
    closing = [asyncio.ensure_future(node.close(reason)) for reason in ("replaced", "closed")]
    waiting = asyncio.ensure_future(node.wait_closed())
    await asyncio.sleep(0)
    with pytest.raises(GraphError, match="node /robot/board has left the graph; join again"):
        node.use()
    assert not waiting.done()

    node.may_end.set()
    assert await waiting == "replaced"
    for each in closing:
        with pytest.raises(GraphError, match="the master hangs"):
            await each
    assert node.ends == 1
