"""The command that installs an extra, for each way in which rostether may have been installed."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.extras import imported_from, install_command


@pytest.fixture
def prefix(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "rostether"
    folder.mkdir()
    monkeypatch.setattr(sys, "prefix", str(folder))
    monkeypatch.setattr(sys, "executable", f"{folder}/bin/python")
    monkeypatch.delenv("VIRTUAL_ENV", raising=False)
    return folder


def test_pip_is_the_one_of_an_activated_environment(prefix: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VIRTUAL_ENV", str(prefix))
    assert install_command("zenoh") == "pip install 'rostether[zenoh]'"


def test_pip_is_the_systems_without_an_environment(prefix: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "base_prefix", str(prefix))
    assert install_command("zenoh") == "pip install 'rostether[zenoh]'"


def test_an_inactive_environment_is_named(prefix: Path) -> None:
    assert install_command("zenoh") == f"{prefix}/bin/python -m pip install 'rostether[zenoh]'"


def test_pipx_is_asked_where_it_brought_us(prefix: Path) -> None:
    (prefix / "pipx_metadata.json").touch()
    assert install_command("zenoh") == "pipx runpip rostether install 'rostether[zenoh]'"


def test_uv_installs_into_its_own_environments(prefix: Path) -> None:
    (prefix / "pyvenv.cfg").write_text("home = /usr/bin\nuv = 0.13.9\n")
    assert install_command("zenoh") == (f"uv pip install --python {prefix}/bin/python 'rostether[zenoh]'")


def test_a_missing_package_is_reported_with_the_command_for_its_extra() -> None:
    with (
        pytest.raises(ConfigError, match=r"GPS needs another package; run: .*'rostether\[gps\]'"),
        imported_from("gps", "GPS needs another package"),
    ):
        raise ImportError("no module")
