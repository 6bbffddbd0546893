"""`rostether up`, `install`, `uninstall` and `status`."""

from __future__ import annotations

import errno
import os
import shlex
import signal
import subprocess
from pathlib import Path

import pytest

from interop.machines import missing_namespaces, own_loopback
from interop.ros1_peers import free_port
from programs import ROSTETHER, start_program, started
from unit.cli.command_shell import Shell


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("HOME", "/home/me")
    monkeypatch.delenv("SUDO_USER", raising=False)
    return tmp_path / "image"


def files(root: Path) -> set[str]:
    return {str(path.relative_to(root)) for path in root.rglob("*") if path.is_file()}


@pytest.mark.systemd
@pytest.mark.parametrize("scope", ["--system", "--user"])
def test_install_again_and_uninstall(scope: str, root: Path, shell: Shell) -> None:
    place = ("--root", str(root), scope)
    assert shell("status", *place).code == 1
    shell.output("install", "--machine", "both", "--name", "r1", "--gui", *place)
    unit = next(root.rglob("rostether.service"))
    verified = subprocess.run(
        ["systemd-analyze", "verify", unit], capture_output=True, text=True, check=False
    )
    assert (verified.returncode, verified.stderr) == (0, "")
    assert len(files(root)) == (4 if scope == "--system" else 3)
    # The image starts it at boot.
    (link,) = root.rglob("*.target.wants/*")
    assert root / link.readlink().relative_to("/") == unit
    assert shell.output("status", *place).startswith("r1: core, sensors, dashboard, boards")
    robot = next(root.rglob("robot.toml"))
    robot.write_text('name = "edited"\n[parts]\nboards = "serve"\n')
    # An upgrade keeps what the user wrote.
    shell.output("install", *place)
    assert shell.output("status", *place).startswith("edited: boards")
    robot.write_text('[parts]\nboards = "serve"\na = "core --lissten 0"\n')
    assert "parts.a: No such option '--lissten'" in shell("status", *place).err
    shell.output("uninstall", *place)
    assert not files(root)
    assert not link.is_symlink()
    assert shell.output("uninstall", *place) == "nothing is installed\n"


def test_a_dry_run_writes_nothing(root: Path, shell: Shell) -> None:
    words = ["install", "--machine", "robot", "--name", "r 2", "--core", "base.local", "--root", str(root)]
    words += ["--interface", "wlan0"]
    shown = shell.output(
        *words, "--system", "--board", "/dev/ttyACM0", "--part", "eye=role camera", "--dry-run"
    )
    assert 'master = "http://base.local:11311"' in shown
    assert 'boards = "serve /dev/ttyACM0"' in shown
    assert 'eye = "role camera"' in shown
    assert 'interface = "wlan0"' in shown
    assert not root.exists()


def test_a_link_in_an_image_does_not_lead_to_this_machine(root: Path, shell: Shell, tmp_path: Path) -> None:
    (root / "etc").mkdir(parents=True)
    (tmp_path / "outside").mkdir()
    (root / "etc/systemd").symlink_to(tmp_path / "outside")
    words = ["install", "--machine", "both", "--name", "r", "--root", str(root), "--system"]
    assert "is outside of" in shell.failure(*words)
    assert not list((tmp_path / "outside").iterdir())


def test_wrong_words(root: Path, shell: Shell, tmp_path: Path) -> None:
    place = ("--root", str(root), "--system")
    assert "There is no terminal to ask; give --machine" in shell.failure("install", *place)
    assert "must be NAME=COMMAND" in shell.failure(
        "install", "--machine", "base", "--name", "b", "--part", "x", *place
    )
    wrong = tmp_path / "wrong.toml"
    wrong.write_text("[parts]\na = 'rm x'\n")
    assert "parts.a: must be a rostether command" in shell.failure("install", "--from", str(wrong), *place)
    assert "parts.a: must be a rostether command" in shell.failure("up", str(wrong))
    wrong.write_bytes(b"\xff")
    assert f"{wrong}: not UTF-8 text at byte" in shell.failure("install", "--from", str(wrong), *place)
    assert "write the name of a network interface, such as wlan0, not 'wlan0 eth0'" in shell.failure(
        "install", "--machine", "both", "--name", "r", "--interface", "wlan0 eth0", *place
    )
    nested = tmp_path / "nested.toml"
    nested.write_text("[parts]\na = 'up robot.toml'\n")
    assert "parts.a: must be a rostether command" in shell.failure("up", str(nested))
    assert "parts.a: must be a rostether command" in shell.failure("install", "--from", str(nested), *place)
    words = ("install", "--machine", "both", "--name", "r", "--board", "demo:")
    assert "the new robot.toml:parts.boards: unknown kind of link 'demo'" in shell.failure(*words, *place)
    assert not root.exists()


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("[parts]\na = 'serve /dev/ttyACM0 tpc://:11411'", "parts.a: unknown kind of link 'tpc'"),
        ("[parts]\na = 'core --lissten 0.0.0.0'", "parts.a: No such option"),
        ("[parts]\na = 'core'\nb = 'role gpss'", "parts.b: no such command 'gpss'; did you mean gps"),
        ("[parts]\na = 'topic'", "parts.a: give a command after topic"),
        (
            "[parts]\na = 'dashboard --port x'",
            "parts.a: Invalid value for '-p' / '--port': 'x' is not a whole number; see `rostether dash",
        ),
        ("[parts]\na = 'core --version'", "parts.a: No such option"),
        ("address = '10.0.0.256'\n[parts]\na = 'core'", " ROS_IP='10.0.0.256' is not an IP address"),
        ("master = 'http://base'\n[parts]\na = 'core'", " ROS_MASTER_URI: 'http://base' is not a URI"),
    ],
)
def test_a_part_that_cannot_start(text: str, reason: str, shell: Shell, tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text(text)
    assert f"{robot}:{reason}" in shell.failure("up", str(robot), "--check")


def test_parts_that_can_start(shell: Shell, tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text(
        """
        [parts]
        board = "serial-node /dev/ttyACM0 _baud:=115200 __name:=arm"
        boards = "serve '/dev/ttyACM1?name=arm' --config away.toml --dashboard"
        play = "bag play away.bag --loop"
        gps = "rostether role gps _port:=/dev/ttyACM2 _frame_id:=gps --ros2"
        robot = "launch away.launch"
        """
    )
    assert shell.output("up", str(robot), "--check") == f"{robot}: board, boards, play, gps, robot\n"


async def test_a_part_with_wrong_arguments_ends_no_other_part(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    port = free_port()
    robot.write_text(
        f'master = "http://127.0.0.1:{port}"\n'
        f'[parts]\nwrong = "core --lissten 0"\ncore = "core --port {port}"\n'
    )
    async with started("up", str(robot)) as up:
        await up.wait_for("wrong | its arguments are wrong: it does not start again")
        await up.wait_for("core  | Press Ctrl-C to stop")
        up.process.send_signal(signal.SIGINT)
        await up.wait_for(f"rostether: error: {robot}: did not run: wrong")
        assert await up.process.wait() == 1


async def test_the_address_is_that_of_the_interface(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    port = free_port()
    parts = f'[parts]\ncore = "core --port {port}"\n'
    robot.write_text(f'interface = "lo"\nmaster = "http://127.0.0.1:{port}"\n{parts}')
    async with started("up", str(robot)) as up:
        await up.wait_for("Press Ctrl-C to stop")
        (core,) = _children(up.process.pid, "rostether core")
        environ = Path(f"/proc/{core}/environ").read_text().split("\0")
        assert {"ROS_IP=127.0.0.1", "ROSTETHER_INTERFACE=lo"} <= set(environ)
    robot.write_text(f'interface = "away0"\n{parts}')
    async with started("up", str(robot)) as up:
        await up.wait_for("waiting until the network interface away0 has an address")


@pytest.mark.skipif(bool(missing_namespaces()), reason=missing_namespaces())
async def test_the_parts_start_again_at_another_address(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text('interface = "lo"\n[parts]\ncore = "core"\n')
    with own_loopback() as enter:
        assert enter is not None
        up = await start_program(*enter, *ROSTETHER, "up", str(robot), environment=dict(os.environ))
        try:
            await up.wait_for("Press Ctrl-C to stop")
            subprocess.run([*enter, "ip", "address", "del", "127.0.0.1/8", "dev", "lo"], check=True)
            subprocess.run([*enter, "ip", "address", "add", "127.0.0.9/8", "dev", "lo"], check=True)
            await up.wait_for("the network interface lo has a new address; all parts start again")
            await up.wait_for("ROS_MASTER_URI=http://127.0.0.9:11311/")
        finally:
            await up.stop()


def _children(parent: int, command: str) -> list[int]:
    """Return the processes that a process has started, by a part of their command line."""
    numbers = Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
    return [int(each) for each in numbers if command.encode() in command_line(int(each))]


def command_line(number: int) -> bytes:
    return Path(f"/proc/{number}/cmdline").read_bytes().replace(b"\0", b" ")


async def test_the_line_of_the_unit_runs_the_parts(root: Path, shell: Shell, tmp_path: Path) -> None:
    port = free_port()
    robot = tmp_path / "robot.toml"
    robot.write_text(
        f'name = "r1"\nmaster = "http://127.0.0.1:{port}"\n[parts]\n'
        # A board that is missing at boot is not a failure.
        f'boards = "serve /dev/serial/by-id/usb-away"\ncore = "core --port {port}"\n'
    )
    assert shell.output("up", str(robot), "--check") == f"{robot}: boards, core\n"
    shell.output("install", "--from", str(robot), "--root", str(root), "--system")
    unit = (root / "etc/systemd/system/rostether.service").read_text()
    line = next(each for each in unit.splitlines() if each.startswith("ExecStart="))
    words = shlex.split(line.removeprefix("ExecStart="))
    verb = words[words.index("up") :]
    assert verb == ["up", "/etc/rostether/robot.toml"]
    async with started("up", str(root / verb[1].removeprefix("/"))) as up:
        await up.wait_for("Press Ctrl-C to stop")
        await up.wait_for("usb-away")
        # The other parts join the master of `core`.
        assert "boards | [INFO]" in up.text
        assert not [line for line in up.lines if line.startswith("boards") and "Started a ROS master" in line]
        (core,) = _children(up.process.pid, "rostether core")
        os.kill(core, signal.SIGKILL)
        await up.wait_for("core   | ended (signal SIGKILL); restarts in 1 s")


@pytest.mark.parametrize("words", [("install", "--machine", "both", "--name", "r"), ("uninstall",)])
def test_files_that_cannot_be_changed(
    root: Path, shell: Shell, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    def refuse(path: Path, *_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    place = ("--root", str(root), "--system")
    shell.output("install", "--machine", "both", "--name", "r", *place)
    # Root may change everything, so permissions cannot be tried out.
    for method in ("write_text", "unlink"):
        monkeypatch.setattr(Path, method, refuse)
    line = shell.failure(*words, *place)
    assert line.startswith(f"cannot change {root}/etc/")
    assert line.endswith(": Permission denied; run the command with sudo, or add --user")
