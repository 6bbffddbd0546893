from __future__ import annotations

from typing import Any
from unittest.mock import call, create_autospec

import pytest

from rostether.errors import BoardError
from rostether.simulation.opencr.board import OpenCrBoard
from rostether.simulation.opencr.node_board import OpenCrNodeBoard


@pytest.fixture
def board() -> Any:
    board = create_autospec(OpenCrBoard, instance=True)
    board.pins, board.inputs = {}, {}
    return board


async def test_z_releases_a_button(board: Any) -> None:
    await OpenCrNodeBoard(board).send_command("pin BDPIN_PUSH_SW_1=1 BDPIN_PUSH_SW_2=z")
    assert board.set_pin.mock_calls == [
        call("BDPIN_PUSH_SW_1", high=True),
        call("BDPIN_PUSH_SW_2", high=False),
    ]


async def test_pins_at_rest_and_changed_pins(board: Any) -> None:
    node_board = OpenCrNodeBoard(board)
    at_rest = await node_board.pins()
    assert (at_rest["PUSH_SW_1"], at_rest["LED_USER_1"], at_rest["A0"]) == ("in0", "out1", "in0")
    board.inputs[34], board.pins[22] = True, False
    changed = await node_board.pins()
    assert (changed["PUSH_SW_1"], changed["LED_USER_1"]) == ("in1", "out0")


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("pin BDPIN_PUSH_SW_1", "write the level after each pin"),
        ("pin BDPIN_PUSH_SW_1=2", "write 0 or 1"),
        ("pin BDPIN_PUSH_SW_9=1", "no pin"),
        ("pin", "write values"),
    ],
)
async def test_a_wrong_command_is_refused(board: Any, line: str, problem: str) -> None:
    with pytest.raises(BoardError, match=problem):
        await OpenCrNodeBoard(board).send_command(line)
