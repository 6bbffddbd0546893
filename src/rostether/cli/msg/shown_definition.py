"""The text of a definition with the types of all its fields, which `msg show` and `srv show` print."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import islice
from typing import Final

from rostether.errors import DefinitionError
from rostether.msgdef.resolve_types import SpecT, dependencies

# The longest in use have some 200. Four fields of the next type on each of 24 levels make 10^14.
MAX_SHOWN_LINES: Final = 10_000


def shown_definition(spec: SpecT, lookup: Callable[[str], SpecT], lines: Iterable[str]) -> str:
    """Return the lines of a definition as one text.

    Raises DefinitionError for a type inside itself and for more lines than MAX_SHOWN_LINES, UnknownTypeError.
    """
    dependencies(spec, lookup)
    shown = list(islice(lines, MAX_SHOWN_LINES + 1))
    if len(shown) > MAX_SHOWN_LINES:
        raise DefinitionError(
            f"{spec.full_name} has more than {MAX_SHOWN_LINES} lines with the types of all its fields; "
            "show the types of single fields instead, or use --raw"
        )
    return "".join(f"{line}\n" for line in shown)
