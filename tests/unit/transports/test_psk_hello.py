from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import ConfigError, RemoteProtocolError
from rostether.transports.psk_hello import ConnectorHello, ListenerHello, read_key

KEY = b"0123456789abcdef"
NONCES = (bytes(16), bytes(range(16)))


def test_both_prove_the_key_and_what_follows_is_kept() -> None:
    listener, connector = ListenerHello({None: KEY}), ConnectorHello(KEY)
    answer, rest = connector.receive(listener.greeting)
    assert rest is None
    proof, rest = listener.receive(answer + b"\xff\xfe")
    assert rest == b"\xff\xfe"
    assert connector.receive(proof + b"\xff\xff") == (b"", b"\xff\xff")


def test_the_lines_are_those_of_the_documentation() -> None:
    listener, connector = ListenerHello({None: KEY}, NONCES[0]), ConnectorHello(KEY, NONCES[1])
    assert listener.greeting == b"RSPSK1 " + b"0" * 32 + b"\n"
    answer, _ = connector.receive(listener.greeting)
    # hmac.new(KEY, b"rostether psk1 connector " + 32 zeros + b" 000102...0f", "sha256")
    assert answer == (
        b"RSPSK1 000102030405060708090a0b0c0d0e0f "
        b"569d068674aee9b74e4f501c8607dbf1d066ef908a7386f8bb3d5f6f80fccbb5\n"
    )
    assert (
        listener.receive(answer)[0]
        == b"RSPSK1 61c5bcb5b74d9e7048ba5f144bf7bfb90e726807d066b4eeef0c7406c9437853\n"
    )


def test_cut_anywhere() -> None:
    listener, connector = ListenerHello({None: KEY}), ConnectorHello(KEY)
    answers = [connector.receive(bytes([byte])) for byte in listener.greeting]
    assert all(rest is None for _, rest in answers)
    passed = [listener.receive(bytes([byte])) for byte in b"".join(answer for answer, _ in answers)]
    assert [rest for _, rest in passed if rest is not None] == [b""]
    assert passed[-1][1] == b""


def test_both_lines_at_once_from_a_listener() -> None:
    connector = ConnectorHello(KEY, NONCES[1])
    listener = ListenerHello({None: KEY}, NONCES[0])
    other = ConnectorHello(KEY, NONCES[1])
    answer, _ = other.receive(listener.greeting)
    proof, _ = listener.receive(answer)
    assert connector.receive(listener.greeting + proof + b"x") == (answer, b"x")


def test_another_key_is_refused_by_either_side() -> None:
    listener, connector = ListenerHello({None: KEY}), ConnectorHello(b"another key of 17")
    answer, _ = connector.receive(listener.greeting)
    with pytest.raises(RemoteProtocolError, match="a different pre-shared key"):
        listener.receive(answer)
    with pytest.raises(RemoteProtocolError, match="a different pre-shared key"):
        connector.receive(b"RSPSK1 " + b"0" * 64 + b"\n")


def test_an_answer_to_an_earlier_hello_is_refused() -> None:
    earlier, connector = ListenerHello({None: KEY}), ConnectorHello(KEY)
    answer, _ = connector.receive(earlier.greeting)
    assert earlier.receive(answer)[1] == b""
    with pytest.raises(RemoteProtocolError):
        ListenerHello({None: KEY}).receive(answer)


def test_an_echo_of_our_own_proof_is_refused() -> None:
    """The role is in the proof: a reflected challenge proves nothing."""
    listener = ListenerHello({None: KEY}, NONCES[0])
    mirrored = ListenerHello({None: KEY}, NONCES[0])
    connector = ConnectorHello(KEY, NONCES[0])
    answer, _ = connector.receive(listener.greeting)
    proof = mirrored.receive(answer)[0].split()[1]
    with pytest.raises(RemoteProtocolError):
        listener.receive(b"RSPSK1 " + b"0" * 32 + b" " + proof + b"\n")


@pytest.mark.parametrize("data", [b"\xff\xfe\x08\x00\xf7\n", b"RSPSK1 zz zz\n", b"x" * 1000, b"\n"])
def test_what_is_not_a_hello_is_refused(data: bytes) -> None:
    with pytest.raises(RemoteProtocolError, match="sent no pre-shared-key hello"):
        ListenerHello({None: KEY}).receive(data)
    with pytest.raises(RemoteProtocolError):
        ConnectorHello(KEY).receive(data)


def test_a_key_comes_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "key.txt"
    file.write_bytes(KEY + b"\n")
    assert read_key(str(file)) == KEY
    file.write_bytes(b"short\n")
    with pytest.raises(ConfigError, match="a key has 16 to 4096 bytes, this has 5; make one with"):
        read_key(str(file))
    with pytest.raises(ConfigError, match=r"cannot read psk=.*: No such file"):
        read_key(str(tmp_path / "none"))
