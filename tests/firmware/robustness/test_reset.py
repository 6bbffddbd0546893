"""A board that resets is connected again immediately, with every host."""

from __future__ import annotations

import struct

from firmware.examples.stage import EXAMPLES, running
from firmware.robustness.scripted_host import ScriptedHost
from rostether.firmware.build import build_sketch, find_board
from rostether.rosserial import topic_id

TIME = struct.pack("<II", 1_700_000_000, 0)


async def test_messages_flow_within_two_seconds_with_a_host_that_asks_only_once() -> None:
    # The established host asks again after 15 s; until then it only answers time requests.
    built = await build_sketch(EXAMPLES / "HelloWorld", find_board("uno"))
    host = await ScriptedHost.start(built.elf)
    host.on_frame = lambda each, _payload: host.send(10, TIME) if each == topic_id.TIME else None
    async with host.board:
        host.send(0)
        assert await host.run(3000, lambda: any(each >= 100 for each, _ in host.frames))
        for _ in range(3):
            host.frames.clear()
            await host.board.reset()
            # The sketch publishes once a second, at first before it has a host.
            assert await host.run(1500, lambda: any(each >= 100 for each, _ in host.frames))
            assert any(each == topic_id.PUBLISHER for each, _ in host.frames)


async def test_messages_flow_again_with_our_bridge() -> None:
    async with running("HelloWorld") as stage:
        inbox = await stage.listen("/chatter", "std_msgs/String")
        await inbox.wait_for_count(2)
        for _ in range(2):
            before = await stage.board.cycles()
            received = len(inbox.messages)
            await stage.board.reset()
            await inbox.wait_for_count(received + 1)
            reset_s = (await stage.board.cycles() - before) / 16e6
            # The sketch sleeps for a second; the rest is for a busy machine.
            assert reset_s < 2, reset_s
