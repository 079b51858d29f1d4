"""Text of an algorithm that computes coefficient k of what formulas say, from items of the ring of power series.

Products of one level are convolved together; functions follow the recurrences. What is kept from order to order
stands in one row of numbers. Vectors are of products, whose factors stand side by side, each as often as it is needed,
or of several items, where a factor is kept once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction

from ...errors import TraceError
from ...rings.power_series import Item, SeriesRing
from .recurrences import RECURRENCES, ROWS

#: Products are made in groups of this many: a whole number of vectors of any width.
LANES = 4
#: Of several items, at most so many in one loop: nearly as many as a processor with vectors of 64 bytes has registers.
TOGETHER = 28
_MASKS = {"lt": "{} < {}", "le": "{} <= {}", "and": "{} and {}", "or": "{} or {}", "not": "not {}"}
#: Of numbers that do not depend on time.
_NUMBERS = {
    "mul": "{} * {}", "scaled": "{} * {}", "reciprocal": "1.0 / {}", "select": "{1} if {0} else {2}", "abs": "abs({})",
    "nan": "NAN", "epsilon": "epsilon()", **{f: f"{f}({{}})" for f in ("sqrt", "sin", "cos", "exp", "log")},
    "atan2": "atan2({}, {})",
}  # fmt: skip


class SeriesText:
    """Statements for some results, each a sum of items.

    Parameters
    ----------
    ring : SeriesRing
    results : sequence
    of_items : bool
        Whether vectors are of several items.

    Attributes
    ----------
    size : int
        Numbers that are kept.
    products : int
        Convolutions.
    """

    def __init__(
        self, ring: SeriesRing, results: Sequence[tuple[str, Sequence[Sequence[Item]]]], of_items: bool = False
    ) -> None:
        self.ring = ring
        self.size = self.products = 0
        self.lines: list[str] = []
        self._fixed: list[str] = []  # statements at order 0: numbers that do not depend on time
        self._text: dict[Item, str] = {}
        self._histories: dict[Item, int] = {}
        self._loads: list[str] = []
        items = _in_dependency_order(item for _, rows in results for row in rows for item in row)
        for item in items:
            if not item.moves and item.op not in _MASKS:
                self._number(item)
        for level in range(max((item.level for item in items), default=0) + 1):
            here = [item for item in items if item.level == level and (item.moves or item.op in _MASKS)]
            products = [item for item in here if item.op == "product"]
            others = [item for item in here if item.op != "product"]
            self.products += len(products)
            if of_items:
                others = self._convolve_items(products, others)
            else:
                self._convolve(products)
            for item in others:
                self._series(item)
        for name, rows in results:
            sums = (" + ".join(map(self._at_order, row)) for row in rows)
            self.lines.append(f"{name}[:] = ({', '.join(sums)},)")
        if self._fixed:
            self.lines = ["if k == 0:", *(f"    {line}" for line in self._fixed), *self.lines]
        self.lines = [*self._loads, *self.lines]
        self._align()

    def _align(self) -> None:
        """What comes next begins a whole number of vectors behind the begin."""
        self.size += -self.size % LANES

    def _room(self, count: int) -> int:
        self.size += count
        return self.size - count

    # -- what does not depend on time -------------------------------------------------------------------------

    def _number(self, item: Item) -> None:
        if item.op == "const":
            self._text[item] = _decimal(item.data)
        elif item.op == "input":
            self._input(item)
        else:
            if any(a.moves or (a.op in _MASKS and _depends_on_time(a)) for a in item.args):
                raise AssertionError("what depends on motion moves")
            place = f"work[{self._room(1)}]"
            self._fixed.append(f"{place} = {self._formula(item)}")
            self._text[item] = place

    def _input(self, item: Item) -> None:
        """A number of a row, read before what is kept changes: compilers do not know that these are apart."""
        row, index = item.data
        self._text[item] = f"{row}_{index}"
        self._loads.append(f"{row}_{index} = {row}[{index}]")

    def _formula(self, item: Item) -> str:
        """A number, or a mask, from others by one operation."""
        arguments = [self._condition(a) if a.op in _MASKS else self._text[a] for a in item.args]
        if item.op == "sum":
            return _weighted_sum(arguments, *item.data)
        form = _MASKS.get(item.op) or _NUMBERS.get(item.op)
        return form.format(*arguments) if form else self._refuse(item)

    def _refuse(self, item: Item) -> str:
        raise TraceError(f"{item.op} has no Taylor recurrence; take another integrator.")

    def _condition(self, mask: Item) -> str:
        return f"({self._text[mask]} != 0.0)" if mask in self._text else f"({self._formula(mask)})"

    # -- series -----------------------------------------------------------------------------------------------

    def _at_order(self, item: Item) -> str:
        """Coefficient k of a value."""
        if item.moves:
            return self._text[item]
        return "0.0" if item is self.ring.zero else f"(0.0 if k > 0 else {self._text[item]})"

    def _set(self, item: Item, text: str) -> None:
        self._text[item] = f"t{item.number}"
        self.lines.append(f"t{item.number} = {text}")

    def _convolve(self, items: Sequence[Item]) -> None:
        """Products of one level, side by side."""
        if not items:
            return
        count = -(-len(items) // LANES) * LANES
        name = f"p{items[0].level}"
        self._align()
        starts = {side: self._room(ROWS * count) for side in "ab"}
        self.lines += [f"{name} = empty({count})", f"{name}_at = {count} * k"]
        for side, start in enumerate(starts.values()):
            at = f"{name}_at + {start}"
            factors = [item.args[side] for item in items] + [self.ring.zero] * (count - len(items))
            self.lines.append(f"work[{at} : {at} + {count}] = ({', '.join(map(self._at_order, factors))})")
        a, b = (f"work[{start}:{start + ROWS * count}]" for start in starts.values())
        self.lines.append(f"convolve(k, {count}, {a}, {b}, {name})")
        self._text.update({item: f"{name}[{lane}]" for lane, item in enumerate(items)})

    def _convolve_items(self, items: Sequence[Item], others: Sequence[Item]) -> list[Item]:
        """The same one by one, some in a loop: the sums of `convolve`; what of the others is not done yet.

        What can be is done between two loops: sums of products take fewer registers.
        """
        for item in items:
            for factor in item.args:
                self._history(factor)
        loops = -(-len(items) // TOGETHER)
        for group in (items[i * len(items) // loops : (i + 1) * len(items) // loops] for i in range(loops)):
            places = [[self._histories[factor] for factor in item.args] for item in group]
            for item, (a, b) in zip(group, places, strict=True):
                self._set(item, f"work[{a}] * work[k + {b}]")
            self.lines.append("for j in range(1, k + 1):")
            for item, (a, b) in zip(group, places, strict=True):
                self.lines.append(f"    {self._text[item]} += work[j + {a}] * work[k - j + {b}]")
            waiting = []
            for item in others:
                if all(a in self._text for a in item.args):
                    self._series(item)
                else:
                    waiting.append(item)
            others = waiting
        return list(others)

    def _series(self, item: Item) -> None:
        if item.op == "input":
            self._input(item)
        elif item.op in _MASKS:
            if _depends_on_time(item):
                self._text[item] = self._at_start(f"1.0 if {self._formula(item)} else 0.0")
        elif item.op == "sum":
            weights, constant = item.data
            text = _weighted_sum([self._at_order(a) for a in item.args], weights, Fraction(0))
            self._set(item, f"{text} + (0.0 if k > 0 else {_decimal(constant)})" if constant else text)
        elif item.op == "scaled":
            self._set(item, f"{self._text[item.args[0]]} * {self._text[item.args[1]]}")
        elif item.op == "select":
            a, b = (self._at_order(x) for x in item.args[1:])
            self._set(item, f"{a} if {self._condition(item.args[0])} else {b}")
        elif item.op == "abs":
            value = self._text[item.args[0]]
            self._set(item, f"{self._at_start(f'-1.0 if {value} < 0.0 else 1.0')} * {value}")
        else:
            self._recurrence(item)

    def _at_start(self, value: str) -> str:
        """A number as it is at order 0."""
        place = f"work[{self._room(1)}]"
        self.lines += ["if k == 0:", f"    {place} = {value}"]
        return place

    def _recurrence(self, item: Item) -> None:
        if item.op not in RECURRENCES:
            self._refuse(item)
        arguments = [self._history(a) for a in item.args]
        history = self._history(item)
        results = [history]
        if item.op in ("sin", "cos"):  # each needs the other
            both = (item if item.op == op else self.ring.apply(op, *item.args) for op in ("sin", "cos"))
            results = [self._history(each) for each in both]
        elif item.op == "atan2":
            results = [_part(self._room(ROWS)), history]
        call = f"{RECURRENCES[item.op].name}({', '.join(['k', *arguments, *results])})"
        if call not in self.lines:
            self.lines.append(call)
        self._text[item] = f"work[k + {self._histories[item]}]"

    def _history(self, item: Item) -> str:
        """A value's coefficients in one piece; those of an argument are put there."""
        if item not in self._histories:
            self._histories[item] = self._room(ROWS)
            if item in self._text or not item.moves:
                self.lines.append(f"work[k + {self._histories[item]}] = {self._at_order(item)}")
        return _part(self._histories[item])


def _part(start: int) -> str:
    return f"work[{start}:{start + ROWS}]"


def _in_dependency_order(roots: Iterable[Item]) -> list[Item]:
    """Items that the roots need, arguments first."""
    seen: dict[int, Item] = {}
    waiting = list(roots)
    while waiting:
        item = waiting.pop()
        if item.number not in seen:
            seen[item.number] = item
            waiting.extend(item.args)
    return [seen[i] for i in sorted(seen)]


def _depends_on_time(mask: Item) -> bool:
    return mask.moves or any(_depends_on_time(a) for a in mask.args)


def _decimal(value: Fraction) -> str:
    """The shortest decimal that reads back as the nearest double."""
    return repr(value.numerator / value.denominator)


def _weighted_sum(parts: Sequence[str], weights: Sequence[Fraction], constant: Fraction) -> str:
    """A weighted sum of values that are names or in brackets."""
    text = ""
    for part, weight in zip(parts, weights, strict=True):
        size = part if abs(weight) == 1 else f"{_decimal(abs(weight))} * {part}"
        text += (f" {'-' if weight < 0 else '+'} {size}") if text else (f"-{size}" if weight < 0 else size)
    return text + (f" + {_decimal(constant)}" if constant else "")
