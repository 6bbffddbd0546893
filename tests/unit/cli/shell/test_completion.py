from __future__ import annotations

import os
import shutil
import subprocess
import sys
from types import SimpleNamespace

import pytest
from click.shell_completion import ShellComplete

from rostether.cli.main import rostether
from unit.cli.command_shell import LiveGraph, Shell


@pytest.mark.parametrize(
    ("shell_name", "words"),
    [
        ("bash", "complete -o nosort -F _rostether_completion rostether"),
        ("zsh", "compdef _rostether_completion rostether"),
        ("fish", "complete --no-files --command rostether"),
    ],
)
def test_code_for_each_shell(
    shell: Shell, shell_name: str, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = shell.output("completion", shell_name)
    assert words in code
    monkeypatch.setenv("SHELL", f"/usr/bin/{shell_name}")
    assert shell.output("completion") == code


def test_fish_splits_a_completion_only_at_the_first_comma(shell: Shell) -> None:
    assert 'string split --max 1 "," $completion' in shell.output("completion", "fish")


def test_an_unknown_shell_names_the_known_ones(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SHELL", "/bin/tcsh")
    assert "give a shell: bash, zsh, fish" in shell.failure("completion", code=2)
    assert "'bash', 'zsh', 'fish'" in shell.failure("completion", "tcsh", code=2)


def completed(words: str, environment: dict[str, str]) -> list[str]:
    """Return what bash offers for the last of the words."""
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("bash is not installed")
    code = subprocess.run(
        [sys.executable, "-m", "rostether", "completion", "bash"], capture_output=True, text=True, check=True
    ).stdout
    # The code calls `rostether`, as it is on the user's PATH.
    program = f'env() {{ command env "${{@:1:$#-1}}" {sys.executable} -m rostether; }}'
    script = (
        f"{code}\n{program}\nCOMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))\n"
        '_rostether_completion rostether; printf "%s\\n" "${COMPREPLY[@]}"'
    )
    ended = subprocess.run(
        [bash, "--norc", "-c", script],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, **environment},
    )
    assert ended.stderr == ""
    return ended.stdout.split()


def test_bash_completes_verbs_and_names(graph: LiveGraph) -> None:
    graph.node("talker")
    environment = {"ROS_MASTER_URI": graph.uri}
    assert completed("rostether no", environment) == ["node"]
    assert completed('rostether node ""', environment)[:2] == ["list", "info"]
    # On a busy machine the master may answer after the longest wait.
    tries = (completed("rostether node info ta", environment) for _ in range(10))
    assert next(filter(None, tries)) == ["/talker"]
    assert completed("rostether srv show std_srvs/Set", environment) == ["std_srvs/SetBool"]


def offered(*words: str) -> list[str]:
    """Return what a shell is given for the last of the words."""
    *before, last = words
    return [
        each.value for each in ShellComplete(rostether, {}, "rostether", "").get_completions(before, last)
    ]


def test_ports_sensors_and_verbs_after_help_are_completed(monkeypatch: pytest.MonkeyPatch) -> None:
    ports = [SimpleNamespace(path=f"/dev/ttyACM{each}", description="Uno") for each in range(2)]
    monkeypatch.setattr("rostether.transports.opening.list_serial_ports", lambda: ports)
    assert offered("serve", "/dev/tty") == ["/dev/ttyACM0", "/dev/ttyACM1"]
    assert offered("flash", "--port", "/dev/ttyACM1") == ["/dev/ttyACM1"]
    # The shell completes files itself.
    assert offered("serve", "./bo") == ["./bo"]
    assert offered("new", "sensor", "u") == ["ultrasound"]
    assert offered("help", "top") == ["topic"]
