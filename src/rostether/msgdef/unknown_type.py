"""The error line for an unknown type: which package is missing, or which name was meant."""

from __future__ import annotations

from typing import Protocol

from rostether.mechanisms.text import did_you_mean
from rostether.msgdef.definition_files import Kind, bundled_file, is_type_name
from rostether.packages.package_xml import is_package_name

# The packages that are searched for a type without its package, in this order.
_COMMON_PACKAGES = ("std_msgs", "std_srvs", "geometry_msgs", "sensor_msgs", "nav_msgs")
HOW_TO_GIVE = "give its folder with --msg-path DIR or put it on ROS_PACKAGE_PATH"


class _KnownNames(Protocol):
    """The full names in a registry: of all packages, or of one."""

    def packages(self) -> list[str]: ...
    def messages(self, package: str | None = None) -> list[str]: ...
    def services(self, package: str | None = None) -> list[str]: ...


def explain_unknown(known: _KnownNames, kind: Kind, package: str, short_name: str) -> str:
    """Return why `package/short_name` is unknown and what to do."""
    wanted = f"{package}/{short_name}"
    packages = known.packages()
    if package not in packages:
        meant = did_you_mean(package, packages, then=" Otherwise, ")
        return f"no package {package!r} is known for {wanted}; {meant}{HOW_TO_GIVE}"
    candidates, others = known.messages(package), known.services(package)
    noun, other_noun = "message", "service"
    if kind is Kind.SERVICE:
        candidates, others, noun, other_noun = others, candidates, other_noun, noun
    if wanted in others:
        return f"{wanted} is a {other_noun}, not a {noun}"
    short_names = [each.partition("/")[2] for each in candidates]
    meant = did_you_mean(short_name, short_names, prefix=f"{package}/", then=" Otherwise, ")
    newer = f"if a newer version has it, {HOW_TO_GIVE}"
    return f"package {package!r} has no {noun} {short_name!r}; {meant}{newer}"


def example_name(kind: Kind, short_name: str) -> str:
    """Return the full name for one without a package or with ROS 2's `msg`; otherwise a common type."""
    package, _, last = short_name.partition(f"/{kind}/")
    if is_package_name(package) and is_type_name(last):
        return f"{package}/{last}"
    packages = _COMMON_PACKAGES if is_type_name(short_name) else ()
    meant = [each for each in packages if bundled_file(each, kind, short_name) is not None]
    if meant:
        return f"{meant[0]}/{short_name}"
    return "std_srvs/SetBool" if kind is Kind.SERVICE else "std_msgs/String"
