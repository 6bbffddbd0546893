from __future__ import annotations

import base64
import json
import re
from pathlib import Path

import pytest

from rostether.cli.dashboard.view import PANELS, View, read_view
from rostether.errors import ConfigError


def settings_of(fragment: str) -> object:
    packed = fragment.partition("s=")[2].partition("&")[0]
    return json.loads(base64.urlsafe_b64decode(packed + "=" * (-len(packed) % 4)))


def test_addresses_of_views() -> None:
    assert View("graph").fragment("") == "/graph"
    assert View("").fragment("a b") == "/?token=a%20b"
    plot = read_view("plots", ["/imu/x", "/imu/y"]).fragment("t")
    assert plot.startswith("/plots?s=")
    assert plot.endswith("&token=t")
    assert settings_of(plot) == {"names": ["/imu/x", "/imu/y"]}
    assert read_view("images", ["/camera"]).settings == {"topic": "/camera"}
    assert read_view("topics", ["/imu"]).settings == {"search": "/imu"}
    assert read_view("console", ["ignored"]) == View("console")


def test_a_file_of_rviz_is_served_beside_the_page(tmp_path: Path) -> None:
    file = tmp_path / "arm.rviz"
    file.write_text("Panels: []")
    view = read_view("scene", [str(file)])
    assert view.settings == {"rviz": "view.rviz"}
    assert view.files == {"view.rviz": b"Panels: []"}
    with pytest.raises(ConfigError, match="No such file"):
        read_view("scene", [str(tmp_path / "other.rviz")])
    file.write_bytes(b" " * (1 << 21))
    with pytest.raises(ConfigError, match="larger than 1 MiB"):
        read_view("scene", [str(file)])


def test_each_panel_of_the_page_can_be_opened() -> None:
    registry = Path(__file__).parents[4] / "web/src/panels/registry.ts"
    assert re.findall(r'"\./(\w+)/', registry.read_text(encoding="utf-8")) == sorted(PANELS)
