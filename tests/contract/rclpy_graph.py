"""Graphs over rclpy."""

from __future__ import annotations

import importlib.util
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from ros2_domains import own_domain
from rostether.graph.ports import JoinGraph
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.rclpy.context import RclpyContext
from rostether.ros2.types.type_support import Ros2Types


@asynccontextmanager
async def open_rclpy() -> AsyncIterator[JoinGraph]:
    """Open a context on a domain that no other process uses."""
    if importlib.util.find_spec("rclpy") is None:
        pytest.skip("rclpy is not installed")
    context = await RclpyContext.open(Ros2Types(Registry(), Ros2Definitions()), domain_id=own_domain())
    try:
        yield context.join
    finally:
        await context.close()
