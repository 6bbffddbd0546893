from __future__ import annotations

from pathlib import Path

import pytest

from rostether.packages.python_scripts import explain_python2, is_module


def _script(folder: Path, text: str) -> Path:
    (folder / "old.py").write_text(text)
    return folder / "old.py"


@pytest.mark.parametrize(
    "line",
    [
        'print "hello"',
        "print x, y",
        'exec "x = 1"',
        "raise ValueError, 'bad'",
        "x = 0755",
        "y = `x`",
        "if x <> y: pass",
        "s = ur'text'",
        "try: pass\nexcept IOError, error: pass",
        "if x:\n        y = 1\n\tz = 2",
        "import sys, Queue",
        "from urllib2 import urlopen",
    ],
)
def test_a_script_for_python_2_is_reported(tmp_path: Path, line: str) -> None:
    script = _script(tmp_path, f"import rospy\nx = 1\n{line}\n")
    reason = explain_python2(script)
    assert reason.startswith(f"{script}:")
    assert reason.endswith(f"written for Python 2; convert it with `2to3 -w {script}`")


@pytest.mark.parametrize("text", ["print('x')\n", "x = = 1\n", "def f(:\n", "x = '\\d'\n", "\0", ""])
def test_other_scripts_are_not_reported(tmp_path: Path, text: str) -> None:
    assert explain_python2(_script(tmp_path, text)) == ""
    assert explain_python2(tmp_path / "missing.py") == ""


def test_the_line_of_a_python_2_exception_is_reported(tmp_path: Path) -> None:
    script = _script(tmp_path, "try:\n    x = 1\nexcept IOError, error:\n    pass\n")
    assert explain_python2(script).startswith(f"{script}:3: ")


def test_the_modules_next_to_a_script_are_examined(tmp_path: Path) -> None:
    script = _script(
        tmp_path, "import first\ntry:\n    import Queue\nexcept ImportError:\n    import queue\n"
    )
    (tmp_path / "first.py").write_text("import old\nfrom second import f\n")
    (tmp_path / "second.py").write_text("import rospy, StringIO\n\ndef f():\n    print 'x'\n")
    second = tmp_path / "second.py"
    assert explain_python2(script) == f"{second}:4: written for Python 2; convert it with `2to3 -w {second}`"
    second.write_text("import StringIO\n")
    (tmp_path / "StringIO.py").touch()
    assert explain_python2(script) == ""


def test_modules_have_only_definitions(tmp_path: Path) -> None:
    head = '"""Text."""\nimport math\nX = 1\n'
    assert is_module(_script(tmp_path, head + "def f():\n    pass\n"))
    for end in ("f()\n", "if __name__ == '__main__':\n    f()\n"):
        assert not is_module(_script(tmp_path, head + "def f():\n    pass\n" + end))
    assert not is_module(_script(tmp_path, ""))
    assert not is_module(_script(tmp_path, "print 1\n"))
