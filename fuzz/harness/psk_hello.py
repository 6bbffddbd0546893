"""The hello with a pre-shared key: whoever lacks the key never gets through, and chunks change nothing."""

from __future__ import annotations

from rostether.errors import RemoteProtocolError
from rostether.transports.psk_hello import ConnectorHello, ListenerHello

KEY = b"0123456789abcdef"
NONCES = (bytes(16), bytes(range(16)))


def seeds() -> list[bytes]:
    """Return both sides of a hello with another key, and beginnings of one with this key."""
    found = []
    for key in (KEY, b"another key of 16"):
        listener, connector = ListenerHello({None: key}, NONCES[0]), ConnectorHello(key, NONCES[1])
        connector.receive(listener.greeting)
        answer = connector.take_answer()
        found += [b"\x80" + listener.greeting + answer[:40], b"\x80" + answer[:100]]
    return found


def run(data: bytes) -> None:
    """Take the bytes as either side would; the seeds hold no whole proof, so nothing may pass."""
    middle = data[0] * (len(data) - 1) // 256 if data else 0
    for make in (lambda: ListenerHello({None: KEY}, NONCES[0]), lambda: ConnectorHello(KEY, NONCES[1])):
        hello = make()
        for part in (data[1:][:middle], data[1:][middle:]):
            try:
                assert hello.receive(part) is None, "let in without the key"
            except RemoteProtocolError as error:
                assert "\n" not in str(error)
                break
