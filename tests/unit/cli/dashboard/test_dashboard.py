from __future__ import annotations

import asyncio
import re
import socket
import ssl
import urllib.request
from pathlib import Path

import pytest
from websockets.asyncio.client import connect
from websockets.typing import Subprotocol

from interop.ros1_peers import free_port
from programs import Peer, started
from rostether.cli.access.ros1_access import ros1_join
from rostether.cli.access.served_graphs import ServedGraphs
from rostether.cli.dashboard import served, view
from rostether.cli.dashboard.served import page_url
from rostether.cli.dashboard.settings import DashboardSettings
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.recording.files import Form, form_of, open_recording
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.serde.store import TypeStore
from rostether.transports.own_names import outward_address
from unit.cli.gateway.test_foxglove import offers
from unit.gateways.foxglove.protocol_client import ProtocolClient

pytestmark = pytest.mark.slow

LAUNCH = "<launch><param name='speed' value='3'/></launch>"


async def fetched(peer: Peer) -> tuple[str, str]:
    """Return the address that was printed and the page that is there."""
    await peer.wait_for("Dashboard: http://127.0.0.1:")
    match = re.search(r"Dashboard: (http://127\.0\.0\.1:\d+)", peer.text)
    assert match is not None
    reply = await asyncio.to_thread(urllib.request.urlopen, match[1], timeout=60)
    with reply:
        return match[1], reply.read().decode()


async def test_a_port_that_another_program_binds_first_is_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        ports = [other.getsockname()[1], free_port()]
        monkeypatch.setattr(served, "_free_port", lambda host, wanted: ports.pop(0))
        master = await MasterServer.start(port=0)
        environment = RosEnvironment(master_uri=master.uri)
        graphs = ServedGraphs(ros1_join(environment), environment, ())
        try:
            settings = DashboardSettings(has_page=False)
            async with served.served_dashboard(settings, graphs, (), lambda level, text: None) as shown:
                assert not ports
                assert shown.gateway.port != other.getsockname()[1]
        finally:
            await master.close()


async def test_it_serves_the_page_and_the_graph_until_its_node_ends() -> None:
    master = await MasterServer.start(port=0)
    try:
        async with started("dashboard", "--port", "0", "--master", master.uri) as alone:
            url, page = await fetched(alone)
            assert page.startswith("<!doctype html>")
            await offers(url.replace("http:", "ws:"), "/rosout")
            assert "this machine only; `rostether dashboard --listen 0.0.0.0` allows" in alone.text
            async with started("node", "kill", "/dashboard", "--master", master.uri) as kill:
                await kill.wait_for("killed")
            await alone.wait_for("its node was shut down")
            assert await alone.process.wait() == 0
    finally:
        await master.close()


async def test_a_port_in_use_is_passed_over_unless_it_was_asked_for() -> None:
    master = await MasterServer.start(port=0)
    try:
        async with started("dashboard", "--master", master.uri) as first:
            url, _ = await fetched(first)
            async with started("dashboard", "--master", master.uri) as second:
                assert (await fetched(second))[0] != url
            port = url.rpartition(":")[2]
            async with started("dashboard", "-p", port, "--master", master.uri, "__name:=c") as third:
                await third.wait_for(f"dashboard: port {port} is already in use on localhost")
                assert await third.process.wait() == 1
    finally:
        await master.close()


async def test_with_a_token_the_address_carries_it() -> None:
    master = await MasterServer.start(port=0)
    try:
        async with started("dashboard", "-p", "0", "--token", "a b", "--master", master.uri) as alone:
            await fetched(alone)
            assert re.search(r"Dashboard: http://127\.0\.0\.1:\d+/#token=a%20b", alone.text)
    finally:
        await master.close()


async def test_pages_may_look_or_drive_by_their_token() -> None:
    master = await MasterServer.start(port=0)
    tokens = ("--token", "full", "--view-token", "look")
    try:
        async with started("dashboard", "-p", "0", *tokens, "--master", master.uri) as alone:
            url, _ = await fetched(alone)
            await alone.wait_for("Dashboard, view only: http://127.0.0.1:")
            rights = {}
            for token in ("full", "look"):
                uri = f"{url.replace('http:', 'ws:')}/?token={token}"
                client = ProtocolClient(
                    await connect(uri, subprotocols=[Subprotocol("foxglove.sdk.v1")], proxy=None)
                )
                rights[token] = (await client.wait("serverInfo"))["metadata"]
                if token == "full":
                    channel = {"id": 1, "topic": "/cmd_vel", "encoding": "ros1"}
                    channel |= {"schemaName": "geometry_msgs/Twist", "driver": "page"}
                    await client.say("advertise", channels=[channel])
                    await client.wait("drive")
                    assert "/web_teleop" in master.api.registrations.nodes
                await client.close()
            assert {each: (rights[each]["rights"], rights[each]["features"]) for each in rights} == {
                "full": ("full", "drive,record"),
                "look": ("view", "record"),
            }
    finally:
        await master.close()


async def test_it_encrypts_with_a_certificate_of_its_own(tmp_path: Path) -> None:
    master = await MasterServer.start(port=0)
    arguments = ("dashboard", "-p", "0", "--tls", "auto", "--master", master.uri)
    try:
        async with started(*arguments, XDG_STATE_HOME=str(tmp_path)) as alone:
            await alone.wait_for("Browsers warn until a device trusts this machine; see https://127.0.0.1:")
            match = re.search(r"Dashboard: https(://127\.0\.0\.1:\d+)", alone.text)
            assert match is not None
            trust = ssl.create_default_context(cafile=str(tmp_path / "rostether" / "tls" / "authority.pem"))

            def read(path: str) -> bytes:
                with urllib.request.urlopen(f"https{match[1]}{path}", timeout=60, context=trust) as reply:
                    return bytes(reply.read())

            assert (await asyncio.to_thread(read, "/")).startswith(b"<!doctype html>")
            assert b"authority.crt" in await asyncio.to_thread(read, "/certificate.html")
            assert (await asyncio.to_thread(read, "/authority.crt")).startswith(b"-----BEGIN CERT")
            uri = f"wss{match[1]}"
            viewer = await connect(uri, ssl=trust, subprotocols=[Subprotocol("foxglove.sdk.v1")], proxy=None)
            assert "serverInfo" in str(await viewer.recv())
            await viewer.close()
    finally:
        await master.close()


async def test_a_page_records_and_downloads(tmp_path: Path) -> None:
    master = await MasterServer.start(port=0)
    arguments = ("dashboard", "-p", "0", "--recordings", str(tmp_path / "bags"), "--master", master.uri)
    try:
        async with started(*arguments) as alone:
            url, _ = await fetched(alone)
            client = ProtocolClient(
                await connect(
                    url.replace("http:", "ws:"), subprotocols=[Subprotocol("foxglove.sdk.v1")], proxy=None
                )
            )
            assert (await client.wait("serverInfo"))["metadata"]["features"] == "drive,record"
            await client.say("listRecordings")
            await client.wait("recordings")
            await client.say("startRecording", format="bag")
            await client.wait("recordings", lambda state: state["active"])
            await client.say("stopRecording")
            state = await client.wait("recordings", lambda state: state["files"])
            (file,) = state["files"]
            await client.close()

            def read() -> bytes:
                with urllib.request.urlopen(f"{url}/recordings/{file['name']}", timeout=60) as reply:
                    return bytes(reply.read())

            content = await asyncio.to_thread(read)
            assert content.startswith(b"#ROSBAG V2.0\n")
            assert content == (tmp_path / "bags" / file["name"]).read_bytes()
    finally:
        await master.close()


async def test_without_ros1_a_recording_has_ros2_messages(tmp_path: Path) -> None:
    network = MemoryNetwork()
    settings = DashboardSettings(has_page=False, recordings=tmp_path)
    graphs = ServedGraphs(network.join, None, ())
    robot = TypedGraph(await network.join("/robot"), TypeStore(Registry()))
    publisher = await robot.publisher("/chatter", "std_msgs/String", latch=True)
    publisher.publish(data="hello")
    async with served.served_dashboard(settings, graphs, (), lambda level, text: None) as shown:
        url = f"ws://127.0.0.1:{shown.gateway.port}"
        subprotocols = [Subprotocol("foxglove.sdk.v1")]
        client = ProtocolClient(await connect(url, subprotocols=subprotocols, proxy=None))
        assert (await client.wait("serverInfo"))["metadata"]["recording_format"] == "mcap"
        await client.say("listRecordings")
        await client.say("startRecording", format="mcap")
        await client.wait("recordings", lambda state: state["active"] and state["active"]["messages"])
        await client.say("stopRecording")
        state = await client.wait("recordings", lambda state: state["files"])
        await client.close()
    (file,) = state["files"]
    reader = await asyncio.to_thread(open_recording, tmp_path / file["name"])
    assert form_of(reader) is Form.ROS2
    assert "/chatter" in {connection.topic for connection in reader.counts}


async def test_the_gateway_alone() -> None:
    master = await MasterServer.start(port=0)
    try:
        async with started("dashboard", "-p", "0", "--no-page", "--master", master.uri) as alone:
            await alone.wait_for("the gateway without the page is at ws://localhost:")
            url = re.search(r"ws://(localhost:\d+)", alone.text)
            assert url is not None
            with pytest.raises(urllib.error.HTTPError, match="426") as refused:
                await asyncio.to_thread(urllib.request.urlopen, f"http://{url[1]}", timeout=60)
            refused.value.close()
    finally:
        await master.close()


async def test_serve_has_the_dashboard_beside_boards() -> None:
    port = str(free_port())
    async with started(
        "serve", "tcp://127.0.0.1:0", "--master-port", port, "--dashboard", "127.0.0.1:0"
    ) as serve:
        assert (await fetched(serve))[1].startswith("<!doctype html>")


async def test_launch_has_the_dashboard_beside_nodes(tmp_path: Path) -> None:
    file = tmp_path / "robot.launch"
    file.write_text(LAUNCH)
    port = str(free_port())
    async with started("launch", str(file), "-p", port, "--dashboard", "0", ROS_HOME=str(tmp_path)) as launch:
        assert (await fetched(launch))[1].startswith("<!doctype html>")


async def test_the_demo_has_the_dashboard() -> None:
    uri = f"http://127.0.0.1:{free_port()}"
    async with started("demo", "--board", "python", "--ros1", ROS_MASTER_URI=uri) as demo:
        url, page = await fetched(demo)
        assert page.startswith("<!doctype html>")
        await offers(url.replace("http:", "ws:"), "/diagnostics")


async def test_the_demo_without_the_dashboard() -> None:
    uri = f"http://127.0.0.1:{free_port()}"
    async with started("demo", "--board", "python", "--ros1", "--no-page", ROS_MASTER_URI=uri) as demo:
        await demo.wait_for("virtual board ready")
        assert "Dashboard" not in demo.text


@pytest.mark.parametrize(
    ("host", "token", "url"),
    [
        ("localhost", "", "http://127.0.0.1:8765"),
        ("127.0.0.1", "", "http://127.0.0.1:8765"),
        ("::1", "", "http://[::1]:8765"),
        ("0.0.0.0", "", f"http://{outward_address() or socket.gethostname()}:8765"),
        ("robot.local", "x&y#", "http://robot.local:8765/#token=x%26y%23"),
    ],
)
def test_its_address(host: str, token: str, url: str) -> None:
    assert page_url(host, 8765, token) == url


async def test_a_browser_that_does_not_start_is_not_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(_: str) -> bool:
        raise OSError("no browser")

    monkeypatch.setattr("webbrowser.open", fails)
    await view.open_browser("http://127.0.0.1:1")


def test_a_browser_opens_only_where_windows_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    monkeypatch.setattr("sys.platform", "linux")
    assert view.has_browser({"DISPLAY": ":0"})
    assert view.has_browser({"WAYLAND_DISPLAY": "wayland-0"})
    assert not view.has_browser({})
    monkeypatch.setattr("sys.platform", "darwin")
    assert view.has_browser({})
    assert not view.has_browser({"SSH_CONNECTION": "1.2.3.4"})
    monkeypatch.setattr("sys.stdout.isatty", lambda: False)
    assert not view.has_browser({"DISPLAY": ":0"})
