"""The action of a simulated board, used by Debian's actionlib."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware.examples.stage import STORE, running
from interop.ros1_peers import Ros1Peers

CLIENT = Path(__file__).parents[2] / "interop" / "peers" / "count_by_action.py"


@pytest.mark.ros1
@pytest.mark.timeout(300)
async def test_goals_of_actionlib_are_completed_canceled_replaced_and_refused(tmp_path: Path) -> None:
    text = tmp_path / "FibonacciAction.txt"
    text.write_text(STORE.registry.message_type("actionlib_tutorials/FibonacciAction").definition)
    async with running("ActionServer") as stage:
        peers = Ros1Peers(stage.master_uri, tmp_path)
        try:
            printed = await peers.run("python", str(CLIENT), str(text))
        finally:
            await peers.close()
    succeeded, feedback, canceled, *rest = printed.splitlines()[-6:]
    assert (succeeded, feedback) == ("SUCCEEDED [0, 1, 1, 2]", "feedback [0, 1, 1]")
    # On a busy machine, the board continues to count until the cancel arrives.
    assert canceled.startswith("PREEMPTED [0, 1, 1")
    assert rest == ["PREEMPTED []", "ABORTED []", "order must be 1 to 19"]
