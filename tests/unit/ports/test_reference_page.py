"""The reference page of devices.toml has every key, and its example is valid."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rostether.ports.devices_toml import (
    ACCESS_KEYS,
    DISCOVERY_KEYS,
    MATCH_KEYS,
    SETTING_KEYS,
    parse_devices_toml,
)

DOCS = Path(__file__).parents[3] / "docs"
PAGE = DOCS / "reference" / "devices-toml.md"


def test_every_key_has_a_row() -> None:
    rows = re.findall(r"^\| `(\w+)` \|", PAGE.read_text(), re.MULTILINE)
    assert rows == [*DISCOVERY_KEYS, *MATCH_KEYS, *SETTING_KEYS, *ACCESS_KEYS]


@pytest.mark.parametrize(
    "page", [PAGE, DOCS / "how-to" / "let-boards-be-found.md"], ids=lambda page: page.stem
)
def test_examples_can_be_read(page: Path) -> None:
    blocks = re.findall(r"^```toml\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)
    assert blocks
    for block in blocks:
        parse_devices_toml(block)
