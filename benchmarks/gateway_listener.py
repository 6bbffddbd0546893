"""A client of a gateway: `python -m benchmarks.gateway_listener PORT TOPICS foxglove|json|cbor-raw SECONDS`.

It subscribes everything, prints a line when all has begun to come, waits for a line, and prints how many
messages came in the seconds after it.
"""

from __future__ import annotations

import asyncio
import json
import sys

from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Subprotocol


async def subscribe_foxglove(connection: ClientConnection, topics: set[str]) -> None:
    """Subscribe the topics, as soon as they are offered."""
    missing = set(topics)
    while missing:
        text = await connection.recv()
        message = json.loads(text) if isinstance(text, str) else {}
        for channel in message.get("channels", ()):
            if channel["topic"] in missing:
                missing.discard(channel["topic"])
                wanted = [{"id": channel["id"], "channelId": channel["id"]}]
                await connection.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))


async def subscribe_rosbridge(connection: ClientConnection, topics: set[str], compression: str) -> None:
    """Subscribe the topics."""
    for topic in topics:
        fields = {"op": "subscribe", "topic": topic, "compression": compression}
        await connection.send(json.dumps(fields))


async def main(port: str, count: int, kind: str, seconds: float) -> None:
    """Listen and count."""
    topics = {f"/imu_{number}" for number in range(count)}
    protocols = [Subprotocol("foxglove.sdk.v1")] if kind == "foxglove" else None
    async with connect(
        f"ws://127.0.0.1:{port}", subprotocols=protocols, proxy=None, compression=None, max_size=None
    ) as connection:
        if kind == "foxglove":
            await subscribe_foxglove(connection, topics)
        else:
            await subscribe_rosbridge(connection, topics, "none" if kind == "json" else kind)
        received = 0

        async def listen() -> None:
            nonlocal received
            async for _ in connection:
                received += 1

        listening = asyncio.ensure_future(listen())
        while received < 10 * count:
            await asyncio.sleep(0.05)
        print("ready", flush=True)
        await asyncio.get_running_loop().run_in_executor(None, sys.stdin.readline)
        before = received
        await asyncio.sleep(seconds)
        print(received - before, flush=True)
        listening.cancel()


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], int(sys.argv[2]), sys.argv[3], float(sys.argv[4])))
