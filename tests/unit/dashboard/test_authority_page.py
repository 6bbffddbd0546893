from __future__ import annotations

from pathlib import Path

from rostether.dashboard.authority_page import AUTHORITY_FILE, TRUST_PAGE_FILE, authority_files


def test_the_certificate_and_how_to_install_it(tmp_path: Path) -> None:
    authority = tmp_path / "authority.pem"
    authority.write_bytes(b"certificate")
    files = authority_files(authority, "<robot>")
    assert files[AUTHORITY_FILE] == b"certificate"
    page = files[TRUST_PAGE_FILE].decode()
    assert "Trust &lt;robot&gt;" in page
    assert f'href="/{AUTHORITY_FILE}"' in page
