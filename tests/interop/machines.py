"""Simulates several machines on one: each is a network namespace with its own loopback and address.

They need no root if the system permits users to create namespaces.
"""

from __future__ import annotations

import functools
import os
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

_IS_ROOT = os.getuid() == 0
_UNSHARE = ("unshare", *(() if _IS_ROOT else ("--user", "--map-root-user")), "--net", "--mount")
_ENTER = ("nsenter", *(() if _IS_ROOT else ("--user", "--preserve-credentials")), "--net", "--mount")


@functools.cache
def missing_namespaces() -> str:
    """Return why machines are not possible here, or an empty string."""
    needed = {"ip": "iproute2", "mount": "mount", "unshare": "util-linux", "nsenter": "util-linux"}
    for program, package in needed.items():
        if shutil.which(program) is None:
            return f"no {program} (apt install {package})"
    script = """mount -t tmpfs none /run
        ip netns add probe
        ip link add switch type bridge
        ip link add here type veth peer name there netns probe"""
    probe = subprocess.run(
        [*_UNSHARE, "sh", "-ec", script],
        capture_output=True,
        text=True,
        check=False,
    )
    return f"no network namespaces: {probe.stderr.strip()}" if probe.returncode else ""


class Machines:
    """A network of machines; `on` returns the command prefix that runs a command on one of them."""

    def __init__(self, names: Sequence[str], holder: subprocess.Popen[bytes]) -> None:
        self._names = names
        self._enter = (*_ENTER, "--wd=.", "--target", str(holder.pid))

    def address(self, name: str) -> str:
        """Return the address of a machine; each can resolve the names of the others."""
        return "127.0.0.1" if name == "localhost" else f"10.77.0.{self._names.index(name) + 1}"

    def switch(self, command: str) -> None:
        """Change the switch (`switch`) or one of its ports (`to_NAME`); `command` follows `ip link set`."""
        subprocess.run([*self._enter, "ip", "link", "set", *command.split()], check=True)

    def on(self, name: str) -> tuple[str, ...]:
        """Return the prefix of a command that runs on a machine."""
        return (*self._enter, "nsenter", f"--net=/run/netns/{name}")

    def build(self) -> None:
        """Create the machines, and connect them to a switch."""
        hosts = "".join(f"{self.address(name)} {name}\\n" for name in ("localhost", *self._names))
        lines = [
            "mount -t tmpfs none /run",
            f"printf '{hosts}' > /run/hosts",
            "mount --bind /run/hosts /etc/hosts",
            "ip link add switch type bridge",
            "ip link set switch up",
        ]
        for name in self._names:
            lines += [
                f"ip netns add {name}",
                f"ip link add to_{name} type veth peer name net netns {name}",
                f"ip link set to_{name} master switch up",
                f"ip -n {name} addr add {self.address(name)}/24 dev net",
                f"ip -n {name} link set net up",
                f"ip -n {name} link set lo up",
            ]
        subprocess.run([*self._enter, "sh", "-ec", "\n".join(lines)], check=True)


@contextmanager
def own_loopback() -> Iterator[tuple[str, ...] | None]:
    """Create a loopback where every port is free. Yield the prefix of a command that runs on it.

    Yield None if the system allows no network namespace.
    """
    holder = subprocess.Popen(
        [*_UNSHARE, "sh", "-ec", "ip link set lo up; echo ready; exec sleep infinity"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    try:
        assert holder.stdout is not None
        is_ready = holder.stdout.readline() == b"ready\n"
        yield (*_ENTER, "--wd=.", "--target", str(holder.pid)) if is_ready else None
    finally:
        holder.kill()
        holder.communicate(timeout=60)


@contextmanager
def machines(*names: str) -> Iterator[Machines]:
    """Create machines until the block ends; the caller ends the programs that it started on them."""
    script = "echo ready; exec sleep infinity"
    holder = subprocess.Popen([*_UNSHARE, "sh", "-c", script], stdout=subprocess.PIPE)
    try:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b"ready\n"
        network = Machines(names, holder)
        network.build()
        yield network
    finally:
        holder.kill()
        holder.communicate(timeout=60)
