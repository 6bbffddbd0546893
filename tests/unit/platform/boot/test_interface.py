from __future__ import annotations

import sys

import pytest

from rostether.platform.boot.interface import interface_address, interface_addresses


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has this call")
def test_interfaces_and_their_addresses() -> None:
    assert interface_address("lo") == "127.0.0.1"
    assert [interface_address(each) for each in ("away0", "", "a" * 16)] == [None, None, None]
    assert "lo" not in interface_addresses()
