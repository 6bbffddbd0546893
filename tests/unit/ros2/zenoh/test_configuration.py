from __future__ import annotations

import asyncio
import json
from pathlib import Path

import pytest
import zenoh

from rostether.errors import ConfigError
from rostether.ros2.environment import Ros2Environment
from rostether.ros2.zenoh.configuration import (
    configures_endpoints,
    is_router_there,
    peer_configuration,
    router_configuration,
)
from rostether.ros2.zenoh_reach import RouterChoice, ZenohReach
from rostether.transports.sockets import close_servers


def endpoints(configuration: zenoh.Config, path: str) -> list[str]:
    found = json.loads(configuration.get_json(path))
    assert isinstance(found, list)
    return found


def test_a_peer_listens_on_loopback_and_knows_the_router() -> None:
    configuration = peer_configuration(Ros2Environment(), ZenohReach())
    assert configuration.get_json("mode") == '"peer"'
    assert endpoints(configuration, "listen/endpoints") == ["tcp/localhost:0"]
    assert endpoints(configuration, "connect/endpoints") == ["tcp/localhost:7447"]
    assert configuration.get_json("scouting/multicast/enabled") == "false"


def test_a_router_listens_on_loopback_only() -> None:
    configuration = router_configuration(Ros2Environment(), ZenohReach())
    assert configuration.get_json("mode") == '"router"'
    assert endpoints(configuration, "listen/endpoints") == ["tcp/localhost:7447"]


def test_endpoints_are_added() -> None:
    reach = ZenohReach(connect=("tcp/10.0.0.1:7447",), listen=("tcp/10.0.0.2:7447",))
    configuration = router_configuration(Ros2Environment(), reach)
    assert endpoints(configuration, "listen/endpoints") == ["tcp/localhost:7447", "tcp/10.0.0.2:7447"]
    assert endpoints(configuration, "connect/endpoints") == ["tcp/10.0.0.1:7447"]


def test_a_forced_router_listens_only_at_its_configured_endpoints() -> None:
    reach = ZenohReach(RouterChoice.ALWAYS, listen=("tcp/10.0.0.2:7447",))
    assert endpoints(router_configuration(Ros2Environment(), reach), "listen/endpoints") == list(reach.listen)
    usual = router_configuration(Ros2Environment(), ZenohReach(RouterChoice.ALWAYS))
    assert endpoints(usual, "listen/endpoints") == ["tcp/localhost:7447"]


@pytest.mark.parametrize("everywhere", ["tcp/0.0.0.0:7447", "tcp/[::]:7447"])
def test_all_addresses_replace_loopback(everywhere: str) -> None:
    configuration = router_configuration(Ros2Environment(), ZenohReach(listen=(everywhere,)))
    assert endpoints(configuration, "listen/endpoints") == [everywhere]


def test_overrides_have_priority() -> None:
    environment = Ros2Environment(zenoh_overrides=(("mode", '"client"'), ("connect/endpoints", "[]")))
    configuration = peer_configuration(environment, ZenohReach())
    assert configuration.get_json("mode") == '"client"'
    assert endpoints(configuration, "connect/endpoints") == []


def test_a_file_replaces_all_defaults(tmp_path: Path) -> None:
    path = tmp_path / "zenoh.json5"
    path.write_text('{mode: "client", connect: {endpoints: ["tcp/10.0.0.9:7447"]}}')
    environment = Ros2Environment(zenoh_session_config=path, zenoh_router_config=path)
    for configuration in (
        peer_configuration(environment, ZenohReach()),
        router_configuration(environment, ZenohReach()),
    ):
        assert configuration.get_json("mode") == '"client"'
        assert endpoints(configuration, "connect/endpoints") == ["tcp/10.0.0.9:7447"]


def test_settings_that_zenoh_does_not_accept_are_refused_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "zenoh.json5"
    path.write_text("{mode: ")
    with pytest.raises(ConfigError, match=r"zenoh\.json5 is not a zenoh configuration") as caught:
        peer_configuration(Ros2Environment(zenoh_session_config=path), ZenohReach())
    assert "\n" not in str(caught.value)
    with pytest.raises(ConfigError, match="ZENOH_CONFIG_OVERRIDE: zenoh does not accept nonsense=1"):
        peer_configuration(Ros2Environment(zenoh_overrides=(("nonsense", "1"),)), ZenohReach())
    with pytest.raises(ConfigError, match="zenoh does not accept connect/endpoints nowhere"):
        peer_configuration(Ros2Environment(), ZenohReach(connect=("nowhere",)))


def test_endpoints_of_the_user_are_detected() -> None:
    assert not configures_endpoints(Ros2Environment())
    assert not configures_endpoints(Ros2Environment(zenoh_overrides=(("scouting/delay", "1"),)))
    assert configures_endpoints(Ros2Environment(zenoh_overrides=(("connect/endpoints", "[]"),)))
    assert configures_endpoints(Ros2Environment(zenoh_overrides=(("mode", '"peer"'),)))
    assert configures_endpoints(Ros2Environment(zenoh_session_config=Path("x")))


async def test_a_router_is_found_by_a_connection() -> None:
    server = await asyncio.start_server(lambda _, writer: writer.close(), "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    assert await is_router_there(f"tcp/127.0.0.1:{port}")
    await close_servers([server])
    await server.wait_closed()
    assert not await is_router_there(f"tcp/127.0.0.1:{port}")
    assert await is_router_there("unixsock-stream//tmp/somewhere")
