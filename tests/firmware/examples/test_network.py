"""Examples with a simulated network chip, connected to the bridge's TCP listener."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from firmware.examples.stage import EXAMPLES, running
from waiting import until


async def test_tcp_hello_world(kind: str) -> None:
    async with running("TcpHelloWorld", kind, ["watch serial"], uses_network=True) as stage:
        inbox = await stage.listen("/chatter", "std_msgs/String")
        assert [message.data for message in await inbox.next_messages(2)] == ["hello world!"] * 2
        # The serial line is free for the sketch's texts.
        assert stage.board.serial == b"my address is 192.168.0.177\r\n"
        requested = [event["asked"] for event in stage.board.recent if event.name == "network"]
        assert set(requested) == {"192.168.0.11:11411"}


async def test_tcp_blink(kind: str) -> None:
    async with running("TcpBlink", kind, uses_network=True) as stage:
        toggle = await stage.publisher("/toggle_led", "std_msgs/Empty")
        for level in (True, False, True):
            toggle.publish()
            await stage.board.wait_for_pin("D7", level)


def sketch_key() -> str:
    found = re.search(r'#define KEY "(\w+)"', (EXAMPLES / "TcpSharedKey/TcpSharedKey.ino").read_text())
    assert found is not None
    return found[1]


async def test_tcp_shared_key(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "board.key"
    file.write_text(f"{sketch_key()}\n")
    psk = f"&psk={file}"
    async with running("TcpSharedKey", kind, ["watch serial"], uses_network=True, options=psk) as stage:
        inbox = await stage.listen("/chatter", "std_msgs/String")
        assert [message.data for message in await inbox.next_messages(2)] == ["hello, friend"] * 2
        assert stage.board.serial == b""


@pytest.mark.parametrize(
    ("key", "reason"), [("x" * 64, b"the host does not answer"), (None, b"the host needs no key")]
)
async def test_a_different_shared_key_is_explained(key: str | None, reason: bytes, tmp_path: Path) -> None:
    file = tmp_path / "board.key"
    file.write_text(key or "")
    psk = f"&psk={file}" if key else ""
    async with running("TcpSharedKey", "uno", ["watch serial"], uses_network=True, options=psk) as stage:
        await until(lambda: reason in stage.board.serial, "the reason that the sketch prints")
        assert "chatter" not in str(await stage.graph.raw.snapshot())
