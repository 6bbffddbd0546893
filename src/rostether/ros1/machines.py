"""Finds the hosts of one machine, whose nodes may have URIs with different names and addresses."""

from __future__ import annotations

import socket
from collections.abc import Iterable


def hosts_of_machine(machine: str, hosts: Iterable[str]) -> set[str]:
    """Return the hosts with the name `machine` or one of its addresses. Blocks while names are resolved."""
    wanted = _addresses(machine)
    return {host for host in set(hosts) if host == machine or wanted & _addresses(host)}


def _addresses(host: str) -> set[str]:
    try:
        found = socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)
    except (OSError, UnicodeError):
        return set()
    return {str(sockaddr[0]) for *_, sockaddr in found}
