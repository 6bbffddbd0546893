from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest

from rostether.cli.shell.input_files import MAX_FILE_BYTES, STDIN, read_bytes, read_text
from rostether.errors import ConfigError


def test_a_file_and_standard_input(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "values.yaml"
    file.write_bytes("a: ü\r\n".encode())
    assert read_text(file) == "a: ü\n"
    assert read_bytes(file) == "a: ü\r\n".encode()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"b: 1")))
    assert read_text(STDIN) == "b: 1"


@pytest.mark.parametrize("name", ["", "missing", "latin1"])
def test_what_cannot_be_read_is_one_line(tmp_path: Path, name: str) -> None:
    (tmp_path / "latin1").write_bytes(b"\xff")
    with pytest.raises(ConfigError, match=r"there is no file|not UTF-8"):
        read_text(tmp_path / name)


@pytest.mark.skipif(sys.platform == "win32", reason="has no /dev/zero")
def test_a_file_without_end_is_refused() -> None:
    with pytest.raises(ConfigError, match=f"larger than {MAX_FILE_BYTES >> 20} MiB"):
        read_bytes(Path("/dev/zero"))
