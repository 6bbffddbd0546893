"""The content of a URDF: links, joints, and their tree."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

from msgspec import Struct

from rostether.errors import RobotModelError
from rostether.robot.transform import IDENTITY, Transform, Vector


class JointType(StrEnum):
    """The possible motion of a child link: the attribute `type` in URDF."""

    REVOLUTE = "revolute"
    CONTINUOUS = "continuous"
    PRISMATIC = "prismatic"
    FIXED = "fixed"
    FLOATING = "floating"
    PLANAR = "planar"


ONE_DEGREE_OF_FREEDOM = frozenset({JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC})


class Limits(Struct, frozen=True):
    """The range of a joint in radians or meters; `soft_*` is the range of its safety controller, if given."""

    lower: float = 0.0
    upper: float = 0.0
    soft_lower: float | None = None
    soft_upper: float | None = None


class Mimic(Struct, frozen=True):
    """A joint that follows another one: multiplier * position + offset."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


class Joint(Struct, frozen=True):
    """One joint; `origin` is the pose of the child at position zero, `axis` is in the child's frame."""

    name: str
    type: JointType
    parent: str
    child: str
    origin: Transform = IDENTITY
    axis: Vector = (1.0, 0.0, 0.0)
    limits: Limits | None = None
    mimic: Mimic | None = None


@dataclass(frozen=True)
class RobotModel:
    """A tree of links; links and joints are in the order of the file.

    `problems` lists errors in shapes and inertias, which do not affect the poses of links.
    """

    name: str
    root: str
    links: tuple[str, ...]
    joints: dict[str, Joint]
    problems: tuple[str, ...] = ()

    @cached_property
    def mimics(self) -> dict[str, Mimic]:
        """The joints that follow others, by name."""
        return {name: joint.mimic for name, joint in self.joints.items() if joint.mimic is not None}

    def joints_below(self, link: str) -> list[Joint]:
        """Return the joints whose parent is a link, sorted by name."""
        return self._below.get(link, [])

    @cached_property
    def _below(self) -> dict[str, list[Joint]]:
        below: dict[str, list[Joint]] = {}
        for _, joint in sorted(self.joints.items()):
            below.setdefault(joint.parent, []).append(joint)
        return below


def mimic_chain(
    mimics: Mapping[str, Mimic], name: str, given: Container[str] = ()
) -> tuple[float, float, str]:
    """Follow a chain of mimicking joints: return factor, offset and name of the joint at its end.

    Joints in `given` end the chain. Raises RobotModelError for a cycle.
    """
    factor, offset, passed = 1.0, 0.0, [name]
    mimic = mimics.get(name)
    while mimic is not None:
        offset += factor * mimic.offset
        factor *= mimic.multiplier
        if mimic.joint in passed:
            cycle = ", ".join([*passed, mimic.joint])
            raise RobotModelError(f"joints mimic each other in a cycle: {cycle}; remove one of the mimics")
        passed.append(mimic.joint)
        mimic = None if mimic.joint in given else mimics.get(mimic.joint)
    return factor, offset, passed[-1]
