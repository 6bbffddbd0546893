"""Finds out why the routers of a zenoh configuration cannot be reached, which zenoh does not report.

A TLS endpoint is tried with a handshake and the certificates of the configuration, so the reason is exact.
"""

from __future__ import annotations

import asyncio
import json
import os
import ssl
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import zenoh

from rostether.mechanisms.loopback import is_loopback
from rostether.mechanisms.text import fold_line

# A machine on a busy Wi-Fi accepts within a second; a machine that is off never answers.
PROBE_TIMEOUT_S = 3.0

# The time to wait for a refusal of the certificate, which TLS 1.3 sends after the handshake.
REFUSAL_TIMEOUT_S = 1.0

# OpenSSL's numbers for a certificate without the name or address of the connection.
_NAME_FAULTS = frozenset({62, 64})

_TLS_PROTOCOLS = ("tls/", "quic/")

# The cause if an endpoint accepts connections, or its protocol cannot be tried.
NO_SESSION = "zenoh cannot connect to it; check its protocol (tcp, tls, quic), and that it is a zenoh router"

_TLS = "transport/link/tls"
_CONNECT_FILES = ("root_ca_certificate", "connect_certificate", "connect_private_key")
_LISTEN_FILES = ("root_ca_certificate", "listen_certificate", "listen_private_key")


def endpoints_of(configuration: zenoh.Config, what: str) -> tuple[str, ...]:
    """Return the endpoints of a configuration for its mode; `what` is `connect` or `listen`."""
    found: Any = _value(configuration, f"{what}/endpoints")
    if isinstance(found, dict):
        found = found.get(str(_value(configuration, "mode")), [])
    return tuple(each for each in found or () if isinstance(each, str))


def tls_of(configuration: zenoh.Config) -> Mapping[str, Any]:
    """Return the TLS settings of a configuration."""
    found = _value(configuration, _TLS)
    return found if isinstance(found, dict) else {}


def is_local(endpoint: str) -> bool:
    """Return whether only this machine can reach an endpoint (`tcp/localhost:7447`)."""
    return is_loopback(_split(endpoint)[1])


async def find_faults(endpoints: Sequence[str], tls: Mapping[str, Any]) -> dict[str, str]:
    """Return the endpoints that cannot be reached, with the reasons."""
    faults = await asyncio.gather(*(find_fault(each, tls) for each in endpoints))
    return {endpoint: fault for endpoint, fault in zip(endpoints, faults, strict=True) if fault}


async def find_fault(endpoint: str, tls: Mapping[str, Any]) -> str:
    """Return why an endpoint cannot be reached; empty if it can, or if its protocol cannot be tried."""
    protocol, host, port = _split(endpoint)
    if protocol not in ("tcp", "tls") or not port.isdecimal():
        return ""
    files = _CONNECT_FILES if tls.get("enable_mtls") else _CONNECT_FILES[:1]
    if protocol == "tls" and (fault := _find_file_fault(tls, *files)):
        return fault
    try:
        async with asyncio.timeout(PROBE_TIMEOUT_S):
            reader, writer = await asyncio.open_connection(host, int(port))
    except TimeoutError:
        return "nothing answers there: is the machine on, and does a firewall let the port through?"
    except OSError as error:
        return f"it cannot be reached ({_reason(error)}): is the router running, and is the address right?"
    try:
        return await _find_tls_fault(reader, writer, host, tls) if protocol == "tls" else ""
    finally:
        writer.close()


def _split(endpoint: str) -> tuple[str, str, str]:
    """Return the protocol, the host and the port of an endpoint, without its metadata and settings."""
    protocol, _, address = endpoint.partition("#")[0].partition("?")[0].partition("/")
    host, _, port = address.rpartition(":")
    return protocol, host.strip("[]"), port


async def _find_tls_fault(
    reader: asyncio.StreamReader, writer: asyncio.StreamWriter, host: str, tls: Mapping[str, Any]
) -> str:
    try:
        async with asyncio.timeout(PROBE_TIMEOUT_S):
            await writer.start_tls(_context(tls), server_hostname=host)
        try:
            async with asyncio.timeout(REFUSAL_TIMEOUT_S):
                await reader.read(1)
        except TimeoutError:
            pass
    except ssl.SSLCertVerificationError as error:
        return _explain_verification(error, tls)
    except ssl.SSLError as error:
        return _explain_refusal(error)
    except TimeoutError:
        return "it accepts connections, but does not speak TLS: is it a tcp/ endpoint?"
    except OSError as error:
        return f"it accepts connections, but ends those with TLS ({_reason(error)}): is it a tcp/ endpoint?"
    return ""


def uses_tls(endpoints: Iterable[str]) -> bool:
    """Return whether an endpoint needs certificates."""
    return any(each.startswith(_TLS_PROTOCOLS) for each in endpoints)


def find_listen_fault(configuration: zenoh.Config) -> str:
    """Return why the TLS endpoints of a configuration cannot listen; empty if no reason is found."""
    tls = tls_of(configuration)
    if not uses_tls(endpoints_of(configuration, "listen")):
        return ""
    if not all(tls.get(name) for name in _LISTEN_FILES[1:]):
        return f"TLS needs a certificate and its key; set {' and '.join(_LISTEN_FILES[1:])} in {_TLS}"
    return _find_file_fault(tls, *_LISTEN_FILES)


def _find_file_fault(tls: Mapping[str, Any], *names: str) -> str:
    """Return why a file cannot be used; empty if all can.

    `names` are the settings of the authority's certificate, this program's certificate and its key.
    """
    files = {f"{_TLS}/{name}": str(path) for name in names if (path := tls.get(name))}
    for name, path in files.items():
        try:
            Path(path).read_bytes()
        except OSError as error:
            return f"{path} cannot be read ({_reason(error)}); check {name}"
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    authority, certificate, key = (files.get(f"{_TLS}/{name}") for name in (*names, "", "")[:3])
    try:
        if authority:
            context.load_verify_locations(authority)
    except ssl.SSLError:
        return f"{authority} contains no certificate; check {_TLS}/{names[0]}"
    try:
        if certificate and key:
            # Without a password here, OpenSSL asks for it on the terminal.
            context.load_cert_chain(certificate, key, password="")
    except ssl.SSLError as error:
        if error.reason == "KEY_VALUES_MISMATCH":
            return f"{key} is not the key of the certificate {certificate}; check {_TLS}/{names[2]}"
        return (
            f"{certificate} is not a certificate, or {key} is not a key or has a password; check {_TLS}/"
            f"{names[1]} and {names[2]}"
        )
    return ""


def _context(tls: Mapping[str, Any]) -> ssl.SSLContext:
    context = ssl.create_default_context(cafile=tls.get("root_ca_certificate"))
    # Python 3.13 refuses certificates that zenoh accepts, such as those that `openssl x509 -req` makes.
    context.verify_flags &= ~ssl.VERIFY_X509_STRICT
    context.check_hostname = tls.get("verify_name_on_connect") is not False
    certificate = tls.get("connect_certificate")
    if tls.get("enable_mtls") and certificate:
        context.load_cert_chain(certificate, tls.get("connect_private_key"))
    return context


def _explain_verification(error: ssl.SSLCertVerificationError, tls: Mapping[str, Any]) -> str:
    reason = error.verify_message
    if "issuer" in reason or "self-signed" in reason or "self signed" in reason:
        authority = tls.get("root_ca_certificate")
        where = f"{authority} is not its authority" if authority else "no authority is given"
        return f"its certificate is not known here ({reason}; {where}); set {_TLS}/root_ca_certificate"
    if error.verify_code in _NAME_FAULTS:
        return f"its certificate is for another machine ({reason}); connect by a name that it contains"
    return f"its certificate is not valid here ({reason}); renew it, or set the clock of this machine"


def _explain_refusal(error: ssl.SSLError) -> str:
    reason = (error.reason or str(error)).lower().replace("_", " ")
    if "certificate required" in reason or "handshake failure" in reason:
        return (
            f"it asks for a certificate ({reason}); set {_TLS}/connect_certificate, connect_private_key and "
            "enable_mtls: true"
        )
    if "expired" in reason:
        return f"it refuses the client certificate ({reason}); renew it"
    if "unknown ca" in reason or "certificate" in reason:
        return f"it refuses the client certificate ({reason}); get one from an authority that it trusts"
    return f"it does not accept TLS connections ({reason}); check the port"


def _value(configuration: zenoh.Config, path: str) -> Any:
    try:
        return json.loads(configuration.get_json(path))
    except Exception:  # noqa: BLE001 - zenoh raises its own error for missing settings
        return None


def _reason(error: OSError) -> str:
    number = error.errno
    # If a name is not found, the number is negative and not an errno.
    text = os.strerror(number) if number is not None and number > 0 else error.strerror or str(error)
    return fold_line(text) or type(error).__name__
