"""Finds message and service types by name: in the user's folders, the bundled and the learned ones."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from rostether.errors import DefinitionError, RostetherError, UnknownTypeError
from rostether.msgdef.definition_files import (
    Kind,
    PackageFiles,
    bundled_file,
    bundled_names,
    bundled_packages,
    existing_folders,
    find_definitions,
    is_type_name,
    read_definition,
)
from rostether.msgdef.full_text import message_full_text, split_full_text
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.msgdef.md5sum import message_md5sum, service_md5sum
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.parse_srv import action_of, expand_action, parse_service, service_of
from rostether.msgdef.spec import MessageSpec, ServiceSpec
from rostether.msgdef.unknown_type import example_name, explain_unknown
from rostether.packages.locate import package_folders, package_path
from rostether.packages.package_xml import is_package_name

# Peers' definitions must not fill memory; a large system has about a hundred types.
MAX_LEARNED_TYPES = 4096
# Bundled for the examples. Users with this robot also have the package itself, perhaps with changes.
ROBOTS_OWN_PACKAGES = frozenset({"turtlebot3_msgs"})

# Boards announce names; those in use have fewer than 60 characters.
MAX_NAME_CHARACTERS = 256


class _SearchNeeded(Exception):  # noqa: N818 - it ends an attempt, it is not an error
    """A definition can only be found by a search of folders."""


class Registry:
    """Finds, parses and caches definitions; each is read on demand.

    `paths` are folders of packages or of plain definitions (--msg-path), `package_path` those of
    ROS_PACKAGE_PATH and the workspace; both override the bundled definitions, in the order given. A package
    there replaces the whole bundled one; a plain folder replaces single types. `nearby` is called only for
    types that none of these has; it returns the roots of more packages, whose search takes time.
    """

    def __init__(
        self,
        paths: Iterable[Path | str] = (),
        *,
        package_path: Iterable[Path | str] = (),
        bundled: bool = True,
        nearby: Callable[[], Iterable[Path]] | None = None,
    ) -> None:
        self._paths = [Path(path) for path in paths]
        self._package_path = [Path(path) for path in package_path]
        self._bundled = bundled
        self._nearby = nearby or tuple
        # Without folders there is nothing to search.
        self._found: dict[str, PackageFiles] | None = None if self._paths or self._package_path else {}
        self._found_nearby: dict[str, PackageFiles] | None = None if nearby is not None else {}
        self._may_search = True
        self._learned: dict[str, str] = {}
        self._messages: dict[str, MessageSpec] = {}
        self._services: dict[str, ServiceSpec] = {}
        self._message_types: dict[str, MessageType] = {}
        self._service_types: dict[str, ServiceType] = {}

    @classmethod
    def from_environment(
        cls, msg_paths: Iterable[Path | str] = (), environ: Mapping[str, str] | None = None
    ) -> Registry:
        """Return a registry of --msg-path folders, ROS_PACKAGE_PATH, and packages near the current folder.

        Raises ConfigError for a missing folder.
        """
        variables = os.environ if environ is None else environ
        return cls(existing_folders(msg_paths), package_path=package_path(variables), nearby=_nearby_packages)

    def can_answer(self, query: Callable[[], object]) -> bool:
        """Return whether `query`, which calls methods of this registry, needs no search of folders.

        For event loops, which must not search: the functions of `search_waiting` search in a thread.
        """
        if self._found is not None and self._found_nearby is not None:
            return True
        self._may_search = False
        try:
            query()
        except _SearchNeeded:
            return False
        except RostetherError:
            return True
        finally:
            self._may_search = True
        return True

    def search(self) -> None:
        """Search all folders now, and list their definitions. It may take seconds."""
        found = find_definitions(self._paths, self._package_path) if self._found is None else self._found
        nearby = self._found_nearby
        if nearby is None:
            nearby = find_definitions((), self._nearby())
        for files in (*found.values(), *nearby.values()):
            files.of(Kind.MESSAGE)
        self._found, self._found_nearby = found, nearby

    def message(self, name: str) -> MessageSpec:
        """Return a message by `package/Name`, including those of services and actions.

        Raises UnknownTypeError, or DefinitionError if its own text is broken.
        """
        spec = self._messages.get(name)
        if spec is None:
            spec = self._messages[name] = self._load_message(name)
        return spec

    def service(self, name: str) -> ServiceSpec:
        """Return a service by `package/Name`. Raises UnknownTypeError, DefinitionError."""
        spec = self._services.get(name)
        if spec is None:
            spec = self._services[name] = self._load_service(name)
        return spec

    def message_type(self, name: str) -> MessageType:
        """Return a message's md5sum and full text.

        Raises the same errors as `message`, for nested types too.
        """
        found = self._message_types.get(name)
        if found is None:
            found = self._message_types[name] = self._describe(self.message(name))
        return found

    def service_type(self, name: str) -> ServiceType:
        """Return a service's md5sum, request and response.

        Raises the same errors as `service`, for nested types too.
        """
        found = self._service_types.get(name)
        if found is None:
            spec = self.service(name)
            found = ServiceType(
                name,
                service_md5sum(spec, self.message),
                self._describe(spec.request),
                self._describe(spec.response),
            )
            self._service_types[name] = found
        return found

    def packages(self) -> list[str]:
        """Return the names of all packages that have definitions, sorted."""
        found = [*self._on_path().items(), *self._nearby_files().items()]
        names = {package for package, files in found if any(map(files.of, Kind))}
        names.update(name.partition("/")[0] for name in self._learned)
        if self._bundled:
            names.update(bundled_packages())
        return sorted(names)

    def messages(self, package: str | None = None) -> list[str]:
        """Return the full names of all messages, or of one package's, sorted, without those of services."""
        names: set[str] = set()
        for each in self.packages() if package is None else [package]:
            names.update(f"{each}/{name}" for name in self._names(Kind.MESSAGE, each))
            for action in self._names(Kind.ACTION, each):
                names.update(f"{each}/{message}" for message in expand_action("---\n---", name=action))
        names.update(name for name in self._learned if package in (None, name.partition("/")[0]))
        return sorted(names)

    def services(self, package: str | None = None) -> list[str]:
        """Return the full names of all services, or of one package's, sorted."""
        packages = self.packages() if package is None else [package]
        return sorted(f"{each}/{name}" for each in packages for name in self._names(Kind.SERVICE, each))

    @staticmethod
    def of_full_text(name: str, definition: str) -> Registry:
        """Return a registry of only the messages in a full text, as one publisher defines them.

        Raises DefinitionError.
        """
        registry = Registry(bundled=False)
        registry.add_full_text(name, definition)
        return registry

    def add_full_text(self, name: str, definition: str) -> None:
        """Add a message from a connection header's `message_definition`, with all nested messages.

        Known types keep their definition: to read one connection exactly as its publisher defines it, use
        `of_full_text`. Raises DefinitionError.
        """
        texts = split_full_text(name, definition)
        new = {each: text for each, text in texts.items() if each not in self._learned}
        if len(self._learned) + len(new) > MAX_LEARNED_TYPES:
            raise DefinitionError(
                f"peers have defined more than {MAX_LEARNED_TYPES} types; restart this program", file=name
            )
        for each, text in new.items():
            package, short_name = self._split(Kind.MESSAGE, each)
            parse_message(text, package=package, name=short_name)
        self._learned.update(new)

    def add_service_text(self, name: str, definition: str) -> None:
        """Add a service from its definition; its messages must be known. Raises DefinitionError."""
        package, _, short_name = name.partition("/")
        spec = parse_service(definition, package=package, name=short_name)
        self._services[name] = spec
        for message in (spec.request, spec.response):
            self._messages[message.full_name] = message

    def _load_message(self, name: str) -> MessageSpec:
        package, short_name = self._split(Kind.MESSAGE, name)
        if file := self._file(Kind.MESSAGE, package, short_name):
            return parse_message(read_definition(file), package=package, name=short_name, file=str(file))
        for action in action_of(short_name):
            if file := self._file(Kind.ACTION, package, action):
                texts = expand_action(read_definition(file), name=action, file=str(file))
                return parse_message(texts[short_name], package=package, name=short_name, file=str(file))
        if (service := service_of(short_name)) and self._file(Kind.SERVICE, package, service):
            spec = self.service(f"{package}/{service}")
            return spec.request if short_name == spec.request.name else spec.response
        if name in self._learned:
            return parse_message(self._learned[name], package=package, name=short_name)
        raise self._unknown(Kind.MESSAGE, package, short_name)

    def _load_service(self, name: str) -> ServiceSpec:
        package, short_name = self._split(Kind.SERVICE, name)
        if file := self._file(Kind.SERVICE, package, short_name):
            return parse_service(read_definition(file), package=package, name=short_name, file=str(file))
        raise self._unknown(Kind.SERVICE, package, short_name)

    def _unknown(self, kind: Kind, package: str, short_name: str) -> UnknownTypeError:
        root = self._replacement(package)
        if root is not None and self._bundled and bundled_file(package, kind, short_name) is not None:
            return UnknownTypeError(
                f"{root} has no {kind}/{short_name}.{kind}, and replaces the bundled package {package!r}, "
                "which has it; add the file, or remove the package from the workspace or ROS_PACKAGE_PATH"
            )
        return UnknownTypeError(explain_unknown(self, kind, package, short_name))

    def _describe(self, spec: MessageSpec) -> MessageType:
        return MessageType(
            spec.full_name, message_md5sum(spec, self.message), message_full_text(spec, self.message)
        )

    def _split(self, kind: Kind, name: str) -> tuple[str, str]:
        package, _, short_name = name.partition("/")
        if len(name) > MAX_NAME_CHARACTERS or not (is_package_name(package) and is_type_name(short_name)):
            example = example_name(kind, name)
            raise UnknownTypeError(f"{name[:80]!r} is not a type name; write package/Name, such as {example}")
        return package, short_name

    def _on_path(self) -> dict[str, PackageFiles]:
        if self._found is None:
            self._check_may_search()
            self._found = find_definitions(self._paths, self._package_path)
        return self._found

    def _nearby_files(self) -> dict[str, PackageFiles]:
        if self._found_nearby is None:
            self._check_may_search()
            self._found_nearby = find_definitions((), self._nearby())
        return self._found_nearby

    def _replacement(self, package: str) -> Path | None:
        """Return the folder of the user's package with this name, which hides the bundled one, if any."""
        files = self._on_path().get(package)
        if files is None and package in ROBOTS_OWN_PACKAGES:
            files = self._nearby_files().get(package)
        return files.root if files is not None else None

    def _check_may_search(self) -> None:
        if not self._may_search:
            raise _SearchNeeded

    def _file(self, kind: Kind, package: str, short_name: str) -> Path | None:
        on_path = self._on_path().get(package)
        if on_path is not None and (file := on_path.of(kind).get(short_name)):
            return file
        if (
            self._bundled
            and (bundled := bundled_file(package, kind, short_name))
            and self._replacement(package) is None
        ):
            return bundled
        nearby = self._nearby_files().get(package)
        return nearby.of(kind).get(short_name) if nearby is not None else None

    def _names(self, kind: Kind, package: str) -> set[str]:
        names: set[str] = set()
        for found in (self._on_path(), self._nearby_files()):
            if package in found:
                names.update(found[package].of(kind))
        is_replaced = not self._bundled or self._replacement(package) is not None
        return names if is_replaced else names | bundled_names(package, kind)


def _nearby_packages() -> Iterable[Path]:
    try:
        return package_folders({}, Path.cwd()).values()
    except OSError:
        # The current folder was deleted.
        return ()
