"""Reads the attributes of elements in a launch file, and collects the plan."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any

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


class TagReader:
    """Reads attributes, makes their substitutions, and adds what it reads to the plan.

    All methods raise LaunchError, ConfigError; `at_element` adds the element's file and line.
    """

    def __init__(self, context: LaunchContext) -> None:
        self.context = context
        self.plan = LaunchPlan()
        self._substituted_chars = 0

    def substitute(self, text: str, scope: Scope) -> str:
        """Return a text with all substitutions made."""
        result = substitute(text, scope, self.context)
        if result is not text:
            self._substituted_chars += len(result)
            if self._substituted_chars > MAX_SUBSTITUTED_CHARS:
                raise LaunchError(
                    f"all $(...) together have more than {MAX_SUBSTITUTED_CHARS} characters; shorten the "
                    "arguments"
                )
        return result

    def optional(self, element: XmlElement, scope: Scope, name: str) -> str | None:
        """Return an attribute's value; None if it is missing."""
        text = element.attributes.get(name)
        return None if text is None else self.substitute(text, scope)

    def required(self, element: XmlElement, scope: Scope, name: str) -> str:
        """Return the value of a required attribute."""
        text = self.optional(element, scope, name)
        if text is None and name == "type" and "exec" in element.attributes:
            raise LaunchError(
                "exec= is of ROS 2; in a ROS 1 launch file write type=, or start the file with `ros2 launch`"
            )
        if text is None:
            raise LaunchError(f"<{element.tag}> needs the attribute {name}=; add it")
        return text

    def flag(self, element: XmlElement, scope: Scope, name: str) -> bool:
        """Return a boolean attribute; False if it is missing."""
        text = self.optional(element, scope, name)
        if text is not None and text.lower() not in ("true", "false"):
            raise LaunchError(f"{name}={text!r:.200} is not true or false; write one of them")
        return text is not None and text.lower() == "true"

    def number(self, element: XmlElement, scope: Scope, name: str) -> float:
        """Return a numeric attribute; 0 if it is missing."""
        text = self.optional(element, scope, name)
        try:
            return 0.0 if text is None else float(text)
        except ValueError:
            raise LaunchError(f"{name}={text!r:.200} is not a number; write one") from None

    def applies(self, element: XmlElement, scope: Scope) -> bool:
        """Return whether the if= or unless= of an element lets it apply."""
        on, off = (self.optional(element, scope, name) for name in _CONDITIONS)
        if on is not None and off is not None:
            raise LaunchError(f"<{element.tag}> has both if= and unless=; keep one of them")
        if on is not None:
            return as_bool(on)
        return off is None or not as_bool(off)

    def check_attributes(self, element: XmlElement, known: Collection[str]) -> None:
        """Warn about unknown attributes."""
        for name in element.attributes:
            if name not in known and name not in _CONDITIONS:
                self.warn(element, f"<{element.tag}> has no attribute {name}=; it is ignored")

    def warn(self, element: XmlElement, text: str) -> None:
        """Report a problem with an element that does not stop the launch."""
        self.plan.warnings.append(f"{element.file}:{element.line}: {text}")

    def namespace(self, element: XmlElement, scope: Scope, node_name: str = "") -> Scope:
        """Return the scope inside an element with ns=; with clear_params=, the plan clears its parameters.

        `node_name` is the name of a node: only its private parameters are cleared.
        """
        namespace = self.optional(element, scope, "ns")
        if namespace == "":
            raise LaunchError(f"<{element.tag}> has an empty ns=; remove it or give a namespace")
        if namespace is not None and not is_legal_name(namespace):
            self.warn(element, f"ns={namespace!r} is not a ROS name; many programs will refuse it")
        inside = scope.child(namespace)
        if element.attributes.get("clear_params") and self.flag(element, scope, "clear_params"):
            if namespace is None and element.tag not in ("node", "test"):
                raise LaunchError(f"<{element.tag} clear_params=...> needs ns=, the namespace to clear")
            if not node_name and element.tag in ("node", "test"):
                raise LaunchError(f"<{element.tag} clear_params=...> needs a name=")
            cleared = as_namespace(join(inside.namespace, node_name)) if node_name else inside.namespace
            self.plan.cleared.append(cleared)
        return inside

    def remap(self, element: XmlElement, scope: Scope) -> None:
        """Add a <remap>."""
        self.check_attributes(element, ("from", "to"))
        scope.remap(self.required(element, scope, "from"), self.required(element, scope, "to"))

    def environment(self, element: XmlElement, scope: Scope) -> None:
        """Add an <env>."""
        self.check_attributes(element, ("name", "value"))
        name, value = self.required(element, scope, "name"), self.required(element, scope, "value")
        if not name:
            raise LaunchError("<env> has an empty name=; give the variable a name")
        scope.environment.append((name, value))

    @contextmanager
    def at_element(self, element: XmlElement) -> Iterator[None]:
        """Add the element's file and line to errors of the block that have none."""
        try:
            yield
        except LaunchError as error:
            if error.file:
                raise
            raise element.error(str(error)) from None
        except (ConfigError, InvalidNameError) as error:
            raise element.error(str(error)) from None

    def set_parameter(self, element: XmlElement, name: str, value: Any) -> None:
        """Set a parameter; a later value replaces an earlier one."""
        key = canonical(name)
        check_value(key, value)
        above = namespace_of(key)
        while True:
            if above in self.plan.parameters and above != key:
                self.warn(element, f"parameter {key} is below {above}, which also has a value; rename one")
            if above == SEPARATOR:
                break
            above = namespace_of(above)
        self.plan.parameters[key] = value
