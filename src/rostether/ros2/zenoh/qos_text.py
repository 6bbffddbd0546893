"""Quality of service as rmw_zenoh writes it into an endpoint's liveliness token.

`reliability:durability:history,depth:deadline_s,ns:lifespan_s,ns:liveliness,lease_s,ns`; what is rmw_zenoh's
default (reliable, volatile, keep last 42, infinite, automatic) is left empty.
"""

from __future__ import annotations

from rostether.ros2.qos import Durability, History, Qos, Reliability

DEFAULT_DEPTH = 42
_TAIL = ":,:,:,,"


def format_qos(qos: Qos) -> str:
    """Return the text; deadline, lifespan and liveliness are the defaults."""
    reliability = "" if qos.reliability is Reliability.RELIABLE else str(int(qos.reliability))
    durability = "" if qos.durability is Durability.VOLATILE else str(int(qos.durability))
    history = "" if qos.history is History.KEEP_LAST else str(int(qos.history))
    depth = "" if qos.depth == DEFAULT_DEPTH else str(qos.depth)
    return f"{reliability}:{durability}:{history},{depth}{_TAIL}"


def parse_qos(text: str) -> Qos:
    """Read the text of a peer; what is missing, unknown or 0 (system default) counts as the default."""
    reliability, durability, history = [*text.split(":"), "", "", ""][:3]
    kind, _, depth = history.partition(",")
    return Qos(
        Reliability.BEST_EFFORT if reliability == "2" else Reliability.RELIABLE,
        Durability.TRANSIENT_LOCAL if durability == "1" else Durability.VOLATILE,
        History.KEEP_ALL if kind == "2" else History.KEEP_LAST,
        int(depth) if depth.isdecimal() and depth.isascii() and len(depth) <= 10 else DEFAULT_DEPTH,
    )
