"""A client of a gateway: `python -m benchmarks.gateway_listener PORT TOPICS foxglove|json|cbor-raw SECONDS`.

It subscribes to everything, prints a line when all topics arrive, waits for a line, and prints how many
messages arrived in the seconds after it. It only counts frames: for a slow client, the gateway would omit
messages, and so would use less time.
"""

from __future__ import annotations

import asyncio
import base64
import json
import os
import sys
from collections.abc import Iterator
from typing import Any

_TEXT, _MASKED = 0x81, 0x80
_LENGTH_BYTES = {126: 2, 127: 8}


class Frames:
    """Splits the data of a server into frames."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> Iterator[tuple[int, int, int]]:
        """Yield (opcode byte, start, end) of each complete frame; they are valid until the next call."""
        self._buffer += data
        position, size = 0, len(self._buffer)
        while size - position >= 2:
            length, start = self._buffer[position + 1], position + 2
            if extended := _LENGTH_BYTES.get(length, 0):
                if size < start + extended:
                    break
                length = int.from_bytes(self._buffer[start : start + extended], "big")
                start += extended
            if size < start + length:
                break
            yield self._buffer[position], start, start + length
            position = start + length
        del self._buffer[:position]

    def text(self, start: int, end: int) -> Any:
        """Return the JSON of a frame that was just yielded."""
        return json.loads(self._buffer[start:end])


class Listener(asyncio.Protocol):
    """Subscribes to all advertised topics, or by name, and counts messages."""

    def __init__(self, topics: set[str], kind: str) -> None:
        self.received = 0
        self._missing = topics
        self._kind = kind
        self._frames = Frames()
        self._greeting = b""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Send the handshake."""
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        lines = [
            "GET / HTTP/1.1",
            "Host: 127.0.0.1",
            "Upgrade: websocket",
            "Connection: Upgrade",
            "Sec-WebSocket-Version: 13",
            f"Sec-WebSocket-Key: {base64.b64encode(os.urandom(16)).decode()}",
        ]
        if self._kind == "foxglove":
            lines.append("Sec-WebSocket-Protocol: foxglove.sdk.v1")
        transport.write("\r\n".join([*lines, "", ""]).encode())

    def data_received(self, data: bytes) -> None:
        """Count messages, and subscribe."""
        if b"\r\n\r\n" not in self._greeting:
            self._greeting += data
            head, end, data = self._greeting.partition(b"\r\n\r\n")
            if not end:
                return
            self._greeting = head + end
            if self._kind != "foxglove":
                self._subscribe_rosbridge()
        for opcode, start, end_ in self._frames.feed(data):
            if self._missing and self._kind == "foxglove" and opcode == _TEXT:
                self._subscribe_foxglove(self._frames.text(start, end_))
            else:
                self.received += 1

    def _subscribe_rosbridge(self) -> None:
        compression = "none" if self._kind == "json" else self._kind
        for topic in self._missing:
            self._say({"op": "subscribe", "topic": topic, "compression": compression})

    def _subscribe_foxglove(self, message: dict[str, Any]) -> None:
        for channel in message.get("channels", ()):
            if channel["topic"] in self._missing:
                self._missing.discard(channel["topic"])
                wanted = [{"id": channel["id"], "channelId": channel["id"]}]
                self._say({"op": "subscribe", "subscriptions": wanted})

    def _say(self, message: dict[str, Any]) -> None:
        text = json.dumps(message).encode()
        # A mask of zeros does not change the text; 126: the length follows in two bytes.
        header = bytes((_TEXT, _MASKED | 126)) + len(text).to_bytes(2, "big") + bytes(4)
        self._transport.write(header + text)


async def main(port: int, count: int, kind: str, seconds: float) -> None:
    """Listen and count."""
    loop = asyncio.get_running_loop()
    listener = Listener({f"/imu_{number}" for number in range(count)}, kind)
    transport, _ = await loop.create_connection(lambda: listener, "127.0.0.1", port)
    while listener.received < 10 * count:
        await asyncio.sleep(0.05)
    print("ready", flush=True)
    await loop.run_in_executor(None, sys.stdin.readline)
    before = listener.received
    await asyncio.sleep(seconds)
    print(listener.received - before, flush=True)
    transport.abort()


if __name__ == "__main__":
    asyncio.run(main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3], float(sys.argv[4])))
