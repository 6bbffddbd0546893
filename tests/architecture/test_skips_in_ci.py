"""In CI, where every peer is installed, a skipped test fails."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

TESTS = Path(__file__).parents[1]

TEST_MODULE = """
import pytest

def test_graph():
    pytest.skip("this graph lacks: global parameters")

def test_program():
    pytest.skip("no fish (apt install fish)")

@pytest.mark.skipif(True, reason="too slow, this graph lacks: time")
def test_condition():
    pass

@pytest.mark.xfail(strict=True)
def test_expected_failure():
    assert False

def test_good():
    pass
"""


def run_pytest(folder: Path, ci: str) -> tuple[int, str]:
    """Run the tests of a folder with the hooks of all tests; return the exit code and the output."""
    options = ("-p", "conftest", "-p", "no:cacheprovider", "--rootdir", str(folder), "-v", "--tb=line")
    finished = subprocess.run(
        [sys.executable, "-m", "pytest", *options, str(folder)],
        cwd=folder,
        env={**os.environ, "CI": ci, "PYTHONPATH": str(TESTS)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    return finished.returncode, finished.stdout


@pytest.mark.parametrize(("ci", "outcome"), [("true", "FAILED"), ("", "SKIPPED")])
def test_ci_skips_only_tests_of_missing_capabilities(ci: str, outcome: str, tmp_path: Path) -> None:
    (tmp_path / "test_skipping.py").write_text(TEST_MODULE)
    code, output = run_pytest(tmp_path, ci)
    assert dict(re.findall(r"^test_skipping\.py::(\w+) ([A-Z]+)", output, re.MULTILINE)) == {
        "test_graph": "SKIPPED",
        "test_program": outcome,
        # Its mark skips it before its start.
        "test_condition": "ERROR" if ci else outcome,
        "test_expected_failure": "XFAIL",
        "test_good": "PASSED",
    }
    assert code == (1 if ci else 0), output
    assert ("CI needs every peer: Skipped: no fish (apt install fish)" in output) == bool(ci)


@pytest.mark.parametrize("ci", ["true", ""])
def test_a_module_that_is_skipped_fails_in_ci(ci: str, tmp_path: Path) -> None:
    (tmp_path / "test_module.py").write_text("import pytest\npytest.importorskip('no_such_module')\n")
    (tmp_path / "test_good.py").write_text("def test_good(): pass\n")
    code, output = run_pytest(tmp_path, ci)
    assert (code != 0) == bool(ci), output
    assert ("CI needs every peer: " in output) == bool(ci)
