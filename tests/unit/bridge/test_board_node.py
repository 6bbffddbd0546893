"""What devices.toml says of a board holds for its node and its connections."""

from __future__ import annotations

from rostether.bridge.board_node import BoardNode
from rostether.bridge.settings import BridgeSettings
from rostether.ports.devices_toml import parse_devices_toml
from unit.bridge.nodes import STORE, World


async def test_limits_of_one_board_count_more_than_those_of_all() -> None:
    world = await World().open()
    book = parse_devices_toml(
        '[devices.a]\nport = "/x"\nlimits = { frame_bytes = 100, endpoints = 3, subscriber_bytes = 65536 }'
    )
    settings = BridgeSettings(frame_bytes=1000, queue_bytes=8192)
    node = BoardNode(world.board, STORE, world.reporter, lambda: 0.0, settings, book.devices[0])
    config = node.link_config()
    assert (config.max_payload_bytes, config.max_endpoints) == (100, 3)
    assert (node.settings.subscriber_bytes, node.settings.queue_bytes) == (65536, 8192)
