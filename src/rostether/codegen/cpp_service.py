"""The header of a service: the classes of its request and its response, and one that names both."""

from __future__ import annotations

from collections.abc import Iterator

from rostether.codegen.cpp_header import header
from rostether.codegen.cpp_message import HeaderOf, included_paths, message_class, sheltered_names
from rostether.codegen.cpp_names import class_name, name_members
from rostether.msgdef.spec import ServiceSpec


def service_header(
    spec: ServiceSpec, request_md5sum: str, response_md5sum: str, header_of: HeaderOf = str
) -> str:
    """Return the text of a service's header; each half announces the service's name and its own md5sum."""
    halves = (spec.request, request_md5sum), (spec.response, response_md5sum)
    includes = {path for half, _ in halves for path in included_paths(half, header_of)}
    sheltered = {name for half, _ in halves for name in sheltered_names(name_members(half))}
    return header(spec.full_name, includes, sheltered, _classes(spec, request_md5sum, response_md5sum))


def _classes(spec: ServiceSpec, request_md5sum: str, response_md5sum: str) -> Iterator[str]:
    for half, md5sum in ((spec.request, request_md5sum), (spec.response, response_md5sum)):
        yield from message_class(half, name_members(half), type_name=spec.full_name, md5sum=md5sum)
        yield ""
    yield f"class {class_name(spec.name)} {{"
    yield " public:"
    yield f"  typedef {class_name(spec.request.name)} Request;"
    yield f"  typedef {class_name(spec.response.name)} Response;"
    yield "};"
