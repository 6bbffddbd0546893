"""The strength of a Wi-Fi signal, from /proc/net/wireless (proc(5), "Wireless Extensions")."""

from __future__ import annotations

from pathlib import Path

_WIRELESS = Path("/proc/net/wireless")
_MAX_LINES = 64


def read_signal_dbm(interfaces: tuple[str, ...] = (), path: Path = _WIRELESS) -> int | None:
    """Return the signal in dBm of the first wireless interface among `interfaces`, None if there is none.

    Without names, all interfaces are searched. Only Linux has the file.
    """
    try:
        lines = path.read_text(encoding="ascii", errors="replace").splitlines()[2:_MAX_LINES]
    except OSError:
        return None
    for line in lines:
        name, _, values = line.partition(":")
        words = values.split()
        if len(words) >= 3 and (not interfaces or name.strip() in interfaces):
            try:
                signal = int(float(words[2]))
            except ValueError:
                continue
            # Some drivers report 0 to 255 for -256 to -1.
            return signal - 256 if signal > 63 else signal
    return None
