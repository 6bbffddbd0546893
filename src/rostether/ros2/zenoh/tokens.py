"""Liveliness tokens, which announce the nodes, topics and services of a graph over zenoh.

    @ros2_lv/<domain>/<session>/<node id>/<node id>/NN/<enclave>/<namespace>/<node>
    @ros2_lv/<domain>/<session>/<node id>/<id>/MP|MS|SS|SC/<enclave>/<ns>/<node>/<name>/<type>/<hash>/<qos>

Names are mangled: `/` is written as `%`. Newer distributions append one more part (backends); it is ignored.
Source: the design document of rmw_zenoh.
"""

from __future__ import annotations

from enum import Enum

from msgspec import Struct

from rostether.names.graph_name import join
from rostether.ros2.zenoh.qos import DEFAULT_QOS, Durability, History, Qos, Reliability

# rmw_zenoh's default depth, which tokens omit.
DEFAULT_DEPTH = 42
# The last part of the quality of service in a token: default deadline, lifespan and liveliness.
_TAIL = ":,:,:,,"

ADMIN_SPACE = "@ros2_lv"
_NODE_PARTS = 9
_ENDPOINT_PARTS = 13
# Eight times the longest ROS 2 name; a longer token is not from a node, and would only use memory.
MAX_TOKEN_CHARACTERS = 4096


class TokenKind(Enum):
    """The kind of entity that a token announces."""

    NODE = "NN"
    PUBLISHER = "MP"
    SUBSCRIBER = "MS"
    SERVER = "SS"
    CLIENT = "SC"


_KINDS = {kind.value: kind for kind in TokenKind}


class Token(Struct, frozen=True):
    """One token; `name`, `type` (`std_msgs::msg::dds_::String_`), `type_hash` and `qos` are an endpoint's."""

    domain_id: int
    session_id: str
    node_id: int
    entity_id: int
    kind: TokenKind
    node_namespace: str
    node_base_name: str
    name: str = ""
    type: str = ""
    type_hash: str = ""
    qos: Qos = DEFAULT_QOS
    enclave: str = ""

    @property
    def node_name(self) -> str:
        """The fully qualified name of its node."""
        return join(self.node_namespace, self.node_base_name)

    def format(self) -> str:
        """Return the key expression."""
        parts = [
            ADMIN_SPACE,
            str(self.domain_id),
            self.session_id,
            str(self.node_id),
            str(self.entity_id),
            self.kind.value,
            mangle(self.enclave) or "%",
            mangle(self.node_namespace),
            self.node_base_name,
        ]
        if self.kind is not TokenKind.NODE:
            parts += [mangle(self.name), self.type, self.type_hash, format_qos(self.qos)]
        return "/".join(parts)


def parse_token(text: str) -> Token | None:
    """Read a peer's token; None if it is not from ROS 2."""
    if len(text) > MAX_TOKEN_CHARACTERS:
        return None
    parts = text.split("/")
    if len(parts) < _NODE_PARTS or parts[0] != ADMIN_SPACE:
        return None
    kind = _KINDS.get(parts[5])
    if kind is None or not all(_is_number(parts[index]) for index in (1, 3, 4)):
        return None
    node = (
        int(parts[1]),
        parts[2],
        int(parts[3]),
        int(parts[4]),
        kind,
        demangle(parts[7]) or "/",
        demangle(parts[8]).removeprefix("/"),
    )
    enclave = "" if parts[6] == "%" else demangle(parts[6])
    if kind is TokenKind.NODE:
        return Token(*node, enclave=enclave)
    if len(parts) < _ENDPOINT_PARTS:
        return None
    name = demangle(parts[9])
    return Token(
        *node,
        name if name.startswith("/") else f"/{name}",
        parts[10],
        parts[11],
        parse_qos(parts[12]),
        enclave,
    )


def all_tokens(domain_id: int) -> str:
    """Return the key expression of every token of a domain."""
    return f"{ADMIN_SPACE}/{domain_id}/**"


def data_key(domain_id: int, name: str, dds_type: str, type_hash: str) -> str:
    """Return the key expression of a topic's samples or of a service's queries."""
    return f"{domain_id}/{name.removeprefix('/')}/{dds_type}/{type_hash}"


def mangle(name: str) -> str:
    """Return the name as one part of a key."""
    return name.replace("/", "%")


def demangle(part: str) -> str:
    """Return the name of a part of a key."""
    return part.replace("%", "/")


def _is_number(text: str) -> bool:
    # A limit, because int() is slow for very long digits.
    return len(text) <= 20 and text.isascii() and text.isdecimal()


def format_qos(qos: Qos) -> str:
    """Return the quality of service as in a token, with default deadline, lifespan and liveliness."""
    reliability = "" if qos.reliability is Reliability.RELIABLE else str(int(qos.reliability))
    durability = "" if qos.durability is Durability.VOLATILE else str(int(qos.durability))
    history = "" if qos.history is History.KEEP_LAST else str(int(qos.history))
    depth = "" if qos.depth == DEFAULT_DEPTH else str(qos.depth)
    return f"{reliability}:{durability}:{history},{depth}{_TAIL}"


def parse_qos(text: str) -> Qos:
    """Read a peer's quality of service; missing, unknown and 0 (system default) values become the default."""
    reliability, durability, history = [*text.split(":"), "", "", ""][:3]
    kind, _, depth = history.partition(",")
    return Qos(
        Reliability.BEST_EFFORT if reliability == "2" else Reliability.RELIABLE,
        Durability.TRANSIENT_LOCAL if durability == "1" else Durability.VOLATILE,
        History.KEEP_ALL if kind == "2" else History.KEEP_LAST,
        int(depth) if depth.isdecimal() and depth.isascii() and len(depth) <= 10 else DEFAULT_DEPTH,
    )
