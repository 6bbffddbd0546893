"""Three robots: an arm, a gripper with mimicking fingers, and a rover with all other features."""

from __future__ import annotations


def joint(name: str, kind: str, parent: str, child: str, inside: str = "") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'
    )


def robot(name: str, links: str, joints: str) -> str:
    named = "".join(f'<link name="{link}"/>' for link in links.split())
    return f'<?xml version="1.0"?>\n<robot name="{name}">{named}{joints}</robot>'


LIMIT = '<limit lower="-1.5" upper="2.5" effort="1" velocity="1"/>'

ARM = robot(
    "arm",
    "base turret upper fore hand",
    joint(
        "j0",
        "revolute",
        "base",
        "turret",
        '<origin xyz="0 0 0.04" rpy="0 0 0.3"/><axis xyz="0 0 1"/>' + LIMIT,
    )
    + joint(
        "j1",
        "revolute",
        "turret",
        "upper",
        '<origin xyz="0.01 0.02 0.025" rpy="1.5707963 0 -0.4"/><axis xyz="0 1 0"/>' + LIMIT,
    )
    + joint(
        "j2",
        "revolute",
        "upper",
        "fore",
        '<origin xyz="0 0 0.08" rpy="0.1 0.2 0.3"/><axis xyz="1 2 3"/>' + LIMIT,
    )
    + joint("wrist", "fixed", "fore", "hand", '<origin xyz="0.08 0 0" rpy="3.1415926 0 1.57"/>'),
)

GRIPPER = robot(
    "gripper",
    "palm slide left right tip",
    joint(
        "lift",
        "prismatic",
        "palm",
        "slide",
        '<origin xyz="0.1 0.2 0.3" rpy="0.5 -0.5 1"/><axis xyz="0 3 4"/>'
        '<limit lower="0.02" upper="0.2" effort="1" velocity="1"/>'
        '<safety_controller k_velocity="1" soft_lower_limit="0.05" soft_upper_limit="0.15"/>',
    )
    + joint("left", "revolute", "slide", "left", '<axis xyz="0 0 1"/>' + LIMIT)
    + joint(
        "right",
        "revolute",
        "slide",
        "right",
        '<axis xyz="0 0 1"/>' + LIMIT + '<mimic joint="left" multiplier="-1.5" offset="0.25"/>',
    )
    + joint(
        "tip",
        "continuous",
        "right",
        "tip",
        '<origin xyz="0 0 0.01"/><axis xyz="0 1 0"/><mimic joint="right" multiplier="2"/>',
    ),
)

ROVER = robot(
    "rover",
    "foot body wheel_l wheel_r mast sled drone",
    joint("root", "fixed", "foot", "body", '<origin xyz="0 0 0.3" rpy="2.0943951023931953 0 0"/>')
    + joint(
        "wheel_left",
        "continuous",
        "body",
        "wheel_l",
        '<origin xyz="0 0.2 0" rpy="-1.5707963267948966 0 0"/><axis xyz="0 0 1"/>',
    )
    + joint(
        "wheel_right",
        "continuous",
        "body",
        "wheel_r",
        '<origin xyz="0 -0.2 0" rpy="3.141592653589793 0 3.141592653589793"/><axis xyz="0 0 -1"/>',
    )
    + joint(
        "mast",
        "prismatic",
        "body",
        "mast",
        '<origin rpy="0 1.5707963267948966 0"/><axis xyz="-1 0 0"/>'
        '<limit lower="-0.5" upper="-0.1" effort="1" velocity="1"/>',
    )
    + joint("sled", "planar", "body", "sled", '<origin xyz="1 2 3" rpy="0.1 0.2 0.3"/>')
    + joint("drone", "floating", "body", "drone"),
)

ROBOTS = {"arm": ARM, "gripper": GRIPPER, "rover": ROVER}
