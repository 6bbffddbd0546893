from __future__ import annotations

import json

import pytest

from contract.graphs import STRING, Inbox
from contract.zenoh_graphs import open_session, ros2_types
from interop.ros1_peers import free_port
from rostether.ros2.environment import Ros2Environment
from rostether.ros2.zenoh import access_check
from rostether.ros2.zenoh import session as session_module
from rostether.ros2.zenoh.access_check import find_denied_topics
from rostether.ros2.zenoh.configuration import peer_configuration
from rostether.ros2.zenoh.session import ZenohSession
from rostether.ros2.zenoh_reach import RouterChoice, ZenohReach
from waiting import until

RULES = {
    "enabled": True,
    "default_permission": "allow",
    "rules": [
        {
            "id": "orders",
            "permission": "deny",
            "flows": ["ingress"],
            "messages": ["put"],
            "key_exprs": ["*/**/cmd_vel/**"],
        }
    ],
    "subjects": [{"id": "all"}],
    "policies": [{"rules": ["orders"], "subjects": ["all"]}],
}


async def test_topics_that_a_router_denies_are_reported(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(session_module, "ACCESS_CHECK_AFTER_S", 0.2)
    monkeypatch.setattr(access_check, "PROBE_LIMIT_S", 4.0)
    port = free_port()
    endpoint = f"tcp/127.0.0.1:{port}"
    router = await ZenohSession.open(
        Ros2Environment(
            zenoh_overrides=(
                ("listen/endpoints", json.dumps([endpoint])),
                ("access_control", json.dumps(RULES)),
            )
        ),
        ros2_types(),
        reach=ZenohReach(RouterChoice.ALWAYS),
    )
    robot = await router.join("robot")
    await robot.subscribe("/robot1/cmd_vel", STRING, Inbox().store)
    visitor = await open_session(port, is_router=False)
    node = await visitor.join("visitor")
    await node.advertise("/robot1/cmd_vel", STRING)
    await node.subscribe("/chat", STRING, Inbox().store)
    await until(lambda: "access denied" in caplog.text)
    assert f"the router at {endpoint} does not forward /robot1/cmd_vel for this program" in caplog.text

    configuration = peer_configuration(Ros2Environment(), ZenohReach())
    # For the whole graph, as in `doctor`.
    denied = await find_denied_topics(configuration, endpoint, 0)
    assert denied is not None
    assert "/robot1/cmd_vel" in denied
    monkeypatch.setattr(access_check, "PROBE_LIMIT_S", 60.0)
    others = [end for _, end in visitor.graph.all_endpoints() if end.name != "/robot1/cmd_vel"]
    assert others
    assert await find_denied_topics(configuration, endpoint, 0, others) == []
    await visitor.close()
    await router.close()
