"""Examples without a cable: over the simulated network chip to the bridge's TCP listener."""

from __future__ import annotations

from firmware.examples.stage import running


async def test_tcp_hello_world(kind: str) -> None:
    async with running("TcpHelloWorld", kind, ["watch serial"], uses_network=True) as stage:
        heard = await stage.listen("/chatter", "std_msgs/String")
        assert [message.data for message in await heard.several(2)] == ["hello world!"] * 2
        # The cable is free for the sketch's own words.
        assert stage.board.serial == b"my address is 192.168.0.177\r\n"
        asked = [event["asked"] for event in stage.board.recent if event.name == "network"]
        assert set(asked) == {"192.168.0.11:11411"}


async def test_tcp_blink(kind: str) -> None:
    async with running("TcpBlink", kind, uses_network=True) as stage:
        toggle = await stage.publisher("/toggle_led", "std_msgs/Empty")
        for level in (True, False, True):
            toggle.publish()
            await stage.board.wait_for_pin("D7", level)
