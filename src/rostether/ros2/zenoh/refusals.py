"""Reports connections that the TLS listeners refuse; zenoh reports them only in its log on standard output.

To read this log, a pipe replaces standard output. Everything else written there is passed on. If RUST_LOG is
set, the user reads zenoh's log, and nothing is changed.
"""

from __future__ import annotations

import io
import logging
import os
import re
import sys
import threading
import time

import zenoh

# A refused machine tries again every few seconds; one line in this time is enough.
REPEAT_S = 60.0

# The number of different refusals remembered, so that peers cannot fill the memory.
MAX_KINDS = 32

_LINE = re.compile(rb"WARN .*zenoh_link_(?:tls|quic)\S*: (?P<reason>.*)$")
_COLOR = re.compile(rb"\x1b\[[0-9;]*m")
_OTHER = "it needs a certificate from the authority in root_ca_certificate"
_MEANINGS = {
    "UnknownIssuer": ("its certificate is not from the configured authority", _OTHER),
    "sent no certificates": ("it has no certificate", _OTHER),
    "UnknownCA": (
        "it does not know the authority of this machine's certificate",
        "set root_ca_certificate there",
    ),
    "certificate expired": ("its certificate has expired", "renew it"),
    "not valid yet": ("its certificate is not valid yet", "set the clocks of both machines"),
    "CertificateExpired": ("this machine's certificate has expired", "renew it, and start again"),
    "BadCertificate": (
        "it does not accept this machine's certificate",
        "check that it contains the name by which the other machine connects",
    ),
    "InvalidContentType": ("it does not speak TLS", "it needs an endpoint with tls/"),
}
# This is in zenoh's line if a program only tests whether the port is open: that is not a refusal.
_TESTED = "handshake eof"
_log = logging.getLogger("rostether.ros2")
_started = threading.Lock()


def report_refusals() -> None:
    """Log a line for each kind of refusal from now on. Later calls in the same process have no effect."""
    if os.environ.get("RUST_LOG") or not _started.acquire(blocking=False):
        return
    sys.stdout.flush()
    output = os.dup(1)
    read, write = os.pipe()
    os.dup2(write, 1)
    os.close(write)
    if isinstance(sys.stdout, io.TextIOWrapper):
        # This program's log lines do not go through the pipe.
        sys.stdout = os.fdopen(
            os.dup(output), "w", encoding=sys.stdout.encoding, errors=sys.stdout.errors, buffering=1
        )
    threading.Thread(target=_read, args=(read, output), name="zenoh log", daemon=True).start()
    zenoh.init_log_from_env_or("zenoh_link_tls=warn,zenoh_link_quic=warn,zenoh_link_commons=off")


def explain(line: bytes) -> str:
    """Return the reason for a refusal in a line of zenoh's log; empty for other lines."""
    found = _LINE.search(_COLOR.sub(b"", line.rstrip()))
    if found is None:
        return ""
    reason = found["reason"].decode("utf-8", "replace").partition(" Hint:")[0].rstrip(".")
    # The seconds after this differ each time.
    reason = reason.partition(": verification time")[0]
    for word, (meaning, remedy) in _MEANINGS.items():
        if word in reason:
            return f"refused a TLS connection: {meaning} ({reason}); {remedy}"
    return f"refused a TLS connection: {reason}"


def _read(source: int, output: int) -> None:
    reported_s: dict[str, float] = {}
    with open(source, "rb") as lines:
        for line in lines:
            text = explain(line)
            if not text:
                os.write(output, line)
            elif _TESTED not in text and time.monotonic() - reported_s.get(text, float("-inf")) >= REPEAT_S:
                if len(reported_s) >= MAX_KINDS:
                    reported_s.clear()
                reported_s[text] = time.monotonic()
                _log.warning("%s", text)
