"""Finds the top-level statements of a sketch and its function definitions.

Nothing here fails on invalid code: an unknown statement counts as one without a function, and the compiler
reports the error.
"""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import Struct, field

from rostether.firmware.cpp_tokens import Token

_OPENING = {"(": ")", "[": "]", "{": "}"}
_CLASS_KEYS = frozenset(("class", "struct", "union", "enum"))
# Words before parentheses that are not function names.
_NOT_FUNCTIONS = frozenset(
    (
        *("__attribute__", "__declspec", "alignas", "decltype", "noexcept", "throw", "sizeof", "asm"),
        *("if", "for", "while", "switch", "return", "operator"),
    )
)
_AFTER_PARAMETERS = frozenset(("const", "volatile", "noexcept", "override", "final", "__attribute__"))
_BEFORE_NAME = frozenset(("*", "&", "&&", ">", "]]"))


class Function(Struct, frozen=True):
    """A function's head: its name, and the tokens from the return type up to `{` or `;`."""

    name: str
    head: tuple[Token, ...]
    parameters: tuple[Token, ...]
    is_extern_c: bool = False


class Statement(Struct, frozen=True):
    """Tokens from the first to the closing `;` or `}`; directives between statements are separate."""

    tokens: tuple[Token, ...]
    function: Function | None = None
    is_definition: bool = False
    declared: frozenset[str] = field(default_factory=frozenset)

    @property
    def start(self) -> int:
        """The offset of the first token."""
        return self.tokens[0].offset


def read_statements(tokens: Sequence[Token], *, is_extern_c: bool = False) -> list[Statement]:
    """Return the top-level statements in order, including those inside `extern "C" { }`."""
    statements: list[Statement] = []
    start = position = 0
    while position < len(tokens):
        token = tokens[position]
        if token.kind == "directive" and position == start:
            statements.append(Statement((token,), declared=_defined_by(token)))
            start = position = position + 1
        elif token.text in ("(", "["):
            position = _closing(tokens, position) + 1
        elif token.text == ";":
            position += 1
            statements.append(_statement(tokens[start:position], None, is_extern_c))
            start = position
        elif token.text == "{" and token.kind == "punctuation":
            head = [each for each in tokens[start:position] if each.kind != "directive"]
            end = _closing(tokens, position)
            if [each.text for each in head] == ["extern", '"C"']:
                statements += read_statements(tokens[position + 1 : end], is_extern_c=True)
                start = position = end + 1
                continue
            position = end + 1
            if _ends_with_its_body(head):
                statements.append(_statement(tokens[start:position], head, is_extern_c))
                start = position
        else:
            position += 1
    if start < len(tokens):
        statements.append(Statement(tuple(tokens[start:])))
    return statements


def parameter_count(function: Function) -> int:
    """Return the number of a function's parameters; `(void)` and `()` have none."""
    texts = [token.text for token in function.parameters]
    return 0 if texts in ([], ["void"]) else len(split_at_commas(function.parameters))


def split_at_commas(tokens: Sequence[Token]) -> list[list[Token]]:
    """Return the parts between commas outside all brackets."""
    parts: list[list[Token]] = [[]]
    depth = 0
    for token in tokens:
        if token.text in ("(", "[", "{", "<", "[["):
            depth += 1
        elif token.text in (")", "]", "}", ">", "]]"):
            depth -= 1
        if token.text == "," and depth <= 0:
            parts.append([])
        else:
            parts[-1].append(token)
    return parts


def _statement(tokens: Sequence[Token], head: Sequence[Token] | None, is_extern_c: bool) -> Statement:
    is_definition = head is not None
    if head is None:
        head = [each for each in tokens[:-1] if each.kind != "directive"]
    return Statement(tuple(tokens), _find_function(head, is_extern_c), is_definition, _declared_by(head))


def _closing(tokens: Sequence[Token], opening: int) -> int:
    """Return the index of the matching closing bracket, or of the last token if there is none."""
    closes = [_OPENING[tokens[opening].text]]
    for index in range(opening + 1, len(tokens)):
        token = tokens[index]
        if token.kind != "punctuation":
            continue
        if token.text in _OPENING:
            closes.append(_OPENING[token.text])
        elif token.text == "[[":
            closes.append("]]")
        elif token.text == "]]" and closes[-1] == "]":
            # Two closing brackets of an array in an array.
            closes.pop()
            if closes and closes[-1] == "]":
                closes.pop()
        elif token.text == closes[-1]:
            closes.pop()
        if not closes:
            return index
    return len(tokens) - 1


def _ends_with_its_body(head: Sequence[Token]) -> bool:
    """Return whether `}` ends the statement: true for a function or namespace, not for `struct S { } s;`."""
    texts = [token.text for token in head]
    if "namespace" in texts[:2]:
        return True
    return (
        "=" not in _outside_parentheses(head)
        and _find_function(head, is_extern_c=False, any_name=True) is not None
    )


def _outside_parentheses(tokens: Sequence[Token]) -> list[str]:
    texts: list[str] = []
    depth = 0
    for token in tokens:
        depth += (token.text == "(") - (token.text == ")")
        if depth == 0 and texts[-1:] != ["operator"]:
            texts.append(token.text)
    return texts


def _find_function(head: Sequence[Token], is_extern_c: bool, *, any_name: bool = False) -> Function | None:
    """Return the function that a head declares; with `any_name` also a member, an operator or a macro."""
    if (
        not head
        or head[0].text in ("typedef", "using", "namespace", "#")
        or "=" in _outside_parentheses(head)
    ):
        return None
    index = _skip_template(head)
    first = index
    while index < len(head):
        if head[index].text != "(":
            index += 1
            continue
        closing = _closing(head, index)
        name = head[index - 1]
        is_name = index > 0 and name.kind == "name" and name.text not in _NOT_FUNCTIONS
        if any_name and index > 0 and _fits_after(head[closing + 1 :], allow_initializers=True):
            return Function(name.text, tuple(head), ())
        if is_name and index - 1 > first and _fits_before(head[first : index - 1]):
            if not _fits_after(head[closing + 1 :]):
                return None
            return Function(name.text, tuple(head), tuple(head[index + 1 : closing]), is_extern_c)
        index = closing + 1
    return None


def _skip_template(head: Sequence[Token]) -> int:
    if head[0].text != "template":
        return 0
    depth = 0
    for index, token in enumerate(head):
        depth += (token.text == "<") - (token.text == ">")
        if token.text == ">" and depth == 0:
            return index + 1
    return 0


def _fits_before(tokens: Sequence[Token]) -> bool:
    """Return whether the tokens before a name can be a return type."""
    last = tokens[-1]
    if any(token.text == "operator" for token in tokens) or last.text == "::":
        return False
    return last.kind == "name" or last.text in _BEFORE_NAME or last.text == ")"


def _fits_after(tokens: Sequence[Token], *, allow_initializers: bool = False) -> bool:
    """Return whether the tokens after the parameters can be the rest of a function's head."""
    index = 0
    while index < len(tokens):
        token = tokens[index]
        if token.text == "->" or (allow_initializers and token.text == ":"):
            return True
        if token.text in ("(", "[") and index:
            index = _closing(tokens, index)
        elif token.kind != "name" or not (token.text in _AFTER_PARAMETERS or token.text.isupper()):
            return token.text in ("&", "&&", "[[")
        index += 1
    return True


def _declared_by(head: Sequence[Token]) -> frozenset[str]:
    """Return the names of types and namespaces that a statement declares."""
    texts = [token.text for token in head]
    names = [token.text for token in head if token.kind == "name"]
    if not names:
        return frozenset()
    if names[0] == "typedef":
        # The last name, or that of a pointer to a function: typedef void (*callback)(int).
        pointed = [texts[i + 2] for i in range(len(texts) - 2) if texts[i : i + 2] == ["(", "*"]]
        return frozenset((*pointed, names[-1]))
    if names[0] in ("using", "namespace") and len(names) > 1:
        return frozenset(names[1:2])
    index = _skip_template(head)
    declared = set()
    for key, name in zip(head[index:], head[index + 1 :], strict=False):
        if key.text in _CLASS_KEYS and name.kind == "name":
            declared.add(name.text)
            if name.text in ("class", "struct"):
                continue
            break
    return frozenset(declared)


def _defined_by(directive: Token) -> frozenset[str]:
    words = directive.text.lstrip("#").split(None, 2)
    if len(words) > 1 and words[0] == "define":
        return frozenset((words[1].partition("(")[0],))
    return frozenset()
