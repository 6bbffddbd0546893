"""Encrypted connections (wss): a certificate and its key, as files."""

from __future__ import annotations

import ssl

from rostether.errors import ConfigError


def server_encryption(certificate: str, key: str) -> ssl.SSLContext | None:
    """Return the TLS context of a listener, None without a certificate; one file may contain both.

    Raises ConfigError naming the files that cannot be used.
    """
    if not certificate:
        return None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        context.load_cert_chain(certificate, key or None)
    except (OSError, ssl.SSLError) as error:
        files = f"{certificate} and its key {key}" if key else certificate
        raise ConfigError(
            f"the certificate {files} cannot be used: {error.strerror or error}; "
            "give readable files in PEM format"
        ) from None
    return context
