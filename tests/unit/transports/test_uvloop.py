"""uvloop's transports begin to read at another time than asyncio's, and their errors have other texts."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Any

import pytest

from unit.transports import test_tcp, test_udp

uvloop = pytest.importorskip("uvloop")


@pytest.mark.parametrize(
    "scenario",
    [
        test_tcp.test_carry_bytes_both_ways,
        test_tcp.test_keep_what_came_before_start,
        test_tcp.test_pausing_stops_the_sender_and_loses_nothing,
        test_tcp.test_reports_when_the_board_disconnects,
        test_tcp.test_the_error_about_a_port_in_use_names_the_port_and_the_next_step,
        test_udp.test_each_peer_has_a_separate_transport,
        test_udp.test_send_from_the_port_a_board_expects,
        test_udp.test_the_error_about_a_port_in_use_names_the_port,
    ],
)
def test_the_same_under_uvloop(scenario: Callable[[], Coroutine[Any, Any, None]]) -> None:
    uvloop.run(scenario())
