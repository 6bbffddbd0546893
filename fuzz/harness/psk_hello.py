"""The hello with a pre-shared key: a peer without the key is refused, and chunks do not change the result."""

from __future__ import annotations

import hashlib
import hmac
import random

from fuzz.grammar import damaged, near
from rostether.errors import RemoteProtocolError
from rostether.transports.psk_hello import MAX_LINE_BYTES, ConnectorHello, ListenerHello

KEY = b"0123456789abcdef"
OTHER_KEY = b"another key of 16"
NONCES = (bytes(16), bytes(range(16)))


def seeds() -> list[bytes]:
    """Return both sides of a hello with a different key, and beginnings of one with this key."""
    found = []
    for key in (KEY, OTHER_KEY):
        listener, connector = ListenerHello({None: key}, NONCES[0]), ConnectorHello(key, NONCES[1])
        answer, _ = connector.receive(listener.greeting)
        found += [b"\x80" + listener.greeting + answer[:40], b"\x80" + answer[:100]]
    return found


def generate(source: random.Random) -> bytes:
    """Return lines of a hello that are correct except for a key, a letter, a length or a line end."""
    key = source.choice((KEY, KEY, OTHER_KEY))
    role = source.choice(("connector", "listener"))
    theirs = source.randbytes(16).hex()
    nonces = (NONCES[0].hex(), theirs) if role == "connector" else (theirs, NONCES[1].hex())
    proof = _proof(key, role, *nonces)
    if source.random() < 0.3:
        # Correct at its beginning, or written differently.
        place = source.randrange(64)
        proof = source.choice((proof[:place] + "0" * (64 - place), proof.upper(), proof[:-1], proof + "0"))
    answer, greeting = f"RSPSK1 {theirs} {proof}\n", f"RSPSK1 {theirs}\nRSPSK1 {proof}\n"
    data = (answer if role == "connector" else greeting).encode()
    chance = source.random()
    if chance < 0.2:
        data = damaged(source, data)
    elif chance < 0.4:
        data = b"x" * (near(source, MAX_LINE_BYTES) % 400) + source.choice((b"", b"\n"))
    elif chance < 0.5:
        data = data.replace(b"\n", b"\r\n")
    return source.randbytes(1) + data + source.randbytes(source.randint(0, 3))


def run(data: bytes) -> None:
    """Read the bytes as both sides do; only a correct proof is accepted, and the bytes after it."""
    middle = data[0] * (len(data) - 1) // 256 if data else 0
    stream = data[1:]
    for hello, count, role in (
        (ListenerHello({None: KEY}, NONCES[0]), 1, "connector"),
        (ConnectorHello(KEY, NONCES[1]), 2, "listener"),
    ):
        rest: bytes | None = None
        is_refused = False
        for part in (stream[:middle], stream[middle:]):
            if rest is not None:
                rest += part
                continue
            try:
                _, rest = hello.receive(part)
            except RemoteProtocolError as error:
                assert "\n" not in str(error)
                is_refused = True
                break
        assert (rest is not None) == _is_proven(stream, count, role), (
            "a peer without the key is accepted, or one with the key refused"
        )
        if rest is not None:
            assert rest == stream.split(b"\n", count)[count], "bytes after the hello are lost"
        elif not is_refused:
            last = stream.rsplit(b"\n", 1)[-1]
            assert len(last) <= MAX_LINE_BYTES, "a line without an end is kept"


def _is_proven(stream: bytes, count: int, role: str) -> bool:
    lines = [line.removesuffix(b"\r") for line in stream.split(b"\n")]
    if len(lines) <= count:
        return False
    words = b" ".join(lines[:count]).split(b" ")
    marks = [b"RSPSK1"] if count == 1 else [b"RSPSK1", b"RSPSK1"]
    if len(words) != 2 + len(marks) or words[0] != b"RSPSK1" or (count == 2 and words[2] != b"RSPSK1"):
        return False
    theirs, proof = words[1], words[-1]
    if len(theirs) != 32 or not all(digit in b"0123456789abcdef" for digit in theirs):
        return False
    nonces = (NONCES[0].hex(), theirs.decode()) if count == 1 else (theirs.decode(), NONCES[1].hex())
    return proof == _proof(KEY, role, *nonces).encode()


def _proof(key: bytes, role: str, listener_nonce: str, connector_nonce: str) -> str:
    text = f"rostether psk1 {role} {listener_nonce} {connector_nonce}".encode()
    return hmac.new(key, text, hashlib.sha256).hexdigest()
