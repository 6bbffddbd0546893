"""The settings in the ROS environment variables: the master, the advertised and the listening addresses.

Servers listen on loopback unless ROS_IP or ROS_HOSTNAME names another address: that is the user's consent.
They then also listen on loopback, so that local tools still reach `localhost`. A host name may mean any of
the machine's addresses (Debian maps the machine's own name to 127.0.1.1), so servers listen on all of them.
"""

from __future__ import annotations

import os
import re
import socket
from collections.abc import Iterable, Mapping

from msgspec import Struct
from msgspec.structs import replace

from rostether.errors import ConfigError
from rostether.mechanisms.loopback import LOOPBACK, is_loopback
from rostether.mechanisms.text import show_endpoint
from rostether.names.graph_name import canonical, is_global, is_legal_name, join
from rostether.ros1.admission import ALLOW_ALL, Admission
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits
from rostether.transports.allow_list import check_networks

DEFAULT_MASTER_PORT = 11311
DEFAULT_MASTER_URI = f"http://localhost:{DEFAULT_MASTER_PORT}"
ALL_ADDRESSES = "0.0.0.0"  # noqa: S104

_URI = re.compile(
    r"(?P<scheme>[a-z]+)://(?P<host>\[[^\]\s/]+\]|[^\[\]:/\s@]+):(?P<port>\d{1,5})(?P<path>/\S*)?"
)
_HOST = re.compile(r"[A-Za-z0-9]([A-Za-z0-9._-]*[A-Za-z0-9])?")


class RpcUri(Struct, frozen=True):
    """The parts of `http://host:port/` or `rosrpc://host:port`; an IPv6 host has no brackets."""

    host: str
    port: int
    path: str = "/"

    @property
    def is_loopback(self) -> bool:
        """Whether it names this machine's loopback."""
        return is_loopback(self.host)


def parse_rpc_uri(uri: str, *, scheme: str = "http") -> RpcUri:
    """Parse the URI of a node or master. Raises ConfigError."""
    match = _URI.fullmatch(uri.strip())
    if match is None or match["scheme"] != scheme or not 0 < int(match["port"]) < 65536:
        is_bare = "://" not in uri and _URI.fullmatch(f"{scheme}://{uri.strip()}") is not None
        example = uri.strip() if is_bare else "192.168.1.7:11311"
        raise ConfigError(f"{uri!r:.200} is not a URI; write host and port, such as {scheme}://{example}")
    return RpcUri(match["host"].strip("[]"), int(match["port"]), match["path"] or "/")


def format_uri(host: str, port: int, *, scheme: str = "http") -> str:
    """Return the URI under which a server is advertised; only http URIs end with a slash, as rospy's do."""
    return f"{scheme}://{show_endpoint(host, port)}" + ("/" if scheme == "http" else "")


def connect_host(host: str) -> str:
    """Return the address to connect to for an advertised host; `localhost` needs no resolver."""
    return LOOPBACK if host == "localhost" else host


class RosEnvironment(Struct, frozen=True):
    """The ROS 1 environment, validated.

    `master_uri_is_set` is whether the user chose the master, `advertised_host` the host in registered URIs.
    `listen_hosts` are the addresses of servers, `admission` decides which machines may connect to them, and
    `limits` limits their data. `own_names` are further names of this machine, from the user. `namespace`
    begins with a slash.
    """

    master_uri: str = DEFAULT_MASTER_URI
    master_uri_is_set: bool = False
    advertised_host: str = LOOPBACK
    listen_hosts: tuple[str, ...] = (LOOPBACK,)
    namespace: str = "/"
    admission: Admission = ALLOW_ALL
    limits: GraphLimits = DEFAULT_GRAPH_LIMITS
    own_names: tuple[str, ...] = ()

    @classmethod
    def read(cls, environ: Mapping[str, str] | None = None) -> RosEnvironment:
        """Read the variables, by default those of os.environ. Raises ConfigError with the variable."""
        variables = os.environ if environ is None else environ
        master_uri = variables.get("ROS_MASTER_URI", "").strip()
        if master_uri:
            try:
                parse_rpc_uri(master_uri)
            except ConfigError as error:
                raise ConfigError(f"ROS_MASTER_URI: {error}") from None
        environment = cls(
            master_uri=master_uri or DEFAULT_MASTER_URI,
            master_uri_is_set=bool(master_uri),
            namespace=_read_namespace(variables.get("ROS_NAMESPACE", "")),
        )
        # In rospy and roscpp, ROS_HOSTNAME overrides ROS_IP.
        for variable in ("ROS_HOSTNAME", "ROS_IP"):
            if host := variables.get(variable, "").strip():
                _check_host(variable, host)
                if variable == "ROS_IP" and not (_is_ip_address(host) or is_loopback(host)):
                    raise ConfigError(
                        f"ROS_IP={host!r:.200} is not an IP address; use ROS_HOSTNAME for a host name"
                    )
                advertised = _network_address() if _is_wildcard(host) else host
                return replace(
                    environment,
                    advertised_host=advertised,
                    listen_hosts=_listen_hosts(host),
                    own_names=(host,),
                )
        return environment

    @property
    def master(self) -> RpcUri:
        """The master's host and port."""
        return parse_rpc_uri(self.master_uri)

    @property
    def listens_on_loopback_only(self) -> bool:
        """Whether other machines cannot connect."""
        return all(is_loopback(host) for host in self.listen_hosts)

    def listening_on(self, address: str) -> RosEnvironment:
        """Return this environment with servers on `address` (`--listen`); `0.0.0.0` is every address.

        The advertised host is that of ROS_IP or ROS_HOSTNAME, or else the address, or this machine's address
        in its network. Raises ConfigError.
        """
        _check_host("--listen", address)
        advertised = self.advertised_host
        if is_loopback(advertised):
            advertised = _network_address() if _is_wildcard(address) else address
        return replace(
            self,
            advertised_host=advertised,
            listen_hosts=_listen_hosts(address),
            own_names=(*self.own_names, address),
        )

    def allowing(self, networks: Iterable[str]) -> RosEnvironment:
        """Return this environment with servers for these networks only (`--allow`; none: unchanged).

        Raises ConfigError.
        """
        checked = check_networks(networks, "--allow")
        return replace(self, admission=Admission(checked)) if checked else self

    def limited(self, limits: GraphLimits) -> RosEnvironment:
        """Return this environment with other limits (`--limit`)."""
        return replace(self, limits=limits)

    def with_master(self, uri: str) -> RosEnvironment:
        """Return this environment with another master (`--master`). Raises ConfigError."""
        parse_rpc_uri(uri)
        return replace(self, master_uri=uri, master_uri_is_set=True)


def _is_wildcard(host: str) -> bool:
    return host in (ALL_ADDRESSES, "::")


def _read_namespace(text: str) -> str:
    namespace = canonical(join("/", text.strip()))
    if not (is_global(namespace) and is_legal_name(namespace)):
        raise ConfigError(
            f"ROS_NAMESPACE={text!r:.200} is not a namespace; write one such as robot1 or /lab/robot1"
        )
    return namespace


def _check_host(source: str, host: str) -> None:
    if not (_is_ip_address(host) or _HOST.fullmatch(host)):
        raise ConfigError(
            f"{source}={host!r:.200} is not an address; give an IP address or a host name, without http:// "
            "and port"
        )


def _listen_hosts(host: str) -> tuple[str, ...]:
    if is_loopback(host):
        return (LOOPBACK,) if host == "localhost" else (host,)
    if not _is_ip_address(host):
        return (ALL_ADDRESSES,)
    return (host,) if _is_wildcard(host) else (host, LOOPBACK)


def _is_ip_address(host: str) -> bool:
    try:
        socket.inet_pton(socket.AF_INET6 if ":" in host else socket.AF_INET, host)
    # UnicodeError: an environment variable may contain any bytes.
    except (OSError, UnicodeError):
        return False
    return True


def _network_address() -> str:
    from rostether.transports.own_names import outward_address  # only needed by listeners

    return outward_address() or socket.gethostname()
