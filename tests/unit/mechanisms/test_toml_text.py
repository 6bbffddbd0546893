from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.mechanisms.toml_text import MAX_FILE_BYTES, parse_toml, read_toml_text


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("x = ", "not TOML: Invalid value"),
        ("x = " + "[" * 5000, "nested too deeply"),
        ("x = " + "{a=" * 5000, "nested too deeply"),
        ("x = " + "1" * 5000, "not TOML: a number has too many digits; shorten it$"),
        (".".join(["a"] * 50_000) + " = 1", "line 1: a key has more than 32 parts"),
        ("x = 1\n[" + ".".join(["a"] * 50_000) + "]", "line 2: a key has more than 32 parts"),
    ],
)
def test_hostile_texts_are_refused_at_once(text: str, reason: str) -> None:
    with pytest.raises(ConfigError, match=f"^robot.toml: .*{reason}") as caught:
        parse_toml(text, "robot.toml")
    assert "\n" not in str(caught.value)


def test_files_without_end_and_other_texts_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"x" * (MAX_FILE_BYTES + 1))
    (tmp_path / "b").write_bytes(b"\xff")
    for name, reason in (
        ("a", "longer than"),
        ("b", "not UTF-8 text at byte 0"),
        (".", "cannot read"),
        ("c", "No such file or directory; check the path"),
    ):
        with pytest.raises(ConfigError, match=reason):
            read_toml_text(tmp_path / name)


def test_a_byte_order_mark_is_ignored(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"\xef\xbb\xbfx = 1\n")
    assert read_toml_text(tmp_path / "a") == "x = 1\n"
