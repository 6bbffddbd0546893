"""An element of a launch file in its scope: reads its attributes, and adds them to the plan."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any

from msgspec import Struct, field

from rostether.errors import ConfigError, InvalidNameError, LaunchError
from rostether.launch.plan import LaunchPlan
from rostether.launch.scope import Scope
from rostether.launch.substitution import LaunchContext, substitute
from rostether.launch.values import as_bool, check_value
from rostether.mechanisms.xml_tree import XmlElement
from rostether.names.graph_name import SEPARATOR, as_namespace, canonical, is_legal_name, join, namespace_of

# The limit of all texts of a launch together; ten thousand included files may each have long texts.
MAX_SUBSTITUTED_CHARS = 64 << 20

_CONDITIONS = ("if", "unless")


class Reading(Struct):
    """What all elements of a launch share: the plan so far, and the length of all substituted texts."""

    context: LaunchContext
    plan: LaunchPlan = field(default_factory=LaunchPlan)
    substituted_chars: int = 0


class Tag(Struct, frozen=True):
    """One element and the scope of its attributes. All methods raise LaunchError, ConfigError."""

    element: XmlElement
    scope: Scope
    reading: Reading

    def at(self, element: XmlElement, scope: Scope) -> Tag:
        """Return another element of the launch."""
        return Tag(element, scope, self.reading)

    def substitute(self, text: str) -> str:
        """Return a text with all substitutions made."""
        result = substitute(text, self.scope, self.reading.context)
        if result is not text:
            self.reading.substituted_chars += len(result)
            if self.reading.substituted_chars > MAX_SUBSTITUTED_CHARS:
                raise LaunchError(
                    f"all $(...) together have more than {MAX_SUBSTITUTED_CHARS} characters; shorten the "
                    "arguments"
                )
        return result

    def optional(self, name: str) -> str | None:
        """Return an attribute's value; None if it is missing."""
        text = self.element.attributes.get(name)
        return None if text is None else self.substitute(text)

    def required(self, name: str) -> str:
        """Return the value of a required attribute."""
        text = self.optional(name)
        if text is None and name == "type" and "exec" in self.element.attributes:
            raise LaunchError(
                "exec= is of ROS 2; in a ROS 1 launch file write type=, or start the file with `ros2 launch`"
            )
        if text is None:
            raise LaunchError(f"<{self.element.tag}> needs the attribute {name}=; add it")
        return text

    def flag(self, name: str) -> bool:
        """Return a boolean attribute; False if it is missing."""
        text = self.optional(name)
        if text is not None and text.lower() not in ("true", "false"):
            raise LaunchError(f"{name}={text!r:.200} is not true or false; write one of them")
        return text is not None and text.lower() == "true"

    def number(self, name: str) -> float:
        """Return a numeric attribute; 0 if it is missing."""
        text = self.optional(name)
        try:
            return 0.0 if text is None else float(text)
        except ValueError:
            raise LaunchError(f"{name}={text!r:.200} is not a number; write one") from None

    def applies(self) -> bool:
        """Return whether the if= or unless= of the element lets it apply."""
        on, off = map(self.optional, _CONDITIONS)
        if on is not None and off is not None:
            raise LaunchError(f"<{self.element.tag}> has both if= and unless=; keep one of them")
        if on is not None:
            return as_bool(on)
        return off is None or not as_bool(off)

    def check_attributes(self, known: Collection[str]) -> None:
        """Warn about unknown attributes."""
        for name in self.element.attributes:
            if name not in known and name not in _CONDITIONS:
                self.warn(f"<{self.element.tag}> has no attribute {name}=; it is ignored")

    def warn(self, text: str) -> None:
        """Report a problem with the element that does not stop the launch."""
        self.reading.plan.warnings.append(f"{self.element.file}:{self.element.line}: {text}")

    def namespace(self, node_name: str = "") -> Scope:
        """Return the scope inside an element with ns=; with clear_params=, the plan clears its parameters.

        `node_name` is the name of a node: only its private parameters are cleared.
        """
        kind = self.element.tag
        namespace = self.optional("ns")
        if namespace == "":
            raise LaunchError(f"<{kind}> has an empty ns=; remove it or give a namespace")
        if namespace is not None and not is_legal_name(namespace):
            self.warn(f"ns={namespace!r} is not a ROS name; many programs will refuse it")
        inside = self.scope.child(namespace)
        if self.element.attributes.get("clear_params") and self.flag("clear_params"):
            if namespace is None and kind not in ("node", "test"):
                raise LaunchError(f"<{kind} clear_params=...> needs ns=, the namespace to clear")
            if not node_name and kind in ("node", "test"):
                raise LaunchError(f"<{kind} clear_params=...> needs a name=")
            cleared = as_namespace(join(inside.namespace, node_name)) if node_name else inside.namespace
            self.reading.plan.cleared.append(cleared)
        return inside

    def remap(self) -> None:
        """Add a <remap>."""
        self.check_attributes(("from", "to"))
        self.scope.remap(self.required("from"), self.required("to"))

    def environment(self) -> None:
        """Add an <env>."""
        self.check_attributes(("name", "value"))
        name, value = self.required("name"), self.required("value")
        if not name:
            raise LaunchError("<env> has an empty name=; give the variable a name")
        self.scope.environment.append((name, value))

    def set_parameter(self, name: str, value: Any) -> None:
        """Set a parameter; a later value replaces an earlier one."""
        parameters = self.reading.plan.parameters
        key = canonical(name)
        check_value(key, value)
        above = namespace_of(key)
        while True:
            if above in parameters and above != key:
                self.warn(f"parameter {key} is below {above}, which also has a value; rename one")
            if above == SEPARATOR:
                break
            above = namespace_of(above)
        parameters[key] = value


@contextmanager
def errors_at(element: XmlElement) -> Iterator[None]:
    """Add the element's file and line to errors of the block that have none."""
    try:
        yield
    except LaunchError as error:
        if error.file:
            raise
        raise element.error(str(error)) from None
    except (ConfigError, InvalidNameError) as error:
        raise element.error(str(error)) from None
