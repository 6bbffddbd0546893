"""rostether's services and clients with those of rospy, roscpp and rosservice, with rostether's master and
with roscore.
"""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from contract.graphs import EMPTY, SET_BOOL, string
from interop.node_stage import ON_BOTH_MASTERS, Stage, stage_on
from rostether.errors import ServiceCallError, SessionError, TypeMismatchError
from rostether.ros1.node.node import Ros1Graph

CALL = """
import sys, rospy
from std_srvs.srv import SetBool
rospy.init_node("py_client", anonymous=True)
rospy.wait_for_service(sys.argv[1], 60)
proxy = rospy.ServiceProxy(sys.argv[1], SetBool, persistent=sys.argv[2] == "persistent")
for value in (True, False, True):
    try:
        answer = proxy(value)
        print(answer.success, answer.message, flush=True)
    except rospy.ServiceException as error:
        print("error:", error, flush=True)
"""

SERVE = """
import sys, rospy
from std_srvs.srv import SetBool
rospy.init_node("py_server")
def handle(request):
    if not request.data:
        raise rospy.ServiceException("only on")
    return True, "on it"
rospy.Service(sys.argv[1], SetBool, handle)
print("serving", flush=True)
rospy.spin()
"""


@pytest_asyncio.fixture
async def stage(request: pytest.FixtureRequest, tmp_path: Path) -> AsyncIterator[Stage]:
    async with stage_on(getattr(request, "param", "rostether's master"), tmp_path) as stage:
        yield stage


async def switch(request: bytes) -> bytes:
    """Handle std_srvs/SetBool; `false` is refused."""
    if request != b"\x01":
        raise SessionError("it cannot be switched off")
    return b"\x01" + string("on it")


async def serve_switch(stage: Stage) -> Ros1Graph:
    node = await stage.join("/server")
    await node.advertise_service("/switch", SET_BOOL, switch)
    return node


@ON_BOTH_MASTERS
async def test_service_server_to_rosservice(stage: Stage) -> None:
    await serve_switch(stage)
    answer = await stage.peers.run("rosservice", "call", "/switch", "true")
    assert answer.splitlines() == ["success: True", 'message: "on it"']
    refusal = await stage.peers.run("rosservice", "call", "/switch", "false", check=False)
    assert "it cannot be switched off" in refusal
    assert await stage.peers.run("rosservice", "type", "/switch") == "std_srvs/SetBool"
    info = await stage.peers.run("rosservice", "info", "/switch")
    assert "Node: /server" in info
    assert "Args: data" in info
    assert "/switch" in (await stage.peers.run("rosservice", "find", "std_srvs/SetBool")).splitlines()


@ON_BOTH_MASTERS
async def test_service_server_to_rospy_client(stage: Stage) -> None:
    await serve_switch(stage)
    for peer in [await stage.peers.rospy(CALL, "/switch", kind) for kind in ("persistent", "single")]:
        first, second, third = (await peer.finish()).splitlines()
        assert first == third == "True on it"
        assert "it cannot be switched off" in second


@ON_BOTH_MASTERS
@pytest.mark.roscpp
async def test_service_server_to_roscpp_client(stage: Stage) -> None:
    await serve_switch(stage)
    # More than one call makes its connection persistent.
    for count in (1, 50):
        peer = await stage.peers.roscpp("call", "/switch", "true", str(count))
        assert (await peer.finish()).splitlines() == ["1 on it"] * count


@ON_BOTH_MASTERS
async def test_service_client_to_rospy_server(stage: Stage) -> None:
    node = await stage.join("/client")
    await stage.peers.rospy(SERVE, "/switch")
    for persistent in (True, False):
        client = node.service_client("/switch", SET_BOOL, persistent=persistent)
        await client.wait_until_available(60.0)
        for _ in range(3):
            assert await client.call(b"\x01", timeout_s=60) == b"\x01" + string("on it")
            with pytest.raises(ServiceCallError, match="only on"):
                await client.call(b"\x00", timeout_s=60)
        await client.close()
    with pytest.raises(TypeMismatchError, match="md5sums do not match"):
        await node.call_service("/switch", EMPTY, b"")


@ON_BOTH_MASTERS
@pytest.mark.roscpp
async def test_service_client_to_roscpp_server(stage: Stage) -> None:
    node = await stage.join("/client")
    await stage.peers.roscpp("serve", "/switch")
    for persistent in (True, False):
        client = node.service_client("/switch", SET_BOOL, persistent=persistent)
        await client.wait_until_available(60.0)
        for _ in range(20):
            assert await client.call(b"\x01", timeout_s=60) == b"\x01" + string("on")
            assert await client.call(b"\x00", timeout_s=60) == b"\x00" + string("off")
        await client.close()
    with pytest.raises(TypeMismatchError):
        await node.call_service("/switch", EMPTY, b"")
