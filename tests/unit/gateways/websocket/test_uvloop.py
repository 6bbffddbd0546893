"""uvloop's transports differ from asyncio's: a client's first bytes may arrive before TLS starts."""

from __future__ import annotations

from pathlib import Path

import pytest

from unit.gateways.websocket import test_connection, test_plain_get

uvloop = pytest.importorskip("uvloop")


def test_pages_and_clients_are_served_under_uvloop() -> None:
    uvloop.run(test_plain_get.test_the_page_is_served_on_the_gateway_s_port())


def test_encrypted_clients_connect_under_uvloop(tmp_path: Path) -> None:
    uvloop.run(test_connection.test_encrypted_clients_are_served_at_once(tmp_path))


def test_plain_http_on_an_encrypted_port_under_uvloop(tmp_path: Path) -> None:
    uvloop.run(test_connection.test_plain_http_on_an_encrypted_port_gets_the_hint_to_use_https(tmp_path))
