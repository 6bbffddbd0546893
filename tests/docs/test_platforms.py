"""The table of platforms: each row names a test that is there."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "reference" / "platforms.md"


def test_each_platform_has_a_test() -> None:
    section = PAGE.read_text().partition("## Tests of each platform")[2].partition("\n## ")[0]
    rows = [line for line in section.splitlines() if line.startswith("| ")][2:]
    assert len(rows) >= 14
    for row in rows:
        match = re.search(r"\| `(tests/[\w/]+\.py)::(test_\w+)` \|$", row)
        assert match is not None, row
        assert re.search(rf"^(async )?def {match[2]}\(", (ROOT / match[1]).read_text(), re.MULTILINE), row
