"""Whether the routers that a zenoh configuration names can be reached, and why not. Zenoh does not report it.

A TLS endpoint is tried with a handshake and the certificates of the configuration, so the reason is exact.
"""

from __future__ import annotations

import asyncio
import json
import os
import ssl
from collections.abc import Mapping, Sequence
from typing import Any

import zenoh

from rostether.mechanisms.text import fold_line

# A machine on a busy Wi-Fi accepts within a second; a machine that is off never answers.
PROBE_TIMEOUT_S = 3.0

# The time to wait for a refusal of the certificate, which TLS 1.3 sends after the handshake.
REFUSAL_TIMEOUT_S = 1.0

_LOOPBACK = ("localhost", "127.", "[::1]")
_TLS = "transport/link/tls"


def endpoints_of(configuration: zenoh.Config, what: str) -> tuple[str, ...]:
    """Return the endpoints of a configuration; `what` is `connect` or `listen`."""
    found: Any = _value(configuration, f"{what}/endpoints")
    if isinstance(found, dict):
        found = found.get(str(_value(configuration, "mode")), [])
    return tuple(each for each in found or () if isinstance(each, str))


def tls_of(configuration: zenoh.Config) -> Mapping[str, Any]:
    """Return the TLS settings of a configuration."""
    found = _value(configuration, _TLS)
    return found if isinstance(found, dict) else {}


def is_loopback(endpoint: str) -> bool:
    """Return whether only this machine can reach an endpoint (`tcp/localhost:7447`)."""
    return endpoint.partition("/")[2].startswith(_LOOPBACK)


async def find_faults(endpoints: Sequence[str], tls: Mapping[str, Any]) -> dict[str, str]:
    """Return the endpoints that cannot be reached, with the reasons."""
    faults = await asyncio.gather(*(find_fault(each, tls) for each in endpoints))
    return {endpoint: fault for endpoint, fault in zip(endpoints, faults, strict=True) if fault}


async def find_fault(endpoint: str, tls: Mapping[str, Any]) -> str:
    """Return why an endpoint cannot be reached; empty if it can, or if its protocol cannot be tried."""
    protocol, _, place = endpoint.partition("#")[0].partition("?")[0].partition("/")
    host, _, port = place.rpartition(":")
    if protocol not in ("tcp", "tls") or not port.isdecimal():
        return ""
    try:
        context = _context(tls) if protocol == "tls" else None
    except (OSError, ValueError) as error:
        return (
            f"a certificate of the configuration cannot be used ({_words(error)}): check the files of {_TLS}"
        )
    try:
        async with asyncio.timeout(PROBE_TIMEOUT_S):
            reader, writer = await asyncio.open_connection(host.strip("[]"), int(port), ssl=context)
        try:
            if context is not None:
                async with asyncio.timeout(REFUSAL_TIMEOUT_S):
                    await reader.read(1)
        except TimeoutError:
            pass
        finally:
            writer.close()
    except ssl.SSLCertVerificationError as error:
        return _explain_verification(error, tls)
    except ssl.SSLError as error:
        return _explain_refusal(error)
    except TimeoutError:
        return "nothing answers there: is the machine on, and does a firewall let the port through?"
    except OSError as error:
        return f"it cannot be reached ({_words(error)}): is the router running, and is the address right?"
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
        return f"its certificate is not known here ({reason}; {where}): set {_TLS}/root_ca_certificate"
    return f"its certificate is not valid here ({reason}): check the names and dates in it"


def _explain_refusal(error: ssl.SSLError) -> str:
    reason = (error.reason or str(error)).lower().replace("_", " ")
    if "certificate required" in reason or "handshake failure" in reason:
        return (
            f"it asks for a certificate ({reason}): set {_TLS}/connect_certificate, connect_private_key and "
            "enable_mtls: true"
        )
    if "unknown ca" in reason or "certificate" in reason:
        return f"it refuses the client certificate ({reason}): get one from an authority that it trusts"
    return f"it does not accept TLS connections ({reason}): check the port"


def _value(configuration: zenoh.Config, path: str) -> Any:
    try:
        return json.loads(configuration.get_json(path))
    except Exception:  # noqa: BLE001 - zenoh raises its own error for missing settings
        return None


def _words(error: Exception) -> str:
    number = getattr(error, "errno", None)
    text = os.strerror(number) if number is not None and number > 0 else str(error)
    return fold_line(text) or type(error).__name__
