from __future__ import annotations

import re
import socket
from pathlib import Path

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus
from websockets.typing import Subprotocol

from interop.ros1_peers import free_port
from programs import Peer, started
from rostether.cli.gateway import foxglove
from rostether.cli.gateway.foxglove import settings_of_parameters
from rostether.errors import ConfigError
from rostether.gateways.foxglove.settings import CAPABILITIES, FoxgloveLimits, FoxgloveSettings
from rostether.launch.sources import bundled_launch_packages
from rostether.ros1.master.server import MasterServer
from unit.gateways.foxglove.protocol_client import ProtocolClient


def address(peer: Peer) -> str:
    match = re.search(r"connection to (ws://localhost:\d+)", peer.text)
    assert match is not None, peer.text
    return match[1]


async def offers(uri: str, topic: str) -> None:
    protocols = [Subprotocol("foxglove.sdk.v1")]
    client = ProtocolClient(await connect(uri, subprotocols=protocols, proxy=None))
    await client.channel(topic)
    await client.close()


async def test_serve_offers_its_graph_to_foxglove() -> None:
    port = free_port()
    async with started(
        "serve", "--foxglove", "0", "tcp://127.0.0.1:0", "--master-port", str(port), "--token", "abc"
    ) as serve:
        await serve.wait_for("allows other machines")
        await offers(f"{address(serve)}/?token=abc", "/rosout")
        with pytest.raises(InvalidStatus):
            await offers(address(serve), "/rosout")
        assert (
            "foxglove: accepts connections from this machine only; --foxglove 0.0.0.0:0 allows other machines"
            in serve.text
        )


async def test_it_waits_for_its_master_and_ends_with_its_node() -> None:
    port = free_port()
    async with started("foxglove", "0", "--master", f"http://127.0.0.1:{port}") as alone:
        await alone.wait_for("foxglove_bridge waits: the ROS master at")
        master = await MasterServer.start(port=port)
        try:
            await alone.wait_for("in Foxglove")
            await offers(address(alone), "/rosout")
            async with started("node", "kill", "/foxglove_bridge", "--master", master.uri) as kill:
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
            async with started("foxglove", f"127.0.0.1:{port}", "--master", master.uri) as alone:
                assert await alone.process.wait() == 1
                await alone.wait_for(
                    f"rostether: error: foxglove: port {port} is already in use on 127.0.0.1"
                )
        finally:
            await master.close()


async def test_the_established_launch_file_needs_no_installation(tmp_path: Path) -> None:
    port, master_port = free_port(), free_port()
    launch = ("launch", "foxglove_bridge", "foxglove_bridge.launch", f"port:={port}")
    words = "topic_whitelist:=['/rosout_a.*']"
    async with started(*launch, words, "-p", str(master_port), ROS_LOG_DIR=str(tmp_path)) as launched:
        await launched.wait_for("allows other machines")
        uri = f"ws://localhost:{port}"
        protocols = [Subprotocol("foxglove.sdk.v1")]
        client = ProtocolClient(await connect(uri, subprotocols=protocols, proxy=None))
        await client.channel("/rosout_agg")
        topics = [each["topic"] for message in client.of("advertise") for each in message["channels"]]
        assert topics == ["/rosout_agg"]
        await client.close()


def test_our_packages_have_what_their_names_promise() -> None:
    folder = bundled_launch_packages()["foxglove_bridge"]
    assert (folder / "package.xml").is_file()
    assert (folder / "launch" / "foxglove_bridge.launch").is_file()


def test_parameters_of_foxglove_bridge() -> None:
    everything = {"topic_whitelist": [".*"], "capabilities": list(CAPABILITIES), "send_buffer_limit": 0}
    assert settings_of_parameters({}) == settings_of_parameters(everything) == FoxgloveSettings()
    settings = settings_of_parameters(
        {
            "port": 8800,
            "address": "0.0.0.0",
            "send_buffer_limit": 1000,
            "capabilities": ["services", "unknown"],
            "topic_whitelist": ["/camera/.*", "/tf"],
            "client_topic_whitelist": [],
            "max_update_ms": 5000,
        }
    )
    assert (settings.host, settings.port, settings.capabilities) == ("0.0.0.0", 8800, ("services",))
    assert settings.limits == FoxgloveLimits(waiting_bytes=1000)
    names = ["/camera/image", "/tf", "/tf_static"]
    assert [settings.topics.includes(each) for each in names] == [True, True, False]
    assert not settings.client_topics.includes("/cmd_vel")
    secure = settings_of_parameters({"tls": True, "certfile": "a.pem", "keyfile": "b.pem"})
    assert (secure.certificate, secure.key) == ("a.pem", "b.pem")


@pytest.mark.parametrize(
    ("parameters", "reason"),
    [
        ({"port": "many"}, "~port must be a whole number, not 'many'"),
        ({"tls": True}, "~tls needs ~certfile and ~keyfile"),
        ({"topic_whitelist": "/a"}, "~topic_whitelist must be a list"),
        ({"topic_whitelist": ["("]}, "~topic_whitelist: .* is not a regular expression"),
        ({"capabilities": "services"}, "~capabilities must be a list"),
    ],
)
def test_parameters_that_make_no_sense(parameters: dict[str, object], reason: str) -> None:
    with pytest.raises(ConfigError, match=reason):
        settings_of_parameters(parameters)


def test_packages_of_msg_path_come_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in ("given", "environment"):
        (tmp_path / folder / "arm").mkdir(parents=True)
        (tmp_path / folder / "arm" / "package.xml").write_text("<package><name>arm</name></package>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "environment"))
    assert foxglove._package_folders(())["arm"] == tmp_path / "environment" / "arm"
    assert foxglove._package_folders([tmp_path / "given"])["arm"] == tmp_path / "given" / "arm"
