"""The man pages contain the help of the commands, in valid man syntax."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

SCRIPT = Path(__file__).parents[2] / "scripts" / "write-man-pages"


def test_each_command_has_a_page(tmp_path: Path) -> None:
    subprocess.run([sys.executable, str(SCRIPT), str(tmp_path)], check=True)
    pages = {page.stem: page.read_text() for page in tmp_path.glob("*.1")}
    assert {"rostether", "rostether-serve", "rostether-topic", "rostether-conformance"} <= pages.keys()
    assert "rostether\\-serve(1)" in pages["rostether"]
    # The verbs of a group are on the page of the group.
    assert ".SH ROSTETHER TOPIC ECHO" in pages["rostether-topic"]
    assert "\\fB\\-\\-dashboard" in pages["rostether-serve"]
    for name, text in pages.items():
        assert text.startswith(f".TH {name.upper()} 1 "), name
        assert "\\fB\\-h, \\-\\-help\\fR" in text, name
        assert set(re.findall(r"^\.\w*", text, re.MULTILINE)) <= {".TH", ".SH", ".PP", ".TP", ".nf", ".fi"}
