"""The option `--tls` of gateways: this machine's own certificate, or a file."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from rostether.ports.config_paths import certificates_folder

AUTO = "auto"


@dataclass(frozen=True, slots=True)
class Encryption:
    """Files for a gateway's settings, empty without encryption; other devices install `authority`."""

    certificate: str = ""
    key: str = ""
    authority: Path | None = None


def read_encryption(typed: str, host: str) -> Encryption:
    """Return the files that `--tls` means; `host` is where the gateway listens.

    Makes this machine's certificate if needed, which takes a moment. Raises ConfigError.
    """
    if not typed:
        return Encryption()
    if typed != AUTO:
        return Encryption(typed)
    from rostether.gateways.websocket.own_authority import own_certificate

    names = (host, os.environ.get("ROS_HOSTNAME", ""), os.environ.get("ROS_IP", ""))
    made = own_certificate(certificates_folder(), names)
    return Encryption(str(made.certificate), str(made.key), made.authority)
