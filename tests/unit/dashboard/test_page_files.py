from __future__ import annotations

from http import HTTPStatus
from pathlib import Path

import pytest
from websockets.datastructures import Headers

from rostether.dashboard.page_files import AUTHORITY_FILE, PAGE, TRUST_PAGE_FILE, authority_files, load_page
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


def test_the_certificate_and_how_to_install_it(tmp_path: Path) -> None:
    authority = tmp_path / "authority.pem"
    authority.write_bytes(b"certificate")
    files = authority_files(authority, "<robot>")
    assert files[AUTHORITY_FILE] == b"certificate"
    page = files[TRUST_PAGE_FILE].decode()
    assert "Trust &lt;robot&gt;" in page
    assert f'href="/{AUTHORITY_FILE}"' in page
