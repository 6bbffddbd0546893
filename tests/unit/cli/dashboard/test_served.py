from __future__ import annotations

from rostether.cli.dashboard.served import qr_code


def test_an_address_fits_into_a_narrow_terminal() -> None:
    lines = qr_code("https://192.168.100.100:8765/#token=7f3c9a7f3c9a").splitlines()
    assert len({len(line) for line in lines}) == 1
    assert len(lines[0]) <= 60
    assert len(lines) <= 30
    assert set("".join(lines)) <= set(" \u2588\u2580\u2584")
