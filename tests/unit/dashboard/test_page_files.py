from __future__ import annotations

from http import HTTPStatus
from pathlib import Path

import pytest
from websockets.datastructures import Headers

from rostether.dashboard.page_files import PAGE, load_page
from rostether.errors import ConfigError


def test_the_installed_page_is_whole() -> None:
    site = load_page({})
    for file in PAGE.rglob("*"):
        if file.is_file():
            path = f"/{file.relative_to(PAGE).as_posix()}"
            assert site.reply("GET", path, Headers()).body == file.read_bytes()
    assert site.reply("GET", "/", Headers()).status_code == HTTPStatus.OK


def test_a_page_without_an_index_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.dashboard.page_files.PAGE", tmp_path)
    (tmp_path / "app.js").write_bytes(b"x")
    with pytest.raises(ConfigError, match=r"index\.html is missing; install rostether again"):
        load_page({"certificate.html": b"x"})
