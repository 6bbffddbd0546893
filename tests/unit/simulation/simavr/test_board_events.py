from __future__ import annotations

import pytest

from rostether.errors import BoardError
from rostether.simulation.simavr.board_events import BoardEvent, parse_event, show_event


def test_an_event_as_the_runner_prints_it() -> None:
    event = parse_event(b'{"event":"pin","time_us":1500000.0625,"pin":"D13","level":1}\n')
    assert (event.name, event.time_s, event["pin"], event["level"]) == ("pin", 1.5000000625, "D13", 1)


@pytest.mark.parametrize("line", [b"", b"hello\n", b"{}\n", b"[1]\n", b'{"event":"x"}\n', b"\xff\n"])
def test_other_lines_are_refused(line: bytes) -> None:
    with pytest.raises(BoardError, match="an unknown line"):
        parse_event(line)


@pytest.mark.parametrize(
    ("event", "line"),
    [
        (BoardEvent("pin", 1.5, {"pin": "D13", "level": 1}), "    1.500000  pin D13 level=1"),
        (
            BoardEvent("servo", 0.02, {"pin": "D9", "angle_deg": 90.07}),
            "    0.020000  servo D9 angle_deg=90.07",
        ),
        (BoardEvent("power", 2.0, {"on": False}), "    2.000000  power on=no"),
        (BoardEvent("serial", 1.0, {"data": "4869210d0a"}), '    1.000000  serial data="Hi!\\r\\n"'),
        (BoardEvent("serial", 1.0, {"data": "fffe0800"}), "    1.000000  serial data=fffe0800"),
        (BoardEvent("serial", 1.0, {"data": "0000"}), "    1.000000  serial data=0000"),
        (BoardEvent("asleep", 3.0, {"text": "it sleeps"}), "    3.000000  asleep: it sleeps"),
        # The answer of the command `stack` is no warning.
        (BoardEvent("stack", 3.0, {"free_bytes": 900}), "    3.000000  stack free_bytes=900"),
        (
            BoardEvent("stack_overflow", 3.0, {"free_bytes": 0}),
            "    3.000000  stack overflow free_bytes=0: the stack overwrote variables: the program needs"
            " more RAM than the board has",
        ),
    ],
)
def test_an_event_as_text(event: BoardEvent, line: str) -> None:
    assert show_event(event) == line
