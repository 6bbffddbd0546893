from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import pytest

from rostether.bridge.settings import DEFAULT_SETTINGS, BridgeSettings
from rostether.cli.bridge.limit_options import BRIDGE_LIMITS, GRAPH_LIMITS, read_graph_limits, read_limits
from rostether.errors import ConfigError
from rostether.ports.board_limits import Limit
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits

DOCUMENTED = (Path(__file__).parents[4] / "docs/reference/limits.md").read_text()


def test_nothing_given_is_the_default() -> None:
    assert read_limits(()) == (DEFAULT_SETTINGS, DEFAULT_GRAPH_LIMITS)
    assert read_graph_limits(()) == DEFAULT_GRAPH_LIMITS


@pytest.mark.parametrize(
    ("limits", "defaults"), [(BRIDGE_LIMITS, DEFAULT_SETTINGS), (GRAPH_LIMITS, DEFAULT_GRAPH_LIMITS)]
)
def test_every_limit_is_a_setting_documented_and_its_default_is_permitted(
    limits: dict[str, Limit], defaults: BridgeSettings | GraphLimits
) -> None:
    names = {each.name for each in fields(defaults)}
    for name, limit in limits.items():
        assert limit.setting in names
        default = getattr(defaults, limit.setting)
        assert default is None or limit.lowest <= default <= limit.highest
        read_limits([f"{name}={limit.highest:.10g}"])
        assert f"`{name}`" in DOCUMENTED


def test_every_limit_of_the_graph_can_be_set() -> None:
    assert {limit.setting for limit in GRAPH_LIMITS.values()} == {each.name for each in fields(GraphLimits)}


def test_limits_are_read() -> None:
    settings, graph = read_limits(["frame-bytes=4096", "grace-s=1.5", "connections=3", "xmlrpc-bytes=65536"])
    assert (settings.frame_bytes, settings.grace_s, settings.connections) == (4096, 1.5, 3)
    assert graph.body_bytes == 65536
    assert read_graph_limits(["header-s=2.5"]).header_s == 2.5


def test_a_master_alone_has_no_limits_of_boards() -> None:
    with pytest.raises(ConfigError, match="frame-bytes=64: write NAME=VALUE, where NAME is one of xmlrpc-"):
        read_graph_limits(["frame-bytes=64"])


@pytest.mark.parametrize(
    "text", ["frame-bytes", "frames=1", "frame-bytes=65536", "endpoints=1.5", "grace-s=nan", "endpoints=x"]
)
def test_what_makes_no_sense_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(ConfigError) as caught:
        read_limits([text])
    assert str(caught.value).startswith(f"--limit {text}: ")
    assert "\n" not in str(caught.value)
