from __future__ import annotations

from dataclasses import fields

import pytest

from rostether.bridge.settings import DEFAULT_SETTINGS, BridgeSettings
from rostether.cli.limit_options import LIMITS, read_limits
from rostether.errors import ConfigError


def test_nothing_given_is_the_default() -> None:
    assert read_limits(()) == DEFAULT_SETTINGS


def test_every_limit_is_a_setting_and_its_default_is_permitted() -> None:
    names = {each.name for each in fields(BridgeSettings)}
    for name, limit in LIMITS.items():
        assert limit.setting in names
        default = getattr(DEFAULT_SETTINGS, limit.setting)
        assert default is None or limit.lowest <= default <= limit.highest
        read_limits([f"{name}={limit.highest:.10g}"])


def test_limits_are_read() -> None:
    settings = read_limits(["frame-bytes=4096", "grace-s=1.5", "connections=3"])
    assert (settings.frame_bytes, settings.grace_s, settings.connections) == (4096, 1.5, 3)


@pytest.mark.parametrize(
    "text", ["frame-bytes", "frames=1", "frame-bytes=65536", "endpoints=1.5", "grace-s=nan", "endpoints=x"]
)
def test_what_makes_no_sense_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(ConfigError) as caught:
        read_limits([text])
    assert str(caught.value).startswith(f"--limit {text}: ")
    assert "\n" not in str(caught.value)
