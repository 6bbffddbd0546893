from __future__ import annotations

from http import HTTPStatus

from websockets.datastructures import Headers

from rostether.dashboard.page_files import PAGE, load_page


def test_the_installed_page_is_whole() -> None:
    site = load_page()
    for file in PAGE.rglob("*"):
        if file.is_file():
            path = f"/{file.relative_to(PAGE).as_posix()}"
            assert site.reply("GET", path, Headers()).body == file.read_bytes()
    assert site.reply("GET", "/", Headers()).status == HTTPStatus.OK
