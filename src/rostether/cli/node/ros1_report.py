"""The output of `rosnode info`, as text and as a record for scripts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from msgspec.structs import asdict

from rostether.msgdef.interface import ANY_TYPE
from rostether.ros1.node.node_calls import Connection, Registrations

_RULE = "-" * 80


def format_registrations(name: str, registered: Registrations) -> str:
    """Return the part that the master knows."""
    sections = (
        ("Publications", _typed(registered.publications)),
        ("Subscriptions", _typed(registered.subscriptions)),
        ("Services", registered.services),
    )
    return f"{_RULE}\nNode [{name}]\n" + "\n".join(_section(title, lines) for title, lines in sections)


def format_connections(pid: int, connected: Iterable[Connection]) -> str:
    """Return the part that the node itself reported."""
    lines = [f"Pid: {pid}"]
    for index, each in enumerate(connected):
        if not index:
            lines.append("Connections:")
        peer = f"{each.peer} ({each.peer_uri})" if each.peer_uri else each.peer
        sockets = " ({} - {}) [{}]".format(*each.sockets) if each.sockets else ""
        lines += [
            f" * topic: {each.topic}",
            f"    * to: {peer}",
            f"    * direction: {each.direction}{sockets}",
            f"    * transport: {each.transport}",
        ]
    return "\n".join(lines) + "\n"


def to_record(
    name: str,
    uri: str,
    registered: Registrations,
    pid: int | None = None,
    connected: Iterable[Connection] = (),
) -> dict[str, Any]:
    """Return the record for `--json`; `pid` is null when the node was not asked."""
    return {
        "node": name,
        "uri": uri,
        "pid": pid,
        "publications": _records(registered.publications),
        "subscriptions": _records(registered.subscriptions),
        "services": registered.services,
        "connections": [_connection_record(each) for each in connected],
    }


def _connection_record(connection: Connection) -> dict[str, Any]:
    record = asdict(connection)
    port, remote, descriptor = record.pop("sockets") or (None, None, None)
    return {
        **record,
        "local_port": int(port) if port else None,
        "remote_address": remote,
        "descriptor": int(descriptor) if descriptor else None,
    }


def _records(topics: dict[str, str]) -> list[dict[str, str | None]]:
    return [
        {"topic": topic, "type": None if type_name == ANY_TYPE else type_name}
        for topic, type_name in topics.items()
    ]


def _typed(topics: dict[str, str]) -> list[str]:
    return [
        f"{topic} [{'unknown type' if type_name == ANY_TYPE else type_name}]"
        for topic, type_name in topics.items()
    ]


def _section(title: str, lines: list[str]) -> str:
    if not lines:
        return f"{title}: None\n"
    return f"{title}: \n" + "".join(f" * {line}\n" for line in lines)
