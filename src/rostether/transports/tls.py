"""TLS for TCP links: its files, and their contexts of Python's ssl."""

from __future__ import annotations

import traceback
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rostether.errors import ConfigError

if TYPE_CHECKING:
    import ssl

# Small boards take 2 s for their part of a handshake; a peer that does not answer takes a connection.
HANDSHAKE_LIMIT_S = 5.0


@dataclass(frozen=True, slots=True)
class TlsFiles:
    """PEM files: a certificate, its key (None: in the same file), and the authority of the peer.

    A listener needs a certificate; with `ca`, it accepts only boards that have one too. A connector checks
    the listener's certificate with `ca`, or else with the system's authorities.
    """

    cert: str | None = None
    key: str | None = None
    ca: str | None = None


def clear_handshake(error: OSError) -> None:
    """Clear the frames of a failed handshake: their error refers to them, and they to the error.

    Until a full garbage collection they would keep the connection's read buffer, 256 KiB.
    """
    traceback.clear_frames(error.__traceback__)


def listener_context(files: TlsFiles, certificates: Iterable[bytes] = ()) -> ssl.SSLContext:
    """Return the context of a listener, which also accepts the `certificates` of single boards (DER).

    Raises ConfigError.
    """
    import ssl  # only needed with TLS

    if files.cert is None:
        raise ConfigError("a tls: listener needs a certificate; write tls://HOST:PORT?cert=FILE&key=FILE")
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    _load(context, files)
    for certificate in certificates:
        # Regardless of its issuer: it identifies that board.
        context.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN
        context.verify_mode = ssl.CERT_OPTIONAL
        context.load_verify_locations(cadata=certificate)
    if files.ca is not None:
        context.verify_mode = ssl.CERT_REQUIRED
    return context


def connector_context(files: TlsFiles) -> ssl.SSLContext:
    """Return the context of a connector. Raises ConfigError."""
    import ssl

    context = ssl.create_default_context()
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    _load(context, files)
    return context


def _load(context: ssl.SSLContext, files: TlsFiles) -> None:
    import ssl
    from pathlib import Path

    shown = f"cert={files.cert}" + (f"&key={files.key}" if files.key else "")
    try:
        if files.cert is not None:
            key = None if files.key is None else Path(files.key).expanduser()
            # Never ask for a password on the terminal: a service has no terminal.
            context.load_cert_chain(Path(files.cert).expanduser(), key, password=lambda: "")
        shown = f"ca={files.ca}"
        if files.ca is not None:
            context.load_verify_locations(Path(files.ca).expanduser())
    except (OSError, ValueError) as error:
        reason = error.reason if isinstance(error, ssl.SSLError) else getattr(error, "strerror", None)
        raise ConfigError(
            f"{shown}: it has no readable certificate or key in PEM format: {reason or error}"
        ) from None
