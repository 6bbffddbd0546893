"""The implementations of the graph port: how to open an empty graph of each, and its capabilities."""

from __future__ import annotations

import functools
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import replace
from typing import NamedTuple

from contract.broken_graph import HalfBrokenNetwork
from contract.capabilities import MEMORY, ROS1, ROS2, Capabilities
from contract.owned_parameters import OwnedParametersNetwork
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import JoinGraph
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.node import join_ros1


class Implementation(NamedTuple):
    """One implementation; `open` returns a `JoinGraph` for an empty graph."""

    capabilities: Capabilities
    open: Callable[[], AbstractAsyncContextManager[JoinGraph]]


@asynccontextmanager
async def _open_memory() -> AsyncIterator[JoinGraph]:
    yield MemoryNetwork().join


@asynccontextmanager
async def _open_memory_with_owned_parameters() -> AsyncIterator[JoinGraph]:
    yield OwnedParametersNetwork().join


@asynccontextmanager
async def _open_joint() -> AsyncIterator[JoinGraph]:
    yield HalfBrokenNetwork().join


@asynccontextmanager
async def _open_ros1() -> AsyncIterator[JoinGraph]:
    master = await MasterServer.start(port=0)
    yield functools.partial(join_ros1, environment=RosEnvironment.read({}).with_master(master.uri))
    await master.close()


@asynccontextmanager
async def _open_zenoh() -> AsyncIterator[JoinGraph]:
    from contract.zenoh_graphs import open_one_session

    async with open_one_session() as join:
        yield join


@asynccontextmanager
async def _open_zenoh_across() -> AsyncIterator[JoinGraph]:
    from contract.zenoh_graphs import open_sessions

    async with open_sessions() as join:
        yield join


@asynccontextmanager
async def _open_rclpy() -> AsyncIterator[JoinGraph]:
    from contract.rclpy_graph import open_rclpy

    async with open_rclpy() as join:
        yield join


IMPLEMENTATIONS: dict[str, Implementation] = {
    "memory": Implementation(MEMORY, _open_memory),
    "memory-owned-parameters": Implementation(
        replace(MEMORY, global_parameters=False, mixed_lists=False), _open_memory_with_owned_parameters
    ),
    "joint, one graph broken": Implementation(MEMORY, _open_joint),
    "ros1": Implementation(ROS1, _open_ros1),
    "zenoh": Implementation(ROS2, _open_zenoh),
    "zenoh-across": Implementation(ROS2, _open_zenoh_across),
    "rclpy": Implementation(
        replace(ROS2, sends_service_errors=False, allows_different_types=False), _open_rclpy
    ),
}
