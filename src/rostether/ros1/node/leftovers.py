"""Removes registrations of nodes that ended without unregistering: a ROS 1 master keeps them."""

from __future__ import annotations

from collections import Counter

from rostether.errors import ConfigError, GraphError, UnknownNameError
from rostether.mechanisms.block_end import closed_at_end
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.xmlrpc_client import XmlRpcClient

# A node answers within milliseconds; on a busy single-board computer, within two seconds.
ANSWER_TIMEOUT_S = 3.0

# The failures in a row after which a machine without any answer counts as disconnected; Wi-Fi may pause.
MAX_FAILURES = 3


class Leftovers:
    """Finds and removes the registrations of nodes that have ended, in the name of `caller_id`."""

    def __init__(self, master_uri: str, caller_id: str) -> None:
        self._master_uri = master_uri
        self._caller_id = caller_id
        self._failures: Counter[str] = Counter()

    async def forget_if_gone(self, name: str) -> bool:
        """Remove a node's registrations if it has ended; return whether it has. Raises GraphError."""
        master = MasterClient(self._master_uri, self._caller_id)
        try:
            uri = await master.lookup_node(name)
        except UnknownNameError:
            return False
        finally:
            await master.close()
        if not await self._is_gone(uri):
            return False
        await unregister_node(self._master_uri, name, uri)
        return True

    async def _is_gone(self, uri: str) -> bool:
        try:
            client = XmlRpcClient(uri, timeout_s=ANSWER_TIMEOUT_S)
        except ConfigError:
            return True
        try:
            await client.call_status("getPid", self._caller_id)
        except GraphError as error:
            # A port that refuses connections has no server. Another program on it may not use XML-RPC.
            if isinstance(error.__cause__, ConnectionRefusedError):
                self._failures.pop(uri, None)
                return True
            self._failures[uri] += 1
            return self._failures[uri] >= MAX_FAILURES
        else:
            self._failures.pop(uri, None)
            return False
        finally:
            await client.close()


async def unregister_node(master_uri: str, name: str, uri: str) -> None:
    """Remove all registrations that a node has under a URI. Raises GraphError."""
    # Registrations belong to a node: the master removes them only in its name.
    async with closed_at_end(MasterClient(master_uri, name)) as master:
        publishers, subscribers, services = await master.system_state()
        for topic in (topic for topic, names in publishers.items() if name in names):
            await master.unregister_publisher(topic, uri)
        for topic in (topic for topic, names in subscribers.items() if name in names):
            await master.unregister_subscriber(topic, uri)
        for service in (service for service, names in services.items() if name in names):
            await master.unregister_service(service, await master.lookup_service(service))
