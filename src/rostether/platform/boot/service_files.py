"""The files that start a robot's parts at boot: a systemd unit, a udev rule and a desktop entry."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from msgspec import Struct

from rostether.errors import ConfigError

SERVICE = "rostether"
# The folder for files that the parts write when they run as a system service.
STATE = Path("/var/lib") / SERVICE
# The groups that own serial ports, cameras and GPIO pins on Debian, Ubuntu and Raspberry Pi OS.
GROUPS = ("dialout", "video", "gpio", "i2c", "spi")


class Installation(Struct, frozen=True):
    """The paths of a robot's files, and the user that runs it.

    `program` is the command line that starts rostether; `user` is empty for a user's own service manager;
    `groups` are the names in GROUPS that exist on this machine.
    """

    program: tuple[str, ...]
    robot_file: Path
    is_system: bool
    user: str = ""
    groups: tuple[str, ...] = ()

    @property
    def unit(self) -> Path:
        """The path of the systemd unit."""
        if self.is_system:
            return Path("/etc/systemd/system") / f"{SERVICE}.service"
        return Path.home() / ".config/systemd/user" / f"{SERVICE}.service"

    @property
    def enabling_link(self) -> Path:
        """The path of the link to the unit that makes systemd start it, as `systemctl enable` writes it."""
        return self.unit.parent / f"{_target(self.is_system)}.wants" / self.unit.name

    @property
    def autostart(self) -> Path:
        """The path of the desktop entry that opens the dashboard at login."""
        folder = Path("/etc/xdg/autostart") if self.is_system else Path.home() / ".config/autostart"
        return folder / f"{SERVICE}-dashboard.desktop"

    @property
    def rules(self) -> Path:
        """The path of the udev rules."""
        return Path("/etc/udev/rules.d") / f"60-{SERVICE}.rules"


def default_robot_file(is_system: bool) -> Path:
    """Return the path of the robot.toml that `install` writes."""
    return Path("/etc/rostether/robot.toml") if is_system else Path.home() / ".config/rostether/robot.toml"


def files_of(installation: Installation, *, dashboard: str = "") -> Mapping[Path, str]:
    """Return the files to write; `dashboard` is the address to open at login, empty for none.

    Raises ConfigError for a path with unprintable characters.
    """
    files = {installation.unit: unit_text(installation)}
    if installation.is_system:
        files[installation.rules] = RULES
    if dashboard:
        files[installation.autostart] = _AUTOSTART.format(address=dashboard)
    return files


def path_below(root: Path | None, path: Path) -> Path:
    """Return a path below the folder `root`, such as a mounted image, or the path itself without a root.

    Raises ConfigError if a link leads out of the folder.
    """
    if root is None:
        return path
    target = root / path.relative_to("/")
    if not target.resolve().is_relative_to(root.resolve()):
        # An absolute link in an image leads to this machine.
        raise ConfigError(
            f"{target} is outside of {root}, at {target.resolve()}; replace the link with a folder"
        )
    return target


def unit_text(installation: Installation) -> str:
    """Return the systemd unit. Raises ConfigError for a path with unprintable characters.

    Source: systemd.service(5). The unit does not wait for the network: every part waits for what it needs.
    """
    words = [*installation.program, "up", str(installation.robot_file)]
    lines = [
        "[Unit]",
        "Description=rostether: the parts of this robot",
        "After=network.target",
        "StartLimitIntervalSec=0",
        "",
        "[Service]",
        "Type=notify",
        f"ExecStart={' '.join(map(_quoted, words))}",
        "WatchdogSec=20",
        "Restart=always",
        "RestartSec=2",
        # Only `up` gets the signal, and stops its parts: a second signal would end them with open files.
        "KillMode=mixed",
        "KillSignal=SIGINT",
        # The exit code of a program that SIGINT ended.
        "SuccessExitStatus=130",
        "TimeoutStopSec=10",
        "Environment=PYTHONUNBUFFERED=1",
    ]
    if installation.is_system:
        lines += [f"User={installation.user}"] if installation.user else ["DynamicUser=yes"]
        if installation.groups:
            lines.append(f"SupplementaryGroups={' '.join(installation.groups)}")
        lines += [
            f"StateDirectory={SERVICE}",
            f"CacheDirectory={SERVICE}",
            # Files that are named without a folder go here: most of the file system is read-only.
            f"WorkingDirectory={STATE}",
            f"Environment=XDG_STATE_HOME={STATE} XDG_DATA_HOME={STATE}",
            f"Environment=XDG_CACHE_HOME=/var/cache/{SERVICE}",
            "NoNewPrivileges=yes",
            "PrivateTmp=yes",
            "ProtectSystem=strict",
            "ProtectHome=read-only",
            "ProtectKernelModules=yes",
            "ProtectKernelTunables=yes",
            "ProtectControlGroups=yes",
            "RestrictRealtime=yes",
        ]
    lines += ["", "[Install]", f"WantedBy={_target(installation.is_system)}", ""]
    return "\n".join(lines)


def _target(is_system: bool) -> str:
    return "multi-user.target" if is_system else "default.target"


def _quoted(word: str) -> str:
    if not word.isprintable():
        # A line end would begin a new setting.
        raise ConfigError(f"{word!r:.200} cannot be in a systemd unit; choose another path")
    # In systemd units, % starts a specifier and $ a variable.
    word = word.replace("\\", "\\\\").replace('"', '\\"').replace("%", "%%").replace("$", "$$")
    return f'"{word}"' if any(each in word for each in " \t;'\"") else word


# ModemManager sends commands to every new serial port, which resets or disturbs boards.
RULES = """\
SUBSYSTEM=="tty", SUBSYSTEMS=="usb", ENV{ID_MM_DEVICE_IGNORE}="1", TAG+="uaccess"
"""

_AUTOSTART = """\
[Desktop Entry]
Type=Application
Name=rostether dashboard
Exec=xdg-open {address}
X-GNOME-Autostart-enabled=true
"""
