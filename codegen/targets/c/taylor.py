"""C text of power series: coefficient k of what a formula computes, level by level of its products.

Products of one level are convolved together, one lane each; functions follow recurrences of templates/c/lib/series.h.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from ...errors import TraceError
from ...rings.power_series import Item, SeriesRing
from ..printer import decimal
from .printer import CONSTANTS, FUNCTIONS

#: Highest order of a series, and so rows of its history: more than any tolerance of doubles asks for.
HIGHEST_ORDER = 24
ROWS = HIGHEST_ORDER + 1
#: Products are made in groups of this many lanes: a whole number of vectors of any width.
LANES = 4
#: Accumulators of one convolution: half the registers of every machine.
ACCUMULATORS = 8
#: Widths of vectors (in doubles) that the text is written for: no vectors, those of every machine, AVX2.
WIDTHS = {1: "plain", 2: "base", 4: "wide"}
_MASKS = ("lt", "le", "and", "or", "not")
_RECURRENCES = ("reciprocal", "sqrt", "exp", "log", "sin", "cos", "atan2")


class SeriesPrinter:
    """The text of one function for vectors of one width."""

    def __init__(self, ring: SeriesRing, outputs: Sequence[tuple[str, tuple[Item, ...]]], width: int) -> None:
        self.ring, self.outputs, self.width = ring, outputs, width
        self.order = _in_dependency_order([item for _, items in outputs for item in items])
        self.size = self.products = 0
        self.kept: list[str] = []  # statements at order 0: numbers that do not move
        self.lines: list[str] = []
        self.text: dict[Item, str] = {}
        self.histories: dict[Item, int] = {}

    def function(self, name: str, inputs: Sequence[str], still: Sequence[str]) -> str:
        """All of it."""
        for item in self.order:
            if not item.moves and item.op not in _MASKS:
                self._number(item)
        for level in range(max((item.level for item in self.order), default=0) + 1):
            here = [item for item in self.order if item.level == level and (item.moves or item.op in _MASKS)]
            self._convolve([item for item in here if item.op == "product"])
            for item in here:
                if item.op != "product":
                    self._series(item)
        stores = [
            f"{output}[{j}] = {self._at_order(item)};" for output, items in self.outputs for j, item in enumerate(items)
        ]
        arguments = ["int k", "double *RESTRICT work", *(f"double *RESTRICT {output}" for output, _ in self.outputs)]
        arguments += [f"const double *RESTRICT {i}_in" for i in inputs]
        unused = [f"(void){i}_in;" for i in inputs] + ["(void)work;"]
        opening = ["if (!k) {", *(f"  {line}" for line in self.kept), "}"] if self.kept else []
        body = "\n".join(f"  {line}" for line in (*unused, *opening, *self.lines, *stores))
        return f"BS_INLINE void FN({name})({', '.join(arguments)})\n{{\n{body}\n}}\n"

    def _room(self, count: int) -> int:
        self.size += count
        return self.size - count

    # -- what does not move --------------------------------------------------------------------------------

    def _number(self, item: Item) -> None:
        if item.op == "const":
            self.text[item] = f"K({decimal(item.data)})"
        elif item.op == "input":
            self.text[item] = f"{item.data[0]}_in[{item.data[1]}]"
        else:
            if any(a.moves or (a.op in _MASKS and _looks_at_motion(a)) for a in item.args):
                raise AssertionError("what depends on motion moves")
            place = f"work[{self._room(1)}]"
            self.kept.append(f"{place} = {self._formula(item)};")
            self.text[item] = place

    def _formula(self, item: Item) -> str:
        """A number, or a mask, from others by one operation."""
        args = [self._condition(a) if a.op in _MASKS else self.text[a] for a in item.args]
        if item.op in ("mul", "scaled"):
            return f"{args[0]} * {args[1]}"
        if item.op == "sum":
            return _weighted_sum(args, item.data[0], item.data[1])
        if item.op == "reciprocal":
            return f"K(1.0) / {args[0]}"
        if item.op in CONSTANTS:
            return CONSTANTS[item.op]
        return f"{FUNCTIONS[item.op]}({', '.join(args)})"

    def _condition(self, mask: Item) -> str:
        """A mask as a condition."""
        return f"({self.text[mask]} != 0)" if mask in self.text else f"({self._formula(mask)})"

    # -- series --------------------------------------------------------------------------------------------

    def _at_order(self, item: Item) -> str:
        """Coefficient k of a value."""
        if item.moves:
            return self.text[item]
        return "K(0.0)" if item is self.ring.zero else f"(k ? K(0.0) : {self.text[item]})"

    def _set(self, item: Item, text: str) -> None:
        name = f"t{item.number}"
        self.lines.append(f"const double {name} = {text};")
        self.text[item] = name

    def _convolve(self, items: Sequence[Item]) -> None:
        """Products of one level, a lane each."""
        if not items:
            return
        self.products += len(items)
        count = -(-len(items) // LANES) * LANES
        a, b = (self._room(ROWS * count) for _ in range(2))
        name = f"p{items[0].level}"
        self.lines += [f"double *{name}a = work + {a}, *{name}b = work + {b}, {name}[{count}];"]
        for lane in range(count):
            sides = items[lane].args if lane < len(items) else (self.ring.zero, self.ring.zero)
            for side, item in zip("ab", sides, strict=True):
                self.lines.append(f"{name}{side}[{count} * k + {lane}] = {self._at_order(item)};")
        block = ACCUMULATORS * self.width
        for start in range(0, count, block):
            self._block(name, count, start, min(block, count - start))
        for lane, item in enumerate(items):
            self.text[item] = f"{name}[{lane}]"

    def _block(self, name: str, count: int, start: int, lanes: int) -> None:
        """Some of them, in registers."""
        vector = f"FN(lanes_{WIDTHS[self.width]})"
        sums = [(f"c{i}", start + self.width * i) for i in range(lanes // self.width)]

        def at(row: str, lane: int) -> str:
            return f"*(const {vector} *)({row} + {lane})"

        self.lines += [
            "{",
            f"  const double *x = {name}a, *y = {name}b + {count} * k;",
            *(f"  {vector} {c} = {at('x', lane)} * {at('y', lane)};" for c, lane in sums),
            "  for (int j = 0; j < k; j++) {",
            f"    x += {count};",
            f"    y -= {count};",
            *(f"    {c} += {at('x', lane)} * {at('y', lane)};" for c, lane in sums),
            "  }",
            *(f"  *({vector} *)({name} + {lane}) = {c};" for c, lane in sums),
            "}",
        ]

    def _series(self, item: Item) -> None:
        if item.op == "input":
            self.text[item] = f"{item.data[0]}_in[{item.data[1]}]"
        elif item.op in _MASKS:
            if _looks_at_motion(item):  # as it is at the start
                place = f"work[{self._room(1)}]"
                formula = self._formula(item)
                self.lines.append(f"if (!k) {place} = {formula};")
                self.text[item] = place
        elif item.op == "sum":
            (weights, constant), parts = item.data, [self._at_order(a) for a in item.args]
            text = _weighted_sum(parts, weights, Fraction(0))
            self._set(item, f"{text} + (k ? K(0.0) : K({decimal(constant)}))" if constant else text)
        elif item.op == "scaled":
            self._set(item, f"{self.text[item.args[0]]} * {self.text[item.args[1]]}")
        elif item.op == "select":
            a, b = (self._at_order(x) for x in item.args[1:])
            self._set(item, f"{self._condition(item.args[0])} ? {a} : {b}")
        elif item.op == "abs":
            place = f"work[{self._room(1)}]"
            self.lines.append(f"if (!k) {place} = {self.text[item.args[0]]} < 0 ? K(-1.0) : K(1.0);")
            self._set(item, f"{place} * {self.text[item.args[0]]}")
        else:
            self._recurrence(item)

    def _recurrence(self, item: Item) -> None:
        if item.op not in _RECURRENCES:
            raise TraceError(f"{item.op} has no Taylor recurrence; take another integrator.")
        arguments = ", ".join(self._history(a) for a in item.args)
        history = self._history(item)
        if item.op in ("sin", "cos"):  # each needs the other
            both = [self._history(self._twin(item, op)) for op in ("sin", "cos")]
            call = f"FN(series_sin_cos)(k, {arguments}, {both[0]}, {both[1]});"
            if call not in self.lines:
                self.lines.append(call)
        else:
            scratch = [f"work + {self._room(2 * ROWS)}"] if item.op == "atan2" else []
            self.lines.append(f"FN(series_{item.op})(k, {', '.join([arguments, *scratch, history])});")
        self.text[item] = f"work[{self.histories[item]} + k]"

    def _twin(self, item: Item, op: str) -> Item:
        return item if item.op == op else self.ring.apply(op, *item.args)

    def _history(self, item: Item) -> str:
        """Offset of a value's coefficients, which are contiguous; those of an argument are put there."""
        if item not in self.histories:
            self.histories[item] = self._room(ROWS)
            if item in self.text or not item.moves:
                self.lines.append(f"work[{self.histories[item]} + k] = {self._at_order(item)};")
        return f"work + {self.histories[item]}"


def _in_dependency_order(roots: Sequence[Item]) -> list[Item]:
    """Items that the roots need, arguments first."""
    seen: dict[int, Item] = {}
    waiting = list(roots)
    while waiting:
        item = waiting.pop()
        if item.number not in seen:
            seen[item.number] = item
            waiting.extend(item.args)
    return [seen[i] for i in sorted(seen)]


def _looks_at_motion(mask: Item) -> bool:
    return mask.moves or any(_looks_at_motion(a) for a in mask.args)


def _weighted_sum(parts: Sequence[str], weights: Sequence[Fraction], constant: Fraction) -> str:
    """A weighted sum of values that are names or in brackets."""
    text = ""
    for part, weight in zip(parts, weights, strict=True):
        size = part if abs(weight) == 1 else f"K({decimal(abs(weight))}) * {part}"
        text += (f" {'-' if weight < 0 else '+'} {size}") if text else (f"-{size}" if weight < 0 else size)
    if constant:
        text += f" + K({decimal(constant)})"
    return text
