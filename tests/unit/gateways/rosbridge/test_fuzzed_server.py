"""After any input over real sockets, the server still serves other pages."""

from __future__ import annotations

import asyncio
import itertools
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[4]))

from fuzz import targets
from unit.gateways.rosbridge.web_client import TIMEOUT_S, world

CLIENTS = 20
TALKS_OF_ONE = 20


async def test_a_flood_of_nonsense_leaves_the_server_up() -> None:
    talks = targets.load("rosbridge").inputs(seed=11)
    async with world() as there, there.client() as sensible:
        await sensible.say("subscribe", topic="/chatter", type="std_msgs/String")
        publisher = await there.graph.publisher("/chatter", "std_msgs/String")
        for number in range(CLIENTS):
            async with there.client() as client:
                lines = b"\n".join(itertools.islice(talks, TALKS_OF_ONE)).split(b"\n")
                for line in lines:
                    # Every other client sends its lines as binary messages.
                    await client.connection.send(line if number % 2 else line.decode("utf-8", "replace"))
                await client.say("call_service", service="/rosapi/none", id="the last")
                async with asyncio.timeout(TIMEOUT_S):
                    while b'"the last"' not in await client.connection.recv(decode=False):
                        pass
        await sensible.settled()
        publisher.publish(data="still here")
        while (received := await sensible.receive()).get("msg") != {"data": "still here"}:
            assert received["op"] in ("publish", "status")
        assert len(there.warnings) > CLIENTS
        assert not [line for line in there.warnings if "Error: " in line and "JSON" not in line]
