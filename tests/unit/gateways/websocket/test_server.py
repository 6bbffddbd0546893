from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.gateways.websocket.server import server_encryption


def test_without_a_certificate_nothing_is_encrypted() -> None:
    assert server_encryption("", "") is None


def test_files_that_cannot_be_used_are_named(tmp_path: Path) -> None:
    empty = tmp_path / "empty.pem"
    empty.write_text("")
    with pytest.raises(ConfigError, match=r"empty\.pem contains no certificate"):
        server_encryption(str(empty), "")
