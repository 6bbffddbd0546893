"""A web client on Debian's ROS 1: topics and services with Debian's tools."""

from __future__ import annotations

import json
from typing import Any

from websockets.asyncio.client import ClientConnection, connect

from interop.ros1_peers import Ros1Peers
from rostether.cli.access.ros1_access import ros1_join
from rostether.cli.gateway.gateways import ros1_gateway_graph
from rostether.cli.gateway.options import GatewayOptions
from rostether.cli.gateway.rosbridge import rosbridge_gateway
from rostether.msgdef.registry import Registry
from rostether.ros1.environment import RosEnvironment
from rostether.serde.store import TypeStore


class Page:
    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection

    async def send(self, op: str, **fields: Any) -> None:
        await self._connection.send(json.dumps({"op": op, **fields}))

    async def receive(self, op: str) -> dict[str, Any]:
        while True:
            message: dict[str, Any] = json.loads(await self._connection.recv())
            if message["op"] == op:
                return message

    async def call(self, service: str, args: object = None) -> Any:
        await self.send("call_service", service=service, args=args)
        return (await self.receive("service_response"))["values"]


async def test_a_page_and_debians_tools(roscore: Ros1Peers) -> None:
    environment = RosEnvironment.read({"ROS_MASTER_URI": roscore.master_uri})
    on = ros1_gateway_graph(ros1_join(environment), TypeStore(Registry()), environment)
    options = GatewayOptions(rosbridge="127.0.0.1:0")
    async with rosbridge_gateway(options, on, lambda level, text: None) as server:
        assert server is not None
        async with connect(server.uri) as connection:
            page = Page(connection)
            await _topics(page, roscore)
            await _services(page, roscore)


async def _topics(page: Page, debian: Ros1Peers) -> None:
    echo = await debian.start("rostopic", "echo", "-n", "1", "-p", "/from_page")
    await page.send("advertise", topic="/from_page", type="geometry_msgs/Point", latch=True)
    await page.send("publish", topic="/from_page", msg={"x": 1.5})
    assert ",1.5,0.0,0.0" in await echo.finish()
    await page.send("subscribe", topic="/from_debian", type="std_msgs/String")
    await debian.start("rostopic", "pub", "-r", "5", "/from_debian", "std_msgs/String", "hello")
    assert (await page.receive("publish"))["msg"] == {"data": "hello"}
    await page.send("unsubscribe", topic="/from_debian")


async def _services(page: Page, debian: Ros1Peers) -> None:
    # `rostopic pub` has services of rospy, whose types the master does not know.
    nodes = (await page.call("/rosapi/nodes"))["nodes"]
    talker = next(node for node in nodes if node.startswith("/rostopic"))
    loggers = (await page.call(f"{talker}/get_loggers"))["loggers"]
    assert "rosout" in [logger["name"] for logger in loggers]
    assert await page.call(f"{talker}/set_logger_level", ["rosout", "debug"]) == {}
    assert await page.call("/rosapi/service_type", [f"{talker}/get_loggers"]) == {"type": "roscpp/GetLoggers"}

    await page.send("advertise_service", service="/flip", type="std_srvs/SetBool")
    # Operations are handled in order, so the service is offered now.
    await page.call("/rosapi/get_time")
    for answer, printed in [
        ({"values": {"success": True, "message": "on"}, "result": True}, 'message: "on"'),
        ({"values": "no power", "result": False}, "no power"),
    ]:
        call = await debian.start("rosservice", "call", "/flip", "true")
        request = await page.receive("call_service")
        assert request["args"] == {"data": True}
        await page.send("service_response", service="/flip", id=request["id"], **answer)
        assert printed in await call.finish()
