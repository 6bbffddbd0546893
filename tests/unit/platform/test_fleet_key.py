from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.platform.fleet_key import read_fleet_key


def test_a_key(tmp_path: Path) -> None:
    file = tmp_path / "fleet.key"
    file.write_text("00112233445566778899aabbccddeeff\n")
    assert read_fleet_key(str(file)) == bytes.fromhex("00112233445566778899aabbccddeeff")


@pytest.mark.parametrize("content", [b"", b"0011", b"\xff" * 32, b"secret" * 400])
def test_what_is_not_a_key_is_not_shown(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "fleet.key"
    file.write_bytes(content)
    with pytest.raises(ConfigError, match="32 hexadecimal digits; make one with: openssl") as error:
        read_fleet_key(str(file))
    assert "secret" not in str(error.value)
