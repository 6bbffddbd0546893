"""The meaning of the ROS environment variables."""

from __future__ import annotations

import pytest

from rostether.errors import ConfigError
from rostether.mechanisms.loopback import is_loopback
from rostether.ros1.environment import RosEnvironment, RpcUri, connect_host, format_uri, parse_rpc_uri


def test_an_empty_environment_is_loopback_and_the_default_master() -> None:
    environment = RosEnvironment.read({})
    assert environment == RosEnvironment()
    assert environment.master_uri == "http://localhost:11311"
    assert environment.master == RpcUri("localhost", 11311)
    assert environment.master.is_loopback
    assert not environment.master_uri_is_set
    assert environment.advertised_host == "127.0.0.1"
    assert environment.listen_hosts == ("127.0.0.1",)
    assert environment.listens_on_loopback_only
    assert environment.namespace == "/"


def test_empty_variables_count_as_unset() -> None:
    names = ("ROS_MASTER_URI", "ROS_IP", "ROS_HOSTNAME", "ROS_NAMESPACE", "ROS_PACKAGE_PATH")
    assert RosEnvironment.read(dict.fromkeys(names, "")) == RosEnvironment()


def test_the_process_environment_is_the_default(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", "http://robot:11312/")
    assert RosEnvironment.read().master == RpcUri("robot", 11312, "/")


def test_a_chosen_master_is_marked_as_chosen() -> None:
    environment = RosEnvironment.read({"ROS_MASTER_URI": " http://localhost:11311 "})
    assert environment.master_uri_is_set
    assert environment.master_uri == "http://localhost:11311"


@pytest.mark.parametrize(
    ("variables", "advertised", "listen"),
    [
        ({"ROS_IP": "192.168.1.7"}, "192.168.1.7", ("192.168.1.7", "127.0.0.1")),
        ({"ROS_IP": "127.0.0.1"}, "127.0.0.1", ("127.0.0.1",)),
        ({"ROS_IP": "127.0.1.1"}, "127.0.1.1", ("127.0.1.1",)),
        ({"ROS_IP": "fd00::7"}, "fd00::7", ("fd00::7", "127.0.0.1")),
        ({"ROS_HOSTNAME": "localhost"}, "localhost", ("127.0.0.1",)),
        ({"ROS_HOSTNAME": "robot.local"}, "robot.local", ("0.0.0.0",)),
        ({"ROS_HOSTNAME": "10.0.0.3"}, "10.0.0.3", ("10.0.0.3", "127.0.0.1")),
        ({"ROS_HOSTNAME": "robot", "ROS_IP": "10.0.0.3"}, "robot", ("0.0.0.0",)),
    ],
)
def test_servers_listen_at_the_named_address(
    variables: dict[str, str], advertised: str, listen: tuple[str, ...]
) -> None:
    environment = RosEnvironment.read(variables)
    assert environment.advertised_host == advertised
    assert environment.listen_hosts == listen
    assert environment.listens_on_loopback_only is all(is_loopback(host) for host in listen)


def test_every_address_is_not_advertised_as_such() -> None:
    environment = RosEnvironment.read({"ROS_IP": "0.0.0.0"})
    assert environment.listen_hosts == ("0.0.0.0",)
    assert environment.advertised_host not in ("", "0.0.0.0")


@pytest.mark.parametrize(
    ("address", "advertised", "listen"),
    [
        ("192.168.1.7", "192.168.1.7", ("192.168.1.7", "127.0.0.1")),
        ("localhost", "localhost", ("127.0.0.1",)),
    ],
)
def test_listen_option(address: str, advertised: str, listen: tuple[str, ...]) -> None:
    environment = RosEnvironment().listening_on(address)
    assert (environment.advertised_host, environment.listen_hosts) == (advertised, listen)


def test_listening_everywhere_keeps_the_advertised_host_of_ros_ip() -> None:
    environment = RosEnvironment.read({"ROS_IP": "10.0.0.3"}).listening_on("0.0.0.0")
    assert (environment.advertised_host, environment.listen_hosts) == ("10.0.0.3", ("0.0.0.0",))


def test_master_option_wins() -> None:
    environment = RosEnvironment().with_master("http://10.0.0.9:1234")
    assert environment.master == RpcUri("10.0.0.9", 1234)
    assert environment.master_uri_is_set
    with pytest.raises(ConfigError, match="not a URI"):
        environment.with_master("10.0.0.9")
    with pytest.raises(ConfigError, match="write host and port, such as http://robot:11311"):
        environment.with_master("robot:11311")


@pytest.mark.parametrize(
    ("text", "namespace"),
    [("robot1", "/robot1"), ("/robot1/", "/robot1"), ("lab//robot_1", "/lab/robot_1"), ("/", "/")],
)
def test_namespaces_are_made_global(text: str, namespace: str) -> None:
    assert RosEnvironment.read({"ROS_NAMESPACE": text}).namespace == namespace


@pytest.mark.parametrize(
    ("variable", "value"),
    [
        ("ROS_MASTER_URI", "localhost:11311"),
        ("ROS_MASTER_URI", "http://localhost"),
        ("ROS_MASTER_URI", "https://localhost:11311"),
        ("ROS_MASTER_URI", "http://localhost:0"),
        ("ROS_MASTER_URI", "http://localhost:99999"),
        ("ROS_MASTER_URI", "http://user@host:1"),
        ("ROS_MASTER_URI", "http://:11311"),
        ("ROS_IP", "http://10.0.0.3"),
        ("ROS_IP", "10.0.0.3:11311"),
        ("ROS_HOSTNAME", "robot:11311"),
        ("ROS_HOSTNAME", "-robot"),
        # Bytes that are not UTF-8.
        ("ROS_HOSTNAME", "\udcff"),
        ("ROS_IP", "\udcff"),
        ("ROS_NAMESPACE", "ro-bot"),
        ("ROS_NAMESPACE", "~robot"),
        ("ROS_NAMESPACE", "ro bot"),
    ],
)
def test_an_invalid_value_is_reported_with_its_variable(variable: str, value: str) -> None:
    with pytest.raises(ConfigError, match=variable) as raised:
        RosEnvironment.read({variable: value})
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("uri", "parts"),
    [
        ("http://localhost:11311", RpcUri("localhost", 11311)),
        ("http://localhost:11311/", RpcUri("localhost", 11311)),
        ("http://10.0.0.3:80/RPC2", RpcUri("10.0.0.3", 80, "/RPC2")),
        ("http://[fd00::7]:5/", RpcUri("fd00::7", 5)),
    ],
)
def test_uris_are_parsed(uri: str, parts: RpcUri) -> None:
    assert parse_rpc_uri(uri) == parts


def test_service_uris() -> None:
    assert parse_rpc_uri("rosrpc://robot:5", scheme="rosrpc") == RpcUri("robot", 5)
    with pytest.raises(ConfigError, match="rosrpc://"):
        parse_rpc_uri("http://robot:5", scheme="rosrpc")


def test_uris_are_formatted_as_peers_write_them() -> None:
    assert format_uri("robot", 5) == "http://robot:5/"
    assert format_uri("fd00::7", 5) == "http://[fd00::7]:5/"
    assert format_uri("robot", 5, scheme="rosrpc") == "rosrpc://robot:5"


def test_connections_to_localhost_use_its_number() -> None:
    assert connect_host("localhost") == "127.0.0.1"
    assert connect_host("robot") == "robot"
