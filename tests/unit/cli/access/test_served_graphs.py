from __future__ import annotations

import asyncio

import pytest

from interop import ros1_peers
from rostether.cli.access.served_graphs import used_master
from rostether.errors import GraphError
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.roscore import Roscore


@pytest.fixture
def free_port() -> int:
    return ros1_peers.free_port()


async def answers(uri: str) -> bool:
    client = MasterClient(uri, "/test")
    try:
        await client.get_pid()
    except GraphError:
        return False
    finally:
        await client.close()
    return True


async def test_a_master_is_started_if_there_is_none(free_port: int) -> None:
    uri = f"http://localhost:{free_port}"
    async with used_master(RosEnvironment.read({"ROS_MASTER_URI": uri})) as used:
        assert used.line.startswith("Started a ROS master: ROS_MASTER_URI=http://")
        assert used.environment.master.port == free_port
        assert await answers(uri)
    assert not await answers(uri)


async def test_the_port_may_be_chosen(free_port: int) -> None:
    async with used_master(RosEnvironment.read({}), port=free_port) as used:
        assert used.environment.master.port == free_port
        assert await answers(f"http://localhost:{free_port}")


async def test_a_master_that_answers_is_joined() -> None:
    core = await Roscore.start(RosEnvironment.read({}), port=0)
    try:
        environment = RosEnvironment.read({"ROS_MASTER_URI": core.uri})
        async with used_master(environment) as used:
            assert used.line == f"Joining the ROS master at {core.uri}"
        assert await answers(core.uri)
    finally:
        await core.close()


async def test_two_that_start_at_once_agree(free_port: int) -> None:
    environment = RosEnvironment.read({"ROS_MASTER_URI": f"http://localhost:{free_port}"})
    lines = []
    both = asyncio.Barrier(2)

    async def serve() -> None:
        async with used_master(environment) as used:
            lines.append(used.line.partition(" ")[0])
            await both.wait()

    await asyncio.wait_for(asyncio.gather(serve(), serve()), 60)
    assert sorted(lines) == ["Joining", "Started"]


@pytest.mark.parametrize("is_chosen", [True, False])
async def test_a_chosen_or_distant_master_is_waited_for_not_replaced(is_chosen: bool, free_port: int) -> None:
    uri = f"http://localhost:{free_port}" if is_chosen else "http://192.0.2.1:11311"
    environment = RosEnvironment.read({"ROS_MASTER_URI": uri})
    async with used_master(environment, is_chosen=is_chosen) as used:
        assert used.line == f"Using the ROS master at {uri}, which does not answer yet; waiting for it"
        assert not (is_chosen and await answers(uri))


async def test_a_port_that_something_else_has_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.cli.access.served_graphs._ANSWER_LIMIT_S", 0.2)

    async def hang_up(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.close()

    server = await asyncio.start_server(hang_up, "127.0.0.1", 0)
    uri = f"http://localhost:{server.sockets[0].getsockname()[1]}"
    with pytest.raises(GraphError):
        async with used_master(RosEnvironment.read({"ROS_MASTER_URI": uri})):
            pass
    server.close()
    await server.wait_closed()
