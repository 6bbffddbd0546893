"""`rostether core --ros2 zenoh`: a router that connects sessions."""

from __future__ import annotations

import signal

import pytest

from contract.graphs import STRING, Inbox, string
from contract.zenoh_graphs import open_session
from interop.ros1_peers import free_port
from programs import start_command
from rostether.ros2.zenoh.configuration import is_router_there
from unit.cli.command_shell import Shell
from waiting import until


async def test_it_connects_sessions() -> None:
    port = free_port()
    listening = f'listen/endpoints=["tcp/127.0.0.1:{port}"]'
    router = await start_command("core", "--ros2", "zenoh", environment={"ZENOH_CONFIG_OVERRIDE": listening})
    sessions = []
    try:
        await router.wait_for("add --zenoh-listen tcp/0.0.0.0:7447 for other machines")
        await router.wait_for("Press Ctrl-C")
        sessions = [await open_session(port, is_router=False) for _ in range(2)]
        talker, listener = [await session.join(f"node_{at}") for at, session in enumerate(sessions)]
        inbox = Inbox()
        await listener.subscribe("/chat", STRING, inbox.store)
        publisher = await talker.advertise("/chat", STRING)
        await until(lambda: publisher.subscriber_count == 1)
        publisher.publish_raw([string("hello")])
        await until(lambda: inbox.payloads == [string("hello")])
    finally:
        for session in sessions:
            await session.close()
        await router.stop(signal.SIGTERM)
    assert router.process.returncode == 0


async def test_a_second_router_at_its_port_is_refused() -> None:
    port = free_port()
    listening = {"ZENOH_CONFIG_OVERRIDE": f'listen/endpoints=["tcp/127.0.0.1:{port}"]'}
    session = await open_session(port, is_router=True)
    try:
        router = await start_command("core", "--ros2", "zenoh", environment=listening)
        assert "zenoh cannot listen" in await router.finish()
        assert router.process.returncode == 1
    finally:
        await session.close()


async def test_it_listens_only_where_it_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.ros2.zenoh.configuration.PROBE_TIMEOUT_S", 60.0)
    port = free_port()
    router = await start_command("core", "--ros2", "zenoh", "--zenoh-listen", f"tcp/127.0.0.1:{port}")
    try:
        # Another router at the usual port of this machine makes no difference.
        await router.wait_for("Nodes on this machine use tcp/localhost:7447")
        await router.wait_for("Press Ctrl-C")
        assert await is_router_there(f"tcp/127.0.0.1:{port}")
    finally:
        await router.stop(signal.SIGTERM)


@pytest.mark.parametrize(
    ("options", "reported"),
    [
        (("--ros2", "rclpy"), "only ROS 2 over zenoh needs a router; with DDS, nodes discover each other"),
        (("--ros2", "zenoh", "--port", "1"), "the router accepts only --zenoh-connect and --zenoh-listen"),
    ],
)
def test_wrong_options_are_refused(shell: Shell, options: tuple[str, ...], reported: str) -> None:
    assert reported in shell.failure("core", *options, code=2)
