from __future__ import annotations

import asyncio

import pytest

from rostether.errors import ServiceCallError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.nodes.message_info import serve_message_info
from rostether.serde.store import TypeStore
from waiting import until


async def test_it_returns_md5sums_and_definitions() -> None:
    network, registry = MemoryNetwork(), Registry()
    node, asking = [
        TypedGraph(await network.join(name), TypeStore(registry)) for name in ("/info", "/asking")
    ]
    serving = asyncio.ensure_future(serve_message_info(node, registry))
    try:
        await until(lambda: "/service_info" in network.snapshot().services)
        kind = "rosserial_msgs/RequestMessageInfo"
        answer = await asking.call("/message_info", kind, {"type": "std_msgs/Bool"}, timeout_s=60)
        assert (answer.md5, answer.definition.strip()) == ("8b94c1b53db61fb6aed406028ad6332a", "bool data")
        with pytest.raises(ServiceCallError, match="no_msgs/X"):
            await asking.call("/message_info", kind, {"type": "no_msgs/X"}, timeout_s=60)
        service = {"service": "std_srvs/Trigger"}
        answer = await asking.call(
            "/service_info", "rosserial_msgs/RequestServiceInfo", service, timeout_s=60
        )
        assert answer.service_md5 == answer.response_md5 == "937c9679a518e3a18d831e57125ea522"
        assert answer.request_md5 == "d41d8cd98f00b204e9800998ecf8427e"
    finally:
        serving.cancel()
        await asyncio.wait([serving])
