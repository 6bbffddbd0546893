from __future__ import annotations

import json

from interop_web.web_peers import WebPeers


async def test_the_web_libraries_are_installed(web_peers: WebPeers) -> None:
    assert json.loads(await web_peers.run("versions.mjs")) == {
        "foxglove": "foxglove.websocket.v1",
        "roslib1": "1.4.1",
        "roslib2": "function",
        "ws": "function",
    }
