"""Room for boards within the limit of open files."""

from __future__ import annotations

import subprocess
import sys

import pytest

CODE = """
import resource
from rostether.transports.descriptors import allow_many_descriptors, boards_that_fit
fitting = boards_that_fit(256)
allow_many_descriptors()
print(fitting, boards_that_fit(256), *resource.getrlimit(resource.RLIMIT_NOFILE))
"""


@pytest.mark.parametrize(
    ("limits", "printed"),
    [
        ("ulimit -Sn 512; ulimit -Hn 4096", "38 256 4096 4096"),
        ("ulimit -Sn 1024; ulimit -Hn 1024", "89 89 1024 1024"),
        ("ulimit -Sn 64; ulimit -Hn 64", "1 1 64 64"),
    ],
)
def test_the_soft_limit_is_raised_and_the_hard_one_kept(limits: str, printed: str) -> None:
    done = subprocess.run(
        ["bash", "-c", f'{limits}; exec "$0" -c "$1"', sys.executable, CODE],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == printed.split()


def test_boards_that_need_too_many_open_files_get_one_line() -> None:
    code = "from rostether.transports.descriptors import shortage; print(shortage(1000)); print(shortage(80))"
    done = subprocess.run(
        ["bash", "-c", 'ulimit -Sn 1024; exec "$0" -c "$1"', sys.executable, code],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.splitlines() == [
        "1000 boards need up to 10128 open files, but the system permits 1024, enough for about 89 boards; "
        "raise the limit with `ulimit -n 10128` as root, or with LimitNOFILE=10128 in a systemd unit",
        "None",
    ]
