"""Link addresses as values: the kind of a link, its endpoint and its options; `address_parser` reads them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from msgspec import Struct

from rostether.mechanisms.text import show_endpoint

# The baud rate of rosserial_arduino.
DEFAULT_BAUD = 57600

# The port to which boards with rosserial_arduino connect over TCP.
DEFAULT_PORT = 11411


class _NamedAddress(Struct, frozen=True, kw_only=True):
    name: str | None = None
    ns: str | None = None

    @property
    def listens(self) -> bool:
        """Whether one address accepts many devices (see `opening.listen`)."""
        return False


class _EndpointAddress(_NamedAddress, frozen=True):
    host: str
    port: int
    connect: bool = False

    @property
    def listens(self) -> bool:
        return not self.connect


class _SharedAddress(_NamedAddress, frozen=True):
    @property
    def listens(self) -> bool:
        return True


class ProgramSize(Struct, frozen=True):
    """The memory use of a board's program; a limit is 0 if it is unknown."""

    flash_bytes: int
    flash_limit_bytes: int
    ram_bytes: int
    ram_limit_bytes: int


class SimulationPauses:
    """Has a callback for the pauses of a simulated board that this machine cannot run in real time."""

    def __init__(self) -> None:
        self.on_pause: Callable[[], None] = lambda: None


class SerialAddress(_NamedAddress, frozen=True):
    """A serial port or a pseudo-terminal's slave; `reset=False` leaves DTR and RTS alone.

    `given` are the names of the options in the address, which override devices.toml. `program` is set if the
    board is known to run it, `pauses` if the board is simulated.
    """

    path: str
    baud: int = DEFAULT_BAUD
    reset: bool = True
    given: tuple[str, ...] = ()
    program: ProgramSize | None = None
    pauses: SimulationPauses | None = None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, SerialAddress) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple[object, ...]:
        return self.name, self.ns, self.path, self.baud, self.reset

    def __str__(self) -> str:
        return self.path


class TlsFiles(Struct, frozen=True):
    """PEM files: a certificate, its key (None: in the same file), and the authority of the peer.

    A listener needs a certificate; with `ca`, it accepts only boards that have one too. A connector checks
    the listener's certificate with `ca`, or else with the system's authorities.
    """

    cert: str | None = None
    key: str | None = None
    ca: str | None = None


class TcpAddress(_EndpointAddress, frozen=True):
    """A TCP port to listen on, or with `connect` one to connect to; `allow` are networks, empty is all.

    `psk` is the file of a key that the peer must have; with `tls`, the link is encrypted.
    """

    allow: tuple[str, ...] = ()
    psk: str | None = None
    tls: TlsFiles | None = None

    def __str__(self) -> str:
        return f"{'tcp' if self.tls is None else 'tls'}://{show_endpoint(self.host, self.port)}"


class UdpAddress(_EndpointAddress, frozen=True):
    """A UDP port to listen on, or with `connect` one peer; `bind` is then the local port, 0 means any."""

    bind: int = 0
    allow: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"udp://{show_endpoint(self.host, self.port)}"


class PtyAddress(_NamedAddress, frozen=True):
    """A pseudo-terminal to create, with a symbolic link at `link`."""

    link: str

    def __str__(self) -> str:
        return f"pty:{self.link}"


class XbeeAddress(_SharedAddress, frozen=True):
    """An XBee radio's serial port; `peers` are addresses of boards that are served before they send."""

    path: str
    baud: int = DEFAULT_BAUD
    peers: tuple[int, ...] = ()

    def __str__(self) -> str:
        return f"xbee:{self.path}"


class SimAddress(_NamedAddress, frozen=True):
    """A sketch or ELF file to run on a simulated board; `commands` are the board's first commands."""

    program: str
    board: str = "uno"
    commands: tuple[str, ...] = ()
    uart: int | None = None
    seed: int = 0

    def __str__(self) -> str:
        return f"sim:{self.program}"


class WebAddress(_SharedAddress, frozen=True):
    """The serial ports of devices that show the dashboard; `baud` is the baud rate of one board."""

    baud: int = DEFAULT_BAUD

    def __str__(self) -> str:
        return "web:"


Address: TypeAlias = (
    SerialAddress | TcpAddress | UdpAddress | PtyAddress | XbeeAddress | SimAddress | WebAddress
)
