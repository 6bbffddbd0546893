from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rostether.cli.firmware import build as build_module
from unit.cli.command_shell import Shell


@pytest.mark.parametrize(
    ("code", "address"),
    [("", "/dev/ttyACM0"), ("nh.getHardware()->setBaud(115200);", "/dev/ttyACM0?baud=115200")],
)
def test_flash_uploads_and_then_serves(
    tmp_path: Path, shell: Shell, monkeypatch: pytest.MonkeyPatch, code: str, address: str
) -> None:
    (tmp_path / "a.ino").write_text(f"void setup() {{ {code} }}\nvoid loop() {{}}\n")
    started: list[list[str]] = []

    async def uploaded(*_: Any) -> str:
        return "/dev/ttyACM0"

    monkeypatch.setattr(build_module, "upload_sketch", uploaded)
    monkeypatch.setattr(build_module, "replace_process", lambda words, _: started.append(words))
    assert address in shell.output("flash", str(tmp_path / "a.ino"))
    assert started[0][-2:] == ["serve", address]
