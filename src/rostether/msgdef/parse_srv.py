"""Reading a .srv text: the request, a line that starts with `---`, the response."""

from __future__ import annotations

from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.spec import ServiceSpec

SECTION_MARK = "---"


def parse_service(text: str, *, package: str, name: str, file: str = "") -> ServiceSpec:
    """Parse a definition; a text without the mark has an empty response, as genmsg has it.

    Raises DefinitionError with file, line and column of the first mistake.
    """
    file = file or f"{package}/{name}"
    request_lines: list[str] = []
    response_lines: list[str] = []
    response_starts = 0
    lines = request_lines
    for number, line in enumerate(text.split("\n"), 1):
        if line.startswith(SECTION_MARK):
            lines = response_lines
            # Only the first mark counts, further ones are passed over; lines keep their numbers for errors.
            response_starts = response_starts or number
        else:
            lines.append(line)
    request = parse_message(_joined(request_lines), package=package, name=f"{name}Request", file=file)
    response = parse_message(
        _joined(response_lines),
        package=package,
        name=f"{name}Response",
        file=file,
        first_line=response_starts + 1,
    )
    return ServiceSpec(package, name, request, response, text)


def _joined(lines: list[str]) -> str:
    return "".join(f"{line}\n" for line in lines)
