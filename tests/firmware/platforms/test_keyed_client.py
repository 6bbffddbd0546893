"""ros/keyed_client.h and ros/sha256.h on the host, compared with Python's functions, and with hostile
hosts.
"""

from __future__ import annotations

import hashlib
import hmac
import random
import subprocess
from pathlib import Path

import pytest

from firmware.platforms.programs import EXTRAS, compile_program
from rostether.transports.psk_hello import ListenerHello

pytestmark = pytest.mark.gcc

ON_HOST = EXTRAS / "arduino_on_host"
SANITIZED = ("g++", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-DARDUINO=10819")
KEY = "0123456789abcdef0123456789abcdef"
NONCE = bytes(range(16))
GREETING = f"RSPSK1 {NONCE.hex()}\n".encode()
NONE, NO_ANSWER, NO_HELLO, WRONG_KEY = range(4)


@pytest.fixture(scope="session")
def program(library: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    output = tmp_path_factory.mktemp("keyed") / "keyed_client"
    return compile_program([*SANITIZED, f"-I{ON_HOST}"], [ON_HOST / "keyed_client.cpp"], library, output)


def run_client(program: Path, data: bytes, *, keeps_open: bool = False) -> tuple[int, int, bytes]:
    """Return the refusal, the number of unread bytes, and the client's output."""
    completed = subprocess.run(
        [program, KEY, "stays" if keeps_open else "leaves"], input=data, capture_output=True, timeout=120
    )
    assert completed.returncode == 0, completed.stderr.decode()
    refusal, left, reported = completed.stdout.split(b" ", 2)
    return int(refusal), int(left), reported


def test_digests_are_those_of_python(program: Path) -> None:
    completed = subprocess.run([program, "digests"], capture_output=True, text=True, timeout=120, check=True)
    for length, line in enumerate(completed.stdout.splitlines()):
        digest = hashlib.sha256(bytes(i * 7 & 255 for i in range(length))).hexdigest()
        mac = hmac.new(b"k" * length, b"text", "sha256").hexdigest()
        assert line == f"{digest} {mac}", length


def test_the_listener_accepts_its_proof(program: Path) -> None:
    refusal, _, reported = run_client(program, GREETING)
    assert refusal == NO_ANSWER
    listener = ListenerHello({None: KEY.encode()}, NONCE)
    assert listener.greeting == GREETING
    assert listener.receive(reported + b"\xff\xfe")[1] == b"\xff\xfe"
    others = {run_client(program, f"RSPSK1 {bytes([first] * 16).hex()}\n".encode())[2] for first in range(4)}
    assert len({each.split()[1] for each in others}) == 4, "each client has another nonce"


def test_a_host_without_the_key_is_refused(program: Path) -> None:
    assert run_client(program, GREETING + b"RSPSK1 " + b"0" * 64 + b"\n\xff\xfe")[:2] == (WRONG_KEY, 2)
    # The client's own proof, sent back.
    _, _, reported = run_client(program, GREETING)
    proof = reported.split()[2]
    assert run_client(program, GREETING + b"RSPSK1 " + proof + b"\n")[0] == WRONG_KEY


@pytest.mark.parametrize(
    "data",
    [
        b"\xff\xfe\x00\x00\xff\x00\x00\xff",
        GREETING.replace(b"\n", b"00\n"),
        GREETING.replace(b"RSPSK1", b"RSPSK2"),
        GREETING[:30] + b"\n",
        GREETING.upper(),
        GREETING + b"RSPSK1 short\n",
        b"RSPSK1 " + b"a" * 100_000,
    ],
)
def test_other_data_ends_the_connection_at_once(program: Path, data: bytes) -> None:
    assert run_client(program, data, keeps_open=True)[0] == NO_HELLO


def test_the_connection_to_a_silent_host_ends_in_time(program: Path) -> None:
    assert run_client(program, b"RSPSK1 00", keeps_open=True)[0] == NO_ANSWER


def test_damaged_proofs_are_refused(program: Path) -> None:
    rng = random.Random(7)
    for _ in range(30):
        data = bytearray(GREETING + b"RSPSK1 " + b"0" * 64 + b"\n")
        for _ in range(rng.randrange(1, 5)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        assert run_client(program, bytes(data))[0] != NONE
