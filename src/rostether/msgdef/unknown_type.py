"""The one line for a type that nobody knows: which package is missing, or which name was meant."""

from __future__ import annotations

from typing import Protocol

from rostether.msgdef.definition_files import Kind

_HOW = "give its folder with --msg-path DIR or put it on ROS_PACKAGE_PATH"
_NOUNS = {Kind.MESSAGE: "message", Kind.SERVICE: "service", Kind.ACTION: "action"}


class _Names(Protocol):
    def packages(self) -> list[str]: ...
    def messages(self, package: str | None = None) -> list[str]: ...
    def services(self, package: str | None = None) -> list[str]: ...


def explain_unknown(names: _Names, kind: Kind, package: str, short_name: str) -> str:
    """Say why `package/short_name` is unknown and what to do."""
    wanted = f"{package}/{short_name}"
    packages = names.packages()
    if package not in packages:
        return f"no package {package!r} is known for {wanted}; {_meant(package, packages)}{_HOW}"
    messages, services = names.messages(package), names.services(package)
    candidates, others = (messages, services) if kind is Kind.MESSAGE else (services, messages)
    noun = _NOUNS[kind]
    if wanted in others:
        return f"{wanted} is a {'service' if kind is Kind.MESSAGE else 'message'}, not a {noun}"
    return (
        f"package {package!r} has no {noun} {short_name!r}; {_meant(wanted, candidates)}if another version of"
        f" the package has it, {_HOW}"
    )


def _meant(name: str, candidates: list[str]) -> str:
    import difflib

    close = difflib.get_close_matches(name, candidates, n=1)
    return f"did you mean {close[0]!r}? Else " if close else ""
