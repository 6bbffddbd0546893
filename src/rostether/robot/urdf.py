"""URDF: the XML that describes a robot's links and joints.

It is read like urdfdom does: an error in a joint or in the tree is raised, an invalid shape is only reported.
Unknown elements are ignored, so a .xacro file without macros also loads.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from rostether.errors import RobotModelError
from rostether.mechanisms.xml_tree import XmlElement, parse_xml, place_first
from rostether.robot.robot_model import Joint, JointType, Limits, Mimic, RobotModel
from rostether.robot.transform import Transform, Vector, quaternion_from_rpy

# The largest robot descriptions have a few MB.
MAX_XML_BYTES = 64 << 20

# A thousand times the links of real robots.
MAX_LINKS = 100_000

_NEED_LIMITS = frozenset({JointType.REVOLUTE, JointType.PRISMATIC})
_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def parse_urdf(text: str | bytes, *, file: str = "robot_description") -> RobotModel:
    """Return the robot that a URDF describes. Raises RobotModelError with file and line."""
    root = parse_robot_xml(text, file=file)
    if root.tag != "robot":
        what = "COLLADA is not supported; convert it to URDF" if root.tag == "COLLADA" else "it is not URDF"
        raise root.error(f"the root element is <{root.tag}>, not <robot>: {what}")
    return _robot(root)


def parse_robot_xml(text: str | bytes, *, file: str) -> XmlElement:
    """Return the root element of a URDF or xacro file. Raises RobotModelError with file and line."""
    data, encoding = (text.encode(), "utf-8") if isinstance(text, str) else (text, None)
    return parse_xml(
        data.lstrip(),
        file=file,
        max_bytes=MAX_XML_BYTES,
        what="a robot description",
        make_error=place_first(RobotModelError, file),
        encoding=encoding,
    )


def _robot(robot: XmlElement) -> RobotModel:
    name = robot.get("name")
    if not name:
        raise robot.error('the robot has no name; write <robot name="...">')
    if robot.get("version") not in (None, "1.0", "1"):
        raise robot.error(f"version {robot.get('version')} is not supported; only 1.0 is")
    links: dict[str, None] = {}
    for element in robot.all("link"):
        link = element.get("name") or ""
        if link in links:
            raise element.error(f"link {link!r} is not unique; rename one")
        links[link] = None
    if not links:
        raise robot.error(f"the robot has no <link>{_xacro_hint(robot) or '; add one'}")
    if len(links) > MAX_LINKS:
        raise robot.error(f"the robot has more than {MAX_LINKS} links; simplify it")
    joints: dict[str, Joint] = {}
    children: dict[str, str] = {}
    for element in robot.all("joint"):
        joint = _joint(element)
        if joint.name in joints:
            raise element.error(f"joint {joint.name!r} is not unique; rename one")
        for role, link_name in (("parent", joint.parent), ("child", joint.child)):
            if link_name not in links:
                raise element.error(
                    f"{role} link {link_name!r} of joint {joint.name!r} does not exist"
                    f"{_xacro_hint(robot) or '; add it, or correct the name'}"
                )
        if joint.child in children:
            other = children[joint.child]
            raise element.error(
                f"link {joint.child!r} is the child of two joints, {other!r} and {joint.name!r}; remove one"
            )
        children[joint.child] = joint.name
        joints[joint.name] = joint
    return RobotModel(name, _root(robot, links, children), tuple(links), joints, _problems(robot))


def _root(robot: XmlElement, links: Iterable[str], children: dict[str, str]) -> str:
    roots = [name for name in links if name not in children]
    if not roots:
        raise robot.error(
            "no root link: every link is the child of a joint, so they form a loop; remove a joint"
        )
    if len(roots) > 1:
        raise robot.error(
            f"two root links, {roots[0]!r} and {roots[1]!r}; connect them with a joint{_xacro_hint(robot)}"
        )
    return roots[0]


def _joint(element: XmlElement) -> Joint:
    name = element.get("name")
    if not name:
        raise element.error('a joint has no name; write <joint name="..." ...>')
    kind = element.get("type")
    if kind is None:
        raise element.error(f"joint {name!r} has no type; known: {', '.join(JointType)}")
    try:
        joint_type = JointType(kind)
    except ValueError:
        raise element.error(
            f"joint {name!r} has the unknown type {kind!r}; known: {', '.join(JointType)}"
        ) from None
    ends = [_end(element, name, role) for role in ("parent", "child")]
    limits = _limits(element, name)
    if limits is None and joint_type in _NEED_LIMITS:
        raise element.error(
            f"{kind} joint {name!r} has no limits; write "
            '<limit lower="..." upper="..." effort="..." velocity="..."/>'
        )
    return Joint(
        name=name,
        type=joint_type,
        parent=ends[0],
        child=ends[1],
        origin=_origin(element, f"joint {name!r}"),
        axis=_axis(element, name, joint_type),
        limits=limits,
        mimic=_mimic(element, name),
    )


def _end(element: XmlElement, name: str, role: str) -> str:
    end = element.first(role)
    link = end.get("link") if end is not None else None
    if link is None:
        raise element.error(f'joint {name!r} has no {role} link; write <{role} link="..."/>')
    return link


def _axis(element: XmlElement, name: str, joint_type: JointType) -> Vector:
    axis = element.first("axis")
    given = axis.get("xyz") if axis is not None else None
    if axis is None or given is None or joint_type in (JointType.FIXED, JointType.FLOATING):
        return 1.0, 0.0, 0.0
    direction = _vector(axis, given, f"the axis of joint {name!r}")
    if not math.hypot(*direction):
        raise axis.error(f"the axis of joint {name!r} is zero; set a direction")
    return direction


def _limits(element: XmlElement, name: str) -> Limits | None:
    limit = element.first("limit")
    safety = element.first("safety_controller")
    if limit is None:
        return None
    what = f"the limit of joint {name!r}"
    # URDF requires these two.
    for attribute in ("effort", "velocity"):
        _number(limit, attribute, what)
    soft = [
        None if safety is None or safety.get(each) is None else _number(safety, each, f"joint {name!r}")
        for each in ("soft_lower_limit", "soft_upper_limit")
    ]
    return Limits(_number(limit, "lower", what, 0.0), _number(limit, "upper", what, 0.0), *soft)


def _mimic(element: XmlElement, name: str) -> Mimic | None:
    mimic = element.first("mimic")
    if mimic is None:
        return None
    joint = mimic.get("joint")
    if joint is None:
        raise mimic.error(f'joint {name!r} mimics no joint; write <mimic joint="..."/>')
    what = f"the mimic of joint {name!r}"
    return Mimic(joint, _number(mimic, "multiplier", what, 1.0), _number(mimic, "offset", what, 0.0))


def _xacro_hint(robot: XmlElement) -> str:
    if any(child.tag.startswith("xacro:") for child in robot.children):
        return '; this is xacro; expand it first, e.g. with command="$(find xacro)/xacro FILE"'
    return ""


def _problems(robot: XmlElement) -> tuple[str, ...]:
    """Return the errors in the robot's materials, and in each link's name, shapes and masses."""
    problems: list[str] = []

    def attempt(check: Callable[..., None], *arguments: object) -> None:
        try:
            check(*arguments)
        except RobotModelError as error:
            problems.append(str(error))

    for material in robot.all("material"):
        attempt(_check_color, material)
    checks = {"visual": _check_shape, "collision": _check_shape, "inertial": _check_inertial}
    for link in robot.all("link"):
        name = link.get("name") or ""
        if not name:
            problems.append(str(link.error('a link has no name; write <link name="...">')))
        for kind, check in checks.items():
            for each in link.all(kind):
                attempt(check, each, f"{kind} of link {name!r}")
    return tuple(problems)


def _check_shape(element: XmlElement, what: str) -> None:
    geometry = element.first("geometry")
    form = next(iter(geometry.children), None) if geometry is not None else None
    if form is None:
        raise element.error(f"{what} has no geometry; write <geometry>, for example with <box size=...>")
    _origin(element, what)
    material = element.first("material")
    if material is not None:
        _check_color(material)
    _check_form(form, what)


def _check_form(form: XmlElement, what: str) -> None:
    match form.tag:
        case "box":
            _vector(form, form.get("size") or "", f"the size of {what}")
        case "cylinder":
            _number(form, "radius", what)
            _number(form, "length", what)
        case "sphere":
            _number(form, "radius", what)
        case "mesh":
            if not form.get("filename"):
                raise form.error(f'the mesh of {what} has no filename; write <mesh filename="..."/>')
            _vector(form, form.get("scale") or "1 1 1", f"the scale of {what}")
        case _:
            raise form.error(f"{what} is a <{form.tag}>; known: box, cylinder, sphere, mesh")


def _check_color(material: XmlElement) -> None:
    color = material.first("color")
    if color is not None:
        what = f"the rgba of material {material.get('name')!r}"
        rgba = _numbers(color, color.get("rgba") or "", what, 4)
        if not all(0 <= each <= 1 for each in rgba):
            raise color.error(f"{what} is not from 0 to 1; divide by 255")


def _check_inertial(element: XmlElement, what: str) -> None:
    mass, inertia = element.first("mass"), element.first("inertia")
    if mass is None or inertia is None:
        raise element.error(f"{what} needs <mass> and <inertia>")
    for name in _INERTIA:
        _number(inertia, name, what)
    _number(mass, "value", what)
    _origin(element, what)


def _number(element: XmlElement, name: str, what: str, default: float | None = None) -> float:
    """Return an attribute; without a default, it is required."""
    text = element.get(name)
    if text is not None:
        return _parsed(element, text, f"{name} of {what}")
    if default is None:
        raise element.error(f"{what} has no {name}; add it")
    return default


def _numbers(element: XmlElement, text: str, what: str, count: int) -> list[float]:
    found = [_parsed(element, word, what) for word in text.split()]
    if len(found) != count:
        raise element.error(f"{what} has {len(found)} numbers ({text!r}), not {count}")
    return found


def _vector(element: XmlElement, text: str, what: str) -> Vector:
    x, y, z = _numbers(element, text, what, 3)
    return x, y, z


def _origin(element: XmlElement, what: str) -> Transform:
    """Return the transform in the <origin xyz rpy> of an element; missing values are zero."""
    found = element.first("origin")
    if found is None:
        return Transform()
    translation = _vector(found, found.attributes.get("xyz", "0 0 0"), f"the origin of {what}")
    rpy = _vector(found, found.attributes.get("rpy", "0 0 0"), f"the rpy of {what}")
    return Transform(translation, quaternion_from_rpy(*rpy)).normalized()


def _parsed(element: XmlElement, text: str, what: str) -> float:
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if not math.isfinite(found):
        hint = "; expand this xacro first" if "${" in text else ""
        raise element.error(f"{what} is {text!r}, not a number{hint}")
    return found
