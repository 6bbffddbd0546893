r"""The hello of a network board with a pre-shared key, sans I/O; rosserial bytes follow only after it.

Three lines of ASCII, in which both sides prove that they have the key:

    listener    RSPSK1 <nonce>\n
    connector   RSPSK1 <nonce> <proof>\n
    listener    RSPSK1 <proof>\n

A nonce is 16 random bytes in hex. A proof is HMAC-SHA256 in hex, with the key. The connector's is over the
ASCII text `rostether psk1 connector <listener's nonce> <connector's nonce>`; the listener's has `listener`
for `connector`. A board that need not identify its host can ignore the last line. The bytes after the hello
are not encrypted and not signed: use TLS for that, with or without this hello inside it.
"""

from __future__ import annotations

import hmac
import os
import re
from collections.abc import Mapping
from pathlib import Path

from rostether.errors import ConfigError, RemoteProtocolError
from rostether.mechanisms.text import read_failure

# A board on Wi-Fi answers within a second; a peer that does not answer uses up a connection.
PSK_LIMIT_S = 5.0

# A shorter key can be guessed offline from one recorded hello.
MIN_KEY_BYTES = 16

# A longer file is not a key.
MAX_KEY_FILE_BYTES = 4096

# The longest line has 105 bytes: a longer one is not a hello.
MAX_LINE_BYTES = 160

_WORD = "RSPSK1"
_ANSWER = re.compile(rb"RSPSK1 ([0-9a-f]{32}) ([0-9a-f]{64})")
_GREETING = re.compile(rb"RSPSK1 ([0-9a-f]{32})")
_NO_HELLO = "it sent no pre-shared-key hello; give it the key, see psk="
_OTHER_KEY = "it has a different pre-shared key; use the same key on both sides, see psk="
_PROOF = re.compile(rb"RSPSK1 ([0-9a-f]{64})")


def read_key(path: str) -> bytes:
    """Read a key from a file: its bytes without white space around them. Raises ConfigError."""
    try:
        with Path(path).expanduser().open("rb") as file:
            key = file.read(MAX_KEY_FILE_BYTES + 1).strip()
    except OSError as error:
        raise ConfigError(read_failure(f"psk={path}", error)) from None
    if not MIN_KEY_BYTES <= len(key) <= MAX_KEY_FILE_BYTES:
        raise ConfigError(
            f"psk={path}: a key has {MIN_KEY_BYTES} to {MAX_KEY_FILE_BYTES} bytes, this has {len(key)}; "
            "make one with: openssl rand -hex 32"
        )
    return key


class _Hello:
    """What both sides have: a nonce, and the bytes of a line that is not complete yet."""

    def __init__(self, nonce: bytes | None) -> None:
        self._nonce = (os.urandom(16) if nonce is None else nonce).hex()
        self._pending = b""

    def _receive_line(self, data: bytes) -> tuple[bytes, bytes] | None:
        self._pending += data
        line, end, rest = self._pending.partition(b"\n")
        if len(line) > MAX_LINE_BYTES:
            raise RemoteProtocolError(_NO_HELLO)
        if not end:
            return None
        self._pending = b""
        return line.removesuffix(b"\r"), rest


class ListenerHello(_Hello):
    """The side of the listener: send `greeting`, then call `receive` until the key is proven.

    `keys` are the accepted keys by name; `proven` is then the name of the peer's key.
    """

    def __init__(self, keys: Mapping[str | None, bytes], nonce: bytes | None = None) -> None:
        super().__init__(nonce)
        self._keys = keys
        self.proven: str | None = None

    @property
    def greeting(self) -> bytes:
        """The first line to send."""
        return f"{_WORD} {self._nonce}\n".encode()

    def receive(self, data: bytes) -> tuple[bytes, bytes | None]:
        """Handle bytes; return the bytes to send now, and once the key is proven, those of the next protocol.

        Raises RemoteProtocolError for a peer without the key.
        """
        received = self._receive_line(data)
        if received is None:
            return b"", None
        line, rest = received
        match = _ANSWER.fullmatch(line)
        if match is None:
            raise RemoteProtocolError(_NO_HELLO)
        theirs, proof = match[1].decode(), match[2].decode()
        for name, key in self._keys.items():
            if hmac.compare_digest(proof, _proof(key, "connector", self._nonce, theirs)):
                self.proven = name
                return f"{_WORD} {_proof(key, 'listener', self._nonce, theirs)}\n".encode(), rest
        raise RemoteProtocolError(_OTHER_KEY)


class ConnectorHello(_Hello):
    """The side of the peer that connects: call `receive` until the key is proven."""

    def __init__(self, key: bytes, nonce: bytes | None = None) -> None:
        super().__init__(nonce)
        self._key = key
        self._expected = ""

    def receive(self, data: bytes) -> tuple[bytes, bytes | None]:
        """Handle bytes; return the same as `ListenerHello.receive`. Raises the same error."""
        received = self._receive_line(data)
        if received is None:
            return b"", None
        line, rest = received
        if not self._expected:
            match = _GREETING.fullmatch(line)
            if match is None:
                raise RemoteProtocolError("it requires no pre-shared key; omit psk=, or also set it there")
            theirs = match[1].decode()
            self._expected = _proof(self._key, "listener", theirs, self._nonce)
            answer = f"{_WORD} {self._nonce} {_proof(self._key, 'connector', theirs, self._nonce)}\n"
            return answer.encode(), self.receive(rest)[1]
        match = _PROOF.fullmatch(line)
        if match is None or not hmac.compare_digest(match[1].decode(), self._expected):
            raise RemoteProtocolError(_OTHER_KEY)
        return b"", rest


def _proof(key: bytes, role: str, listener_nonce: str, connector_nonce: str) -> str:
    text = f"rostether psk1 {role} {listener_nonce} {connector_nonce}"
    return hmac.digest(key, text.encode(), "sha256").hex()
