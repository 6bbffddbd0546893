"""All files that state the version of a release state the same one."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_versions_agree() -> None:
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    properties = (ROOT / "client" / "library.properties").read_text()
    assert re.findall(r"^version=(.*)$", properties, re.MULTILINE) == [version]
    assert json.loads((ROOT / "client" / "library.json").read_text())["version"] == version
