"""The keys and certificates of individual boards, and those with which a board has authenticated."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType

from msgspec import Struct

from rostether.errors import ConfigError
from rostether.mechanisms.text import read_failure

# A certificate is about 2 KB; a longer file is not a certificate.
MAX_CERTIFICATE_BYTES = 64 * 1024


class BoardKeys(Struct, frozen=True):
    """Pre-shared keys, and certificates in DER form, by the paths of their files."""

    keys: Mapping[str, bytes] = MappingProxyType({})
    certificates: Mapping[str, bytes] = MappingProxyType({})


class Proof(Struct, frozen=True):
    """The files of a board's key and certificate with which the peer has authenticated."""

    psk: str | None = None
    certificate: str | None = None


NO_KEYS = BoardKeys()
NO_PROOF = Proof()


def read_board_keys(keys: Iterable[str], certificates: Iterable[str]) -> BoardKeys:
    """Read the files. Raises ConfigError."""
    from rostether.transports.psk_hello import read_key  # only needed with keys

    return BoardKeys(
        {path: read_key(path) for path in keys}, {path: _read_certificate(path) for path in certificates}
    )


def _read_certificate(path: str) -> bytes:
    import ssl  # only needed with certificates

    try:
        with Path(path).expanduser().open("rb") as file:
            text = file.read(MAX_CERTIFICATE_BYTES + 1).decode("ascii", "replace")
        begin, end = text.index("-----BEGIN CERTIFICATE-----"), text.index("-----END CERTIFICATE-----")
        return ssl.PEM_cert_to_DER_cert(text[begin:end] + "-----END CERTIFICATE-----\n")
    except OSError as error:
        raise ConfigError(read_failure(f"certificate={path}", error)) from None
    except ValueError:
        raise ConfigError(
            f"certificate={path} contains no certificate in PEM format; give the board's certificate"
        ) from None
