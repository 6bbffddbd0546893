"""The peers themselves work here; when this fails, look at the machine before looking at us."""

from __future__ import annotations

import pytest

from interop.ros1_peers import Ros1Peers


@pytest.mark.roscpp
async def test_roscpp_publisher_to_rostopic_echo(roscore: Ros1Peers) -> None:
    await roscore.roscpp("latch", "/chatter", "over the line")
    assert "over the line" in await roscore.run("rostopic", "echo", "-n", "1", "/chatter")
