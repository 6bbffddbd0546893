"""The Python API without asyncio: the same names, with blocking calls instead of awaitable ones.

with rostether.sync.join("nearest") as graph:
    for message in graph.messages("/ultrasound"):
        print(message.range)
"""

from __future__ import annotations

from rostether.sync.device import Device
from rostether.sync.graph import Graph, join

__all__ = ["Device", "Graph", "join"]
