"""Finds topics that a router's access control denies; zenoh drops such messages without an error.

Two sessions with the configured certificates send probes through the router. The key of a probe is the
topic's key plus one part: access rules treat it like the topic, and no subscriber receives it.
"""

from __future__ import annotations

import asyncio
import json
import logging
import threading
from collections.abc import Iterable, Mapping
from contextlib import ExitStack

import zenoh

from rostether.ros2.zenoh.thread_state import keep_thread_state
from rostether.ros2.zenoh.tokens import Token, TokenKind, all_tokens, data_key, parse_token

# The maximum number of topics to probe; rules usually cover groups of topics.
MAX_TOPICS = 64

# The time limit of probes, which need about 1 s on busy Wi-Fi, and a few seconds on a busy machine.
PROBE_LIMIT_S = 10.0

# The interval between probes: until a subscription is known, they are lost.
_REPEAT_S = 0.2

# A connection over TLS needs several round trips, a list of tokens only one.
_CONNECT_LIMIT_MS = 5000
_LISTING_LIMIT_S = 2.0
_PROBE = "_rostether_access"
_TOPICS = (TokenKind.PUBLISHER, TokenKind.SUBSCRIBER)
_log = logging.getLogger("rostether.ros2")


async def find_denied_topics(
    configuration: zenoh.Config, endpoint: str, domain_id: int, tokens: Iterable[Token] | None = None
) -> list[str] | None:
    """Return the topics that the router at an endpoint denies, sorted, or None if zenoh cannot connect to it.

    Without `tokens`, the topics of the whole graph are checked.
    """
    ended = threading.Event()
    try:
        return await asyncio.to_thread(_find, configuration, endpoint, domain_id, tokens, ended)
    finally:
        # The thread ends early, because the program waits for it when it exits.
        ended.set()


def _find(
    configuration: zenoh.Config,
    endpoint: str,
    domain_id: int,
    tokens: Iterable[Token] | None,
    ended: threading.Event,
) -> list[str] | None:
    keep_thread_state()
    with ExitStack() as stack:
        try:
            sender, receiver = (
                stack.enter_context(zenoh.open(_as_client(configuration, endpoint))) for _ in range(2)
            )
        except zenoh.ZError as error:
            _log.debug("access at %s is not checked: %s", endpoint, error)
            return None
        keys = _keys(_listed(sender, domain_id) if tokens is None else tokens)
        missing = _missing(sender, receiver, keys, ended)
        return sorted({topic for key, topic in keys.items() if key in missing})


def _listed(session: zenoh.Session, domain_id: int) -> Iterable[Token]:
    replies = session.liveliness().get(all_tokens(domain_id), timeout=_LISTING_LIMIT_S)
    texts = [str(reply.ok.key_expr) for reply in replies if reply.ok is not None]
    return [token for token in map(parse_token, texts) if token is not None]


def _keys(tokens: Iterable[Token]) -> dict[str, str]:
    """Return the topics by the keys of their probes."""
    found = {
        f"{data_key(token.domain_id, token.name, token.type, token.type_hash)}/{_PROBE}": token.name
        for token in tokens
        if token.kind in _TOPICS
    }
    return dict(list(found.items())[:MAX_TOPICS])


def _missing(
    sender: zenoh.Session, receiver: zenoh.Session, keys: Mapping[str, str], ended: threading.Event
) -> set[str]:
    """Send probes to each key until all have arrived or the time limit passes; return the missing keys."""
    missing = set(keys)

    def on_sample(sample: zenoh.Sample) -> None:
        keep_thread_state()
        missing.discard(str(sample.key_expr))

    for key in keys:
        receiver.declare_subscriber(key, zenoh.handlers.Callback(on_sample, indirect=False))
    for _ in range(round(PROBE_LIMIT_S / _REPEAT_S)):
        for key in list(missing):
            sender.put(key, b"")
        if ended.wait(_REPEAT_S) or not missing:
            return set()
    return set(missing)


def _as_client(configuration: zenoh.Config, endpoint: str) -> zenoh.Config:
    client = zenoh.Config.from_json5(str(configuration))
    for path, value in (
        ("mode", "client"),
        ("connect/endpoints", [endpoint]),
        ("connect/timeout_ms", _CONNECT_LIMIT_MS),
        ("connect/exit_on_failure", True),
        ("listen/endpoints", []),
        ("access_control/enabled", False),
    ):
        client.insert_json5(path, json.dumps(value))
    return client
