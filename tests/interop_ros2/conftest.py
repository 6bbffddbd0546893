"""Fixtures of the interoperability tests with ROS 2."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator

import pytest
import pytest_asyncio

from interop_ros2.rclpy_peer import RclpyPeer, rclpy_peer
from ros2_domains import own_domain
from rostether.graph.ports import JoinGraph
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.rclpy.context import RclpyContext
from rostether.ros2.types.type_support import Ros2Types
from rostether.serde.store import TypeStore


@pytest.fixture(scope="session")
def store() -> TypeStore:
    """The codecs of the bundled types."""
    return TypeStore(Registry())


@pytest.fixture(scope="module")
def peer() -> Iterator[RclpyPeer]:
    """Another process with rclpy, one for all tests of a file; each test uses other names."""
    with rclpy_peer() as peer:
        yield peer


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def context(store: TypeStore) -> AsyncIterator[RclpyContext]:
    """The context of this process, one for all tests of a file, because discovery takes a second."""
    context = await RclpyContext.open(Ros2Types(store.registry, Ros2Definitions()), domain_id=own_domain())
    yield context
    await context.close()


@pytest.fixture
def join(context: RclpyContext) -> JoinGraph:
    """Join as a node until the end of the file.

    After a node has left, Fast DDS may need three seconds to announce the next endpoint.
    """
    return context.join
