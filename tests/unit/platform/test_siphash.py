from __future__ import annotations

import pytest

from rostether.platform.siphash import siphash_2_4

KEY = bytes(range(16))


# Vectors of the authors' reference implementation: the message is 00 01 02 ... of each length.
@pytest.mark.parametrize(
    ("length", "tag"),
    [(0, "310e0edd47db6f72"), (1, "fd67dc93c539f874"), (7, "37d1018bf50002ab"), (8, "6224939a79f5f593")],
)
def test_vectors_of_the_authors(length: int, tag: str) -> None:
    assert siphash_2_4(KEY, bytes(range(length))).hex() == tag


def test_the_example_of_the_paper() -> None:
    assert siphash_2_4(KEY, bytes(range(15))) == (0xA129CA6149BE45E5).to_bytes(8, "little")
