from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.ros2.environment import Ros2Environment


def test_the_default_is_domain_0() -> None:
    environment = Ros2Environment.read({})
    assert environment == Ros2Environment()
    assert environment.domain_id == 0


def test_every_variable_is_read(tmp_path: Path) -> None:
    config = tmp_path / "session.json5"
    config.write_text("{}")
    environment = Ros2Environment.read(
        {
            "ROS_DOMAIN_ID": " 42 ",
            "RMW_IMPLEMENTATION": "rmw_zenoh_cpp",
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "localhost",
            "ZENOH_SESSION_CONFIG_URI": str(config),
            "ZENOH_ROUTER_CONFIG_URI": f"file://{config}",
            "ZENOH_CONFIG_OVERRIDE": 'mode="client"; connect/endpoints=["tcp/10.0.0.1:7447"];',
        }
    )
    assert environment == Ros2Environment(
        42,
        "rmw_zenoh_cpp",
        config,
        config,
        (("mode", '"client"'), ("connect/endpoints", '["tcp/10.0.0.1:7447"]')),
    )


@pytest.mark.parametrize(
    ("variable", "value"),
    [
        ("ROS_DOMAIN_ID", "233"),
        ("ROS_DOMAIN_ID", "-1"),
        ("ROS_DOMAIN_ID", "one"),
        ("ROS_AUTOMATIC_DISCOVERY_RANGE", "moon"),
        ("ZENOH_SESSION_CONFIG_URI", "/nowhere/session.json5"),
        ("ZENOH_ROUTER_CONFIG_URI", "/nowhere/router.json5"),
        ("ZENOH_CONFIG_OVERRIDE", "mode"),
        ("ZENOH_CONFIG_OVERRIDE", "mode="),
        ("ZENOH_CONFIG_OVERRIDE", "=1"),
    ],
)
def test_errors_name_the_invalid_variable(variable: str, value: str) -> None:
    with pytest.raises(ConfigError, match=variable) as caught:
        Ros2Environment.read({variable: value})
    assert "\n" not in str(caught.value)
