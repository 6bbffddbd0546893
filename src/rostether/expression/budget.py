"""The limits of an expression: how many steps it takes and how large its values get.

Short expressions can compute for days or fill memory: `9**9**9`, `sum([[0] * 9999] * 9999, [])`,
`'%999999999d' % 1`. So each call and pass of a loop costs steps, and each element, character and key of a
value. A value that can be much larger than its operands is charged before it is computed. The budget counts
steps instead of time, so a busy machine accepts the same expressions as an idle one.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from functools import reduce
from types import MappingProxyType
from typing import Any, Final

# Two seconds of computing, 100 MB. `any(b > 250 for b in m.data)` needs 2.8 million steps for a VGA image.
MAX_STEPS: Final = 10_000_000

# The largest double has 1,024 bits; `9**9**9` would compute for days.
MAX_INTEGER_BITS: Final = 1024

# 170! has 1,020 bits, 171! has 1,027.
_MAX_FACTORIAL: Final = 170

# The limit of the width and precision of a format, and of the digits of round(). A double has fewer
# significant digits.
MAX_DIGITS: Final = 1000

_ATOMS: Final = frozenset((float, int, bool, type(None)))
_TEXTS: Final = frozenset((str, bytes, bytearray, range))
_LISTS: Final = frozenset((list, tuple))
_HASHED: Final = frozenset((set, frozenset, dict))
_OWNERS: Final = frozenset((str, bytes, bytearray, list, tuple, int)) | _HASHED
_NO_NAMED: Final[Mapping[str, Any]] = MappingProxyType({})
_FORMAT: Final = re.compile(r"%(?:\([^)]*\))?[-#0 +]*(\*|\d*)(?:\.(\*|\d*))?")

Function = Callable[..., Any]

# These compare or add the elements of a list. For a list that begins with a number, they fail at the first
# nested list or do not look into it, so the nested lists cost nothing.
_LINEAR: Final = (min, max, sum, sorted, any, all)


class Budget:
    """Executes operations and counts their steps. Raises OverflowError beyond the limits."""

    def __init__(self) -> None:
        self._left = MAX_STEPS
        self._bounded: dict[Function, Function] = {
            sum: self._sum,
            round: self._round,
            pow: lambda *numbers: self.power(*numbers) if len(numbers) == 2 else pow(*numbers),
            map: self._map,
            set: lambda *items: self._hashed(set, *items),
            frozenset: lambda *items: self._hashed(frozenset, *items),
            dict: lambda *items, **named: self._hashed(dict, *items, **named),
            bytes: lambda *items: self._bytes(bytes, *items),
            bytearray: lambda *items: self._bytes(bytearray, *items),
            math.lcm: lambda *numbers: reduce(
                lambda left, right: self.result(math.lcm(left, right)), numbers, 1
            ),
            math.factorial: self._factorial,
            math.comb: self._comb,
            math.perm: self._perm,
            math.prod: self._prod,
        }

    def restart(self) -> None:
        """Start another evaluation, with no steps spent."""
        self._left = MAX_STEPS

    @property
    def spent(self) -> int:
        """The steps since the last restart."""
        return MAX_STEPS - self._left

    def spend(self, steps: int) -> None:
        """Count steps. Raises OverflowError if there were too many since the last restart."""
        self._left -= steps
        if self._left < 0:
            raise OverflowError(
                f"it needs more than {MAX_STEPS} steps, or creates longer values; simplify it"
            )

    def result(self, value: Any) -> Any:
        """Spend the size of a computed value, and return the value."""
        kind = type(value)
        if kind is int:
            _check_bits(value.bit_length())
        elif kind not in _ATOMS:
            self.spend(self._size(value))
        return value

    def read(self, value: Any) -> Any:
        """Spend the size of a value that is about to be compared or searched, and return the value."""
        if type(value) not in _ATOMS:
            self.spend(self._size(value))
        return value

    def call(self, function: Function, arguments: Sequence[Any], named: Mapping[str, Any] = _NO_NAMED) -> Any:
        """Call a function and return its result."""
        if function is len:
            return len(*arguments)
        self.spend(1)
        for argument in arguments:
            if function in _LINEAR and type(argument) is list and argument and type(argument[0]) in _ATOMS:
                self.spend(len(argument))
            else:
                self.read(argument)
        for argument in named.values():
            self.read(argument)
        owner = getattr(function, "__self__", None)
        if type(owner) in _OWNERS:
            if function.__name__ == "join":
                # The number of an iterator's items is unknown before it is read.
                arguments = [list(argument) for argument in arguments]
            self._spend_for_method(owner, function.__name__, [*arguments, *named.values()])
        elif isinstance(function, Hashable):
            function = self._bounded.get(function, function)
        return self.result(function(*arguments, **named))

    def power(self, base: Any, exponent: Any) -> Any:
        """Return `base ** exponent`."""
        if isinstance(base, int) and isinstance(exponent, int):
            _check_bits(math.log2(abs(base) or 1) * exponent)
        return base**exponent

    def multiply(self, left: Any, right: Any) -> Any:
        """Return `left * right`."""
        for sequence, times in ((left, right), (right, left)):
            if isinstance(sequence, str | bytes | list | tuple) and isinstance(times, int):
                self.spend(self._size(sequence) * max(times, 0))
        return left * right

    def modulo(self, left: Any, right: Any) -> Any:
        """Return `left % right`: the remainder, or a formatted string."""
        if isinstance(left, str | bytes):
            text = left if isinstance(left, str) else left.decode("latin-1")
            formats = _FORMAT.findall(text)
            for digits in (each for pair in formats for each in pair if each):
                if digits == "*" or len(digits) > 4 or int(digits) > MAX_DIGITS:
                    raise OverflowError(
                        f"a width in a format must be a number of at most {MAX_DIGITS}; use a smaller one"
                    )
            self.spend(len(text) + len(formats) * (self._size(right) + MAX_DIGITS))
        return left % right

    def shift_left(self, value: Any, bits: Any) -> Any:
        """Return `value << bits`."""
        if isinstance(bits, int):
            _check_bits(bits)
        return value << bits

    def _size(self, value: Any) -> int:
        """Return the number of elements, characters and keys at all levels; repeated ones count each time."""
        kind = type(value)
        if kind in _TEXTS:
            return len(value)
        if kind not in _LISTS and kind not in _HASHED:
            if not isinstance(value, list | tuple | set | frozenset | dict):
                return 1
            kind = dict if isinstance(value, dict) else list
        values: Collection[Any] = [*value, *value.values()] if kind is dict else value
        size = len(values)
        if kind in _HASHED:
            size += _collisions(size)
        if not _ATOMS.issuperset(map(type, values)):
            for each in values:
                size += self._size(each)
                if size > MAX_STEPS:
                    break
        return size

    def _spend_for_method(self, owner: Any, name: str, arguments: Sequence[Any]) -> None:
        if type(owner) in _HASHED:
            # The keys that a method adds or looks up may all share one hash.
            self.spend(_collisions(sum(map(self._size, arguments))))
            return
        if type(owner) is not int:
            self.spend(len(owner))
        match name, arguments:
            case "zfill" | "ljust" | "rjust" | "center" | "to_bytes", _:
                self.spend(max([0, *(each for each in arguments if isinstance(each, int))]))
            case "expandtabs", [int(width)]:
                self.spend(len(owner) * max(width, 0))
            case "join", [items]:
                self.spend(len(owner) * len(items))
            case "replace", [old, new, *_] if type(old) is type(new) is type(owner):
                self.spend(owner.count(old) * len(new))
            case "translate", [table]:
                self.spend(len(owner) * self._size(table))
            case "strip" | "lstrip" | "rstrip", [str(characters)]:
                self.spend(len(owner) * len(characters) >> 4)

    def _sum(self, items: Iterable[Any], start: Any = 0) -> Any:
        if type(start) in _ATOMS:
            return sum(items, start)
        total = start
        for each in items:
            # Each addition copies all previous elements.
            total = self.result(operator.add(total, each))
        return total

    def _prod(self, items: Iterable[Any], start: Any = 1) -> Any:
        for each in items:
            start = self.result(self.multiply(start, each))
        return start

    def _map(self, function: Function, *items: Iterable[Any]) -> list[Any]:
        return [self.call(function, arguments) for arguments in zip(*items, strict=False)]

    def _hashed(self, kind: Function, *items: Any, **named: Any) -> Any:
        if items and not isinstance(items[0], dict | set | frozenset):
            values: list[Any] = list(*items)
            self.spend(_collisions(len(values)))
            return kind(values, **named)
        return kind(*items, **named)

    def _bytes(self, kind: Function, *items: Any) -> Any:
        if items and isinstance(items[0], int):
            self.spend(items[0])
        return kind(*items)

    @staticmethod
    def _round(number: Any, ndigits: Any = None) -> Any:
        if isinstance(ndigits, int) and abs(ndigits) > MAX_DIGITS:
            raise OverflowError(f"round() takes at most {MAX_DIGITS} digits; use fewer")
        return round(number, ndigits)

    @staticmethod
    def _factorial(number: Any) -> Any:
        if isinstance(number, int):
            _check_bits(MAX_INTEGER_BITS + 1 if number > _MAX_FACTORIAL else 0)
        return math.factorial(number)

    @staticmethod
    def _comb(count: Any, chosen: Any) -> Any:
        if isinstance(count, int) and isinstance(chosen, int):
            _check_bits(min(chosen, count - chosen))
        return math.comb(count, chosen)

    @staticmethod
    def _perm(count: Any, chosen: Any = None) -> Any:
        factors = count if chosen is None else chosen
        if isinstance(factors, int):
            _check_bits(factors)
        return math.perm(count, chosen)


def _collisions(count: int) -> int:
    """Return the steps to create a set of numbers that all share one hash; 16 comparisons cost one step."""
    return count * count >> 5


def _check_bits(bits: float) -> None:
    if bits > MAX_INTEGER_BITS:
        raise OverflowError(
            f"a whole number of more than {MAX_INTEGER_BITS} bits is too large; use smaller numbers"
        )
