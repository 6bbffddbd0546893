from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rostether.transports import port_holders
from rostether.transports.port_holders import find_port_user


def test_the_use_by_this_program_does_not_count(tmp_path: Path) -> None:
    port = tmp_path / "ttyACM0"
    with port.open("w"):
        assert find_port_user(str(port)) is None


def test_a_program_without_a_lock_is_found(tmp_path: Path) -> None:
    port = tmp_path / "ttyACM0"
    port.touch()
    code = f"import sys; port = open({str(port)!r}); print(flush=True); sys.stdin.read()"
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as program:
        assert program.stdout is not None
        program.stdout.readline()
        assert f"(PID {program.pid})" in (find_port_user(str(port)) or "")
        program.kill()
    assert find_port_user(str(port)) is None


@pytest.mark.parametrize("form", ["{:>10}\n", "{}", "{:>10} minicom root\n"])
def test_a_lock_file_counts_while_its_program_runs(
    form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(port_holders, "LOCK_FOLDERS", (str(tmp_path),))
    lock = tmp_path / "LCK..ttyACM0"
    lock.write_text(form.format(os.getppid()))
    assert f"PID {os.getppid()}" in (find_port_user("/dev/ttyACM0") or "")
    assert find_port_user("/dev/ttyACM1") is None
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    lock.write_text(form.format(ended.pid))
    assert find_port_user("/dev/ttyACM0") is None


@pytest.mark.parametrize("content", [b"", b"rubbish", b"-1", b"99999999999999999999", b"\xff\xff\xff\xff"])
def test_an_invalid_lock_file_is_ignored(
    content: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(port_holders, "LOCK_FOLDERS", (str(tmp_path),))
    (tmp_path / "LCK..ttyACM0").write_bytes(content)
    assert find_port_user("/dev/ttyACM0") is None
