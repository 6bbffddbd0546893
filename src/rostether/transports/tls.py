"""TLS for TCP links: reads the certificate files into contexts of Python's ssl."""

from __future__ import annotations

import logging
import ssl
import traceback
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path

from rostether.errors import ConfigError
from rostether.mechanisms.text import read_failure
from rostether.transports.address import TlsFiles

_LOG = logging.getLogger(__name__)

# Small boards take 2 s for their part of a handshake; a peer that does not answer uses up a connection.
HANDSHAKE_LIMIT_S = 5.0
# A certificate with all its authorities; a device file has no end.
_MAX_FILE_BYTES = 1024 * 1024
# OpenSSL's error numbers for wrong dates; its texts depend on its version.
_DATE_FAULTS = {9: "certificate is not yet valid", 10: "certificate has expired"}
# OpenSSL's errors for a peer that does not send TLS.
SPEAKS_NO_TLS = frozenset({"HTTP_REQUEST", "HTTPS_PROXY_REQUEST", "UNKNOWN_PROTOCOL", "WRONG_VERSION_NUMBER"})


def clear_handshake(error: OSError) -> None:
    """Clear the frames of a failed handshake, because the error and its frames refer to each other.

    Until a full garbage collection, they would keep the connection's read buffer, 256 KiB.
    """
    traceback.clear_frames(error.__traceback__)


def listener_context(files: TlsFiles, certificates: Collection[bytes] = ()) -> ssl.SSLContext:
    """Return the context of a listener, which also accepts the `certificates` of individual boards (DER).

    Raises ConfigError.
    """
    if files.cert is None:
        raise ConfigError("a tls: listener needs a certificate; write tls://HOST:PORT?cert=FILE&key=FILE")
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    _load(context, files)
    for certificate in certificates:
        # The certificate identifies a board, so its issuer does not matter.
        context.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN
        context.verify_mode = ssl.CERT_OPTIONAL
        context.load_verify_locations(cadata=certificate)
    if files.ca is not None:
        context.verify_mode = ssl.CERT_REQUIRED
    return context


class ListenerTls:
    """The TLS of a listener, which loads replaced certificates without a restart.

    The arguments are those of `listener_context`. Raises ConfigError.
    """

    def __init__(self, files: TlsFiles, certificates: Collection[bytes] = ()) -> None:
        self._files = files
        self._certificates = certificates
        self._versions = self._read_versions()
        self._context = listener_context(files, certificates)
        self._reported = ""

    def context(self) -> ssl.SSLContext:
        """Return the context for the next connection.

        If the files have changed, it is a new one: OpenSSL drops an old key before it refuses a new one. If
        they cannot be used, it is the previous one, and the reason is reported once.
        """
        versions = self._read_versions()
        if versions == self._versions:
            return self._context
        self._versions = versions
        try:
            self._context = listener_context(self._files, self._certificates)
        except ConfigError as error:
            if (reason := str(error)) != self._reported:
                self._reported = reason
                _LOG.warning("New connections still use the previous certificate: %s", reason)
        else:
            self._reported = ""
            _LOG.info("New connections use the changed certificate %s", self._files.cert)
        return self._context

    def _read_versions(self) -> list[tuple[int, ...] | None]:
        """Return the identity, size and times of each file, None for a missing one."""
        return [_version(each) for each in (self._files.cert, self._files.key, self._files.ca)]


def connector_context(files: TlsFiles) -> ssl.SSLContext:
    """Return the context of a connector. Raises ConfigError."""
    context = ssl.create_default_context()
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    _load(context, files)
    return context


def load_own_certificate(context: ssl.SSLContext, certificate: str, key: str | None) -> None:
    """Load a certificate and its key, which may be in one file. Raises ConfigError that names the file."""
    certificate_path = Path(certificate).expanduser()
    key_path = certificate_path if key is None else Path(key).expanduser()
    if b"-----BEGIN CERTIFICATE-----" not in _read(certificate_path):
        raise ConfigError(
            f"{certificate_path} contains no certificate in PEM format; add it, or give its file"
        )
    key_text = _read(key_path)
    if b"PRIVATE KEY-----" not in key_text:
        raise ConfigError(f"{key_path} contains no private key in PEM format; add it, or give its file")
    try:
        # Never ask for a password on the terminal: a service has no terminal.
        context.load_cert_chain(certificate_path, key_path, password=lambda: "")
    except ssl.SSLError as error:
        if error.reason == "KEY_VALUES_MISMATCH":
            reason = f"{key_path} is not the key of the certificate {certificate_path}; give the right one"
        elif b"ENCRYPTED" in key_text:
            reason = (
                f"the key {key_path} has a password; remove it: openssl pkey -in {key_path} -out NEW_FILE"
            )
        else:
            files = dict.fromkeys((str(certificate_path), str(key_path)))
            reason = f"{' or '.join(files)} is damaged; create the certificate and its key again"
        raise ConfigError(reason) from None
    if (fault := _find_date_fault(certificate_path, key_path)) is not None:
        _LOG.warning("%s: %s; replace it, or set the clock of this machine", certificate_path, fault)


def _find_date_fault(certificate: Path, key: Path) -> str | None:
    """Return why the dates of a certificate are wrong now, None if they are right.

    Python checks the dates only in a handshake, so this runs one in memory. The peer trusts the certificate.
    """
    own, peer = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER), ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    own.load_cert_chain(certificate, key)
    peer.check_hostname = False
    peer.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN
    peer.load_verify_locations(certificate)
    to_own, to_peer = ssl.MemoryBIO(), ssl.MemoryBIO()
    sides = peer.wrap_bio(to_peer, to_own), own.wrap_bio(to_own, to_peer, server_side=True)
    try:
        # The peer sends its hello, this side its certificate, and the peer checks the certificate.
        for side in (*sides, sides[0]):
            with suppress(ssl.SSLWantReadError):
                side.do_handshake()
    except ssl.SSLError as error:
        if isinstance(error, ssl.SSLCertVerificationError):
            return _DATE_FAULTS.get(error.verify_code)
    return None


def show_ssl_reason(error: ssl.SSLError) -> str:
    """Return OpenSSL's reason in words."""
    return (error.reason or str(error)).lower().replace("_", " ")


def _read(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return file.read(_MAX_FILE_BYTES)
    except OSError as error:
        raise ConfigError(read_failure(path, error)) from None


def _version(file: str | None) -> tuple[int, ...] | None:
    try:
        status = None if file is None else Path(file).expanduser().stat()
    except OSError:
        return None
    return status and (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns)


def _load(context: ssl.SSLContext, files: TlsFiles) -> None:
    if files.cert is not None:
        load_own_certificate(context, files.cert, files.key)
    if files.ca is None:
        return
    try:
        context.load_verify_locations(Path(files.ca).expanduser())
    except ssl.SSLError:
        raise ConfigError(
            f"ca={files.ca} contains no certificate in PEM format; give the authority's certificate"
        ) from None
    except OSError as error:
        raise ConfigError(read_failure(f"ca={files.ca}", error)) from None
