from __future__ import annotations

from pathlib import Path

import pytest

from rostether.cli.gateway.encryption import Encryption, read_encryption


def test_without_the_option_nothing_is_encrypted() -> None:
    assert read_encryption("", "localhost") == Encryption()


def test_a_file_holds_both() -> None:
    assert read_encryption("robot.pem", "localhost") == Encryption("robot.pem")


def test_auto_makes_a_certificate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    made = read_encryption("auto", "0.0.0.0")
    folder = tmp_path / "rostether" / "tls"
    assert made == Encryption(
        str(folder / "server.pem"), str(folder / "server.key"), folder / "authority.pem"
    )
    assert all((folder / name).exists() for name in ("server.pem", "server.key", "authority.pem"))
