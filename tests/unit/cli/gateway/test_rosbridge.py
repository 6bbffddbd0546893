from __future__ import annotations

import asyncio
import json
import re
import socket
from pathlib import Path
from typing import Any

import pytest
from websockets.asyncio.client import connect

import rostether
from interop.ros1_peers import free_port
from programs import started
from rostether.cli.gateway.rosbridge import read_settings
from rostether.errors import ConfigError
from rostether.gateways.rosbridge.settings import RosbridgeLimits, RosbridgeSettings
from rostether.launch.sources import bundled_launch_packages
from rostether.ros1.master.server import MasterServer


async def exchanged(uri: str, **message: Any) -> dict[str, Any]:
    async with connect(uri) as connection:
        await connection.send(json.dumps(message))
        answer: dict[str, Any] = json.loads(await connection.recv())
        return answer


async def nodes(uri: str) -> list[str]:
    answer = await exchanged(uri, op="call_service", service="/rosapi/nodes", args={})
    found: list[str] = answer["values"]["nodes"]
    return found


async def test_serve_offers_its_graph_to_web_pages() -> None:
    port = free_port()
    async with started(
        "serve", "--rosbridge", "0", "tcp://127.0.0.1:0", "--master-port", str(port), "--token", "abc"
    ) as serve:
        await serve.wait_for("allows other machines")
        match = re.search(r"connect to (ws://localhost:\d+)", serve.text)
        assert match is not None, serve.text
        assert await nodes(f"{match[1]}/?token=abc") == ["/rosapi", "/rosbridge_websocket", "/rosout"]
        status = await exchanged(match[1], op="call_service", service="/rosapi/nodes")
        assert "requires a token" in status["msg"]
        assert (
            "rosbridge: accepts connections from this machine only; "
            "--rosbridge 0.0.0.0:0 allows other machines" in serve.text
        )


async def test_it_waits_for_its_master_and_ends_with_its_node() -> None:
    port = free_port()
    async with started("rosbridge", "0", "--master", f"http://127.0.0.1:{port}") as alone:
        await alone.wait_for("rosbridge_websocket waits: the ROS master at")
        master = await MasterServer.start(port=port)
        try:
            await alone.wait_for("connect to ws://")
            match = re.search(r"connect to (ws://localhost:\d+)", alone.text)
            assert match is not None
            assert "/rosbridge_websocket" in await nodes(match[1])
            async with started("node", "kill", "/rosbridge_websocket", "--master", master.uri) as kill:
                await kill.wait_for("killed")
            await alone.wait_for("its node was shut down")
            assert await alone.process.wait() == 0
        finally:
            await master.close()


async def test_a_port_in_use_is_reported_in_one_line() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        master = await MasterServer.start(port=0)
        try:
            async with started("rosbridge", f"127.0.0.1:{port}", "--master", master.uri) as alone:
                assert await alone.process.wait() == 1
                await alone.wait_for(
                    f"rostether: error: rosbridge: port {port} is already in use on 127.0.0.1"
                )
        finally:
            await master.close()


async def test_the_established_launch_file_needs_no_installation(tmp_path: Path) -> None:
    port, master_port = free_port(), free_port()
    launch = ("launch", "rosbridge_server", "rosbridge_websocket.launch", f"port:={port}")
    async with started(*launch, "-p", str(master_port), ROS_LOG_DIR=str(tmp_path)) as launched:
        await launched.wait_for("allows other machines")
        uri = f"ws://localhost:{port}"
        assert "/rosbridge_websocket" in await nodes(uri)
        name = "/rosbridge_websocket/actual_port"
        answer = await exchanged(uri, op="call_service", service="/rosapi/get_param", args=[name, ""])
        assert answer["values"]["value"] == str(port)


async def test_rosapi_is_a_separate_node_if_a_launch_file_starts_it() -> None:
    master = await MasterServer.start(port=0)
    try:
        async with (
            started("role", "rosapi-node", "_services_glob:=[/rosapi/*]", ROS_MASTER_URI=master.uri),
            rostether.join("/asking", master=master.uri) as graph,
        ):
            async with asyncio.timeout(60):
                async for snapshot in graph.changes():
                    if "/rosapi/search_param" in snapshot.services:
                        break
            answer = await graph.call("/rosapi/nodes", "rosapi/Nodes")
            assert answer.nodes == ["/asking", "/rosapi"]
    finally:
        await master.close()


def test_our_packages_have_what_their_names_promise() -> None:
    folder = bundled_launch_packages()["rosbridge_server"]
    assert (folder / "package.xml").is_file()
    assert (folder / "launch" / "rosbridge_websocket.launch").is_file()


def test_parameters_of_rosbridge_websocket() -> None:
    assert read_settings({}) == RosbridgeSettings()
    assert read_settings(
        {
            "port": "9191",
            "address": "0.0.0.0",
            "websocket_path": "/ros",
            "max_message_size": 1000,
            "use_compression": True,
            "topics_glob": "['/a', /b*]",
            "services_glob": "[]",
            "params_glob": "",
            "fragment_size": None,
            "retry_startup_delay": 5.0,
        }
    ) == RosbridgeSettings(
        host="0.0.0.0",
        port=9191,
        path="/ros",
        limits=RosbridgeLimits(message_bytes=1000),
        deflate=True,
        topics_glob=("/a", "/b*"),
    )
    secure = read_settings({"ssl": "true", "certfile": "a.pem", "keyfile": "b.pem"})
    assert (secure.certificate, secure.key) == ("a.pem", "b.pem")


@pytest.mark.parametrize(
    ("parameters", "reason"),
    [
        ({"port": "many"}, "~port must be a whole number, not 'many'"),
        ({"port": True}, "~port must be a whole number"),
        ({"authenticate": True}, "~authenticate needs a token; set ROSTETHER_TOKEN"),
        ({"ssl": True}, "~ssl needs ~certfile and ~keyfile"),
    ],
)
def test_parameters_that_make_no_sense(parameters: dict[str, object], reason: str) -> None:
    with pytest.raises(ConfigError, match=reason):
        read_settings(parameters)
