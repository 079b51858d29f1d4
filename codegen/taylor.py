"""Taylor series of kernels: C text that makes coefficient k of the outputs from those up to k of the inputs.

Kernels are run on a ring of power series. Products of one level of the graph are convolved together, one lane each;
what does not vary in time is scaled by, never convolved; functions follow the recurrences of templates/c/series.h.
Coefficients are normalised: x = sum of x_k t^k.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from .errors import TraceError
from .rings import Terms
from .targets.c import CONSTANTS, ELEMENTARY, FUNCTIONS
from .targets.printer import decimal
from .trace import Kernel

#: Highest order of a series, and so rows of its history: more than any tolerance of doubles asks for.
HIGHEST_ORDER = 40
ROWS = HIGHEST_ORDER + 1
#: Products are made in groups of this many lanes: a whole number of vectors of any width.
LANES = 4
#: Accumulators of one convolution: half the registers of every machine.
ACCUMULATORS = 8
#: Widths of vectors (in doubles) that the text is written for: no vectors, those of every machine, AVX2.
WIDTHS = {1: "plain", 2: "base", 4: "wide"}
_MASKS = ("lt", "le", "and", "or", "not")
_RECURRENCES = ("reciprocal", "sqrt", "exp", "log", "sin", "cos", "atan2")


@dataclass(frozen=True, eq=False)
class Item:
    """One value. What moves is a series; the rest is a number all the time.

    ``level`` counts the convolutions on the way from the inputs.
    """

    number: int
    op: str
    args: tuple[Item, ...]
    data: Any
    moves: bool
    level: int


class SeriesRing:
    """Power series in time as the coefficients of multivectors; what is alike is made once."""

    is_symbolic = True

    def __init__(self) -> None:
        self.items: list[Item] = []
        self._known: dict[Any, Item] = {}
        self.zero = self.constant(Fraction(0))

    def _item(self, op: str, args: Sequence[Item], data: Any = None, moves: bool | None = None) -> Item:
        key = op, tuple(a.number for a in args), data
        if key not in self._known:
            moves = any(a.moves for a in args) if moves is None else moves
            level = max((a.level for a in args), default=0) + (op == "product")
            item = self._known[key] = Item(len(self.items), op, tuple(args), data, moves, level)
            self.items.append(item)
        return self._known[key]

    def input(self, name: str, index: int, moves: bool) -> Item:
        """Coefficient of an argument."""
        return self._item("input", (), (name, index), moves)

    def constant(self, value: Fraction) -> Item:
        """A number known now."""
        return self._item("const", (), Fraction(value))

    def combine(self, terms: Terms) -> Item:
        """Weighted sum; numbers known now are folded."""
        weights: dict[Item, Fraction] = {}
        constant = Fraction(0)
        for item, weight in terms:
            if item.op == "const":
                constant += item.data * weight
            elif item.op == "sum" and len(item.args) == 1 and not item.data[1]:
                weights[item.args[0]] = weights.get(item.args[0], Fraction(0)) + weight * item.data[0][0]
            else:
                weights[item] = weights.get(item, Fraction(0)) + weight
        weights = {item: weight for item, weight in weights.items() if weight}
        if not weights:
            return self.constant(constant)
        if len(weights) == 1 and not constant and next(iter(weights.values())) == 1:
            return next(iter(weights))
        return self._item("sum", tuple(weights), (tuple(weights.values()), constant))

    def multiply(self, a: Item, b: Item) -> Item:
        """Product: of two series a convolution, with numbers in front of it."""
        for x, y in ((a, b), (b, a)):
            if x.op == "const":
                return self.combine([(y, x.data)])
        (a, front, weight), (b, other, also) = _taken_apart(a), _taken_apart(b)
        fronts = [f for f in (front, other) if f is not None]
        if a.moves and b.moves:
            found = self._item("product", sorted((a, b), key=lambda x: x.number))
        elif a.moves or b.moves:
            found = a if a.moves else b
            fronts.append(b if a.moves else a)
        else:
            found = self._item("mul", (a, b))
        if fronts:
            factor = fronts[0] if len(fronts) == 1 else self._item("mul", fronts[:2])
            for more in fronts[2:]:
                factor = self._item("mul", (factor, more))
            found = self._item("scaled", (factor, found))
        return self.combine([(found, weight * also)])

    def apply(self, name: str, *arguments: Item) -> Item:
        """A function; comparisons hold as they are at the start of the series."""
        if name == "rounded":
            return arguments[0]
        return self._item(name, arguments)

    def select(self, mask: Item, a: Item, b: Item) -> Item:
        """One of two, as the mask is at the start of the series."""
        return a if a is b else self._item("select", (mask, a, b))

    def is_zero(self, a: Item) -> bool:
        """Whether it vanishes by the way it is made."""
        return a is self.zero


def _taken_apart(item: Item) -> tuple[Item, Item | None, Fraction]:
    """A value without the numbers in front of it: what is left, a number that does not move, and a weight."""
    weight = Fraction(1)
    if item.op == "sum" and len(item.args) == 1 and not item.data[1]:
        item, weight = item.args[0], item.data[0][0]
    if item.op == "scaled":
        return item.args[1], item.args[0], weight
    return item, None, weight


@dataclass(frozen=True)
class SeriesFunction:
    """The text of one function, for each width of vectors.

    Attributes
    ----------
    name : str
    texts : mapping of str to str
        By the names of `WIDTHS`.
    inputs, outputs : mapping of str to int
        Its arguments after the order and the work space, outputs first: numbers of each.
    work : int
        Numbers that it keeps from order to order.
    products : int
        Convolutions.
    elementary : bool
        Whether it needs elementary.h.
    """

    name: str
    texts: Mapping[str, str]
    inputs: Mapping[str, int]
    outputs: Mapping[str, int]
    work: int
    products: int
    elementary: bool


def series_function(name: str, kernels: Sequence[Kernel], still: Sequence[str] = ()) -> SeriesFunction:
    """Kernels as one function of series, arguments of one name being one argument.

    Parameters
    ----------
    name : str
        Of the function.
    kernels : sequence of Kernel
        Their outputs become those of the function, in order; alike names are told apart by the kernels' names.
    still : sequence of str
        Arguments that do not vary in time: numbers, not series.

    Raises
    ------
    TraceError
        If a function has no recurrence (Stumpff functions: they have none of bounded length at zero).
    """
    ring = SeriesRing()
    outputs: list[tuple[str, tuple[Item, ...]]] = []
    inputs: dict[str, int] = {}
    for kernel in kernels:
        flat = [ring.input(i.name, j, i.name not in still) for i in kernel.inputs for j in range(i.kind.size)]
        inputs.update({i.name: i.kind.size for i in kernel.inputs})
        for output, values in zip(kernel.outputs, kernel.evaluate_flat(flat, ring), strict=True):
            several = f"{kernel.name}_{output.name}" if len(kernel.outputs) > 1 else kernel.name
            own = output.name if len(kernels) == 1 else several
            outputs.append((own, tuple(values)))
    texts = {}
    for width, tag in WIDTHS.items():
        printer = _Printer(ring, outputs, width)
        texts[tag] = printer.function(f"{name}_{tag}", list(inputs), [i for i in inputs if i in still])
    needed = {item.op for item in printer.order}
    sizes = {output: len(items) for output, items in outputs}
    return SeriesFunction(name, texts, inputs, sizes, printer.size, printer.products, bool(needed & ELEMENTARY))


class _Printer:
    """The text of one function for vectors of one width."""

    def __init__(self, ring: SeriesRing, outputs: Sequence[tuple[str, tuple[Item, ...]]], width: int) -> None:
        self.ring, self.outputs, self.width = ring, outputs, width
        self.order = _needed([item for _, items in outputs for item in items])
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
        args = [self._masked(a) if a.op in _MASKS else self.text[a] for a in item.args]
        if item.op in ("mul", "scaled"):
            return f"{args[0]} * {args[1]}"
        if item.op == "sum":
            return _weighted(args, item.data[0], item.data[1])
        if item.op == "reciprocal":
            return f"K(1.0) / {args[0]}"
        if item.op in CONSTANTS:
            return CONSTANTS[item.op]
        return f"{FUNCTIONS[item.op]}({', '.join(args)})"

    def _masked(self, mask: Item) -> str:
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
            text = _weighted(parts, weights, Fraction(0))
            self._set(item, f"{text} + (k ? K(0.0) : K({decimal(constant)}))" if constant else text)
        elif item.op == "scaled":
            self._set(item, f"{self.text[item.args[0]]} * {self.text[item.args[1]]}")
        elif item.op == "select":
            a, b = (self._at_order(x) for x in item.args[1:])
            self._set(item, f"{self._masked(item.args[0])} ? {a} : {b}")
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
        self._set(item, f"({history})[k]")

    def _twin(self, item: Item, op: str) -> Item:
        return item if item.op == op else self.ring.apply(op, *item.args)

    def _history(self, item: Item) -> str:
        """Where a value's coefficients stand one after another; those of an argument are put there."""
        if item not in self.histories:
            self.histories[item] = self._room(ROWS)
            if item in self.text or not item.moves:
                self.lines.append(f"work[{self.histories[item]} + k] = {self._at_order(item)};")
        return f"work + {self.histories[item]}"


def _needed(roots: Sequence[Item]) -> list[Item]:
    """What the roots need, arguments first."""
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


def _weighted(parts: Sequence[str], weights: Sequence[Fraction], constant: Fraction) -> str:
    """A weighted sum of values that are names or in brackets."""
    text = ""
    for part, weight in zip(parts, weights, strict=True):
        size = part if abs(weight) == 1 else f"K({decimal(abs(weight))}) * {part}"
        text += (f" {'-' if weight < 0 else '+'} {size}") if text else (f"-{size}" if weight < 0 else size)
    if constant:
        text += f" + K({decimal(constant)})"
    return text
