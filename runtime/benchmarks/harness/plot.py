"""Work-precision plots. Needs matplotlib; imported only when a plot is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, sqrt
from typing import Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import Bbox

from .runner import Measurement, time_unit
from .study import Study

#: Smaller errors are drawn at this value: a logarithmic axis has no zero.
MIN_DRAWN = 1e-18
#: And larger ones at this: there is room above it.
MAX_DRAWN = 1e250
#: Half the width of a 95 % interval of a standard normal variable.
NORMAL_QUANTILE = 1.959964
#: Height of a row in a picture of fractions, in inches.
ROW_HEIGHT = 0.42
#: Width of a column of a legend, in inches.
LEGEND_WIDTH = 2.4
#: Height in a panel, as a fraction, of methods that lost every answer.
LOST_HEIGHT = 0.96
#: Margin of the time axis around the points, for their labels: a factor.
TIME_MARGIN = 3.0
#: Margin of the error axis, in decades.
DECADES = 2.0
#: An axis shorter than this factor has labels between its decades.
SHORT_AXIS = 300.0
#: Offsets of labels from their point, in points of the page: the first free one is used.
LABEL_OFFSETS = [(x, y) for y in (4, -10, 13, -19, 22, -28, 31, -37) for x in (5, -5)]
#: Font size of labels.
LABEL_SIZE = 7
#: Resolution of figures.
DOTS_PER_INCH = 110
#: Lines and marks of the settings of one method, in order.
LINE_STYLES, MARKERS = ("-", "--", ":", "-."), ("o", "s", "^", "D")
#: Half the side of a point's mark, in pixels.
MARK = 4


def draw(study: Study, rows: Sequence[Measurement]) -> Figure:
    """One panel per case, largest error against time per item, a line per method."""
    cases = list(dict.fromkeys(r.case for r in rows))
    methods = list(dict.fromkeys(r.method for r in rows))
    columns = min(len(cases), 3)
    lines = -(-len(cases) // columns)
    name, unit = time_unit([r.nanoseconds for r in rows])
    figure = Figure(figsize=(4.6 * columns, 3.6 * lines + 0.8), dpi=DOTS_PER_INCH, layout="constrained")
    axes = figure.subplots(lines, columns, squeeze=False, sharey=True)
    heights = [_height(r) for r in rows if not _all_lost(r)] or [1.0]
    above = DECADES * (2 if any(_all_lost(r) for r in rows) else 1)  # crosses and their labels stand there
    for panel, case in zip(axes.flat, cases, strict=False):
        case_rows = [r for r in rows if r.case == case]
        times = [r.nanoseconds / unit for r in case_rows]
        panel.set(xscale="log", yscale="log", title=case, xlabel=f"{name} per item")
        panel.set_xlim(min(times) / TIME_MARGIN, max(times) * TIME_MARGIN)
        panel.set_ylim(min(heights) / 10**DECADES, max(heights) * 10**above)
        _ticks(panel.xaxis, max(times) / min(times))
        panel.grid(True, which="major", alpha=0.3)
        for number, method in enumerate(methods):
            points = [(r.nanoseconds / unit, r) for r in case_rows if r.method == method]
            _curve(panel, points, f"C{number}", alpha=0.5)
    for panel in list(axes.flat)[len(cases) :]:
        panel.set_visible(False)
    for row in axes:
        row[0].set_ylabel(f"largest error ({study.unit})")
    _legend(figure, methods, rows)
    figure.draw_without_rendering()  # labels are placed in the final layout
    for panel, case in zip(axes.flat, cases, strict=False):
        _label(panel, [r for r in rows if r.case == case], unit)
    return figure


def draw_fractions(study: Study, rows: Sequence[Measurement]) -> Figure:
    """A row per case and method: the fraction of items that are not lost, with its 95 % confidence interval (Wilson's),
    against the promised fraction."""
    assert study.promised is not None
    promised = 100 * study.promised
    figure = Figure(figsize=(9.2, ROW_HEIGHT * len(rows) + 1.5), dpi=DOTS_PER_INCH, layout="constrained")
    panel = figure.subplots()
    methods = list(dict.fromkeys(r.method for r in rows))
    for height, row in enumerate(rows):
        fraction, low, high = (100 * x for x in _interval(row.count - row.lost, row.count))
        color = f"C{methods.index(row.method)}" if low <= promised <= high else "C3"
        panel.plot([low, high], [height, height], "-", color=color, lw=2)
        panel.plot([fraction], [height], "o", color=color)
        note = f"{fraction:.1f} % ({row.count - row.lost} of {row.count})"
        panel.annotate(note, (1.01, height), xycoords=panel.get_yaxis_transform(), fontsize=LABEL_SIZE + 1, va="center")
    panel.axvline(promised, color="black", lw=1, ls="--")
    several = len(methods) > 1
    names = [f"{r.case}\n{r.method}" if several else r.case for r in rows]
    panel.set_yticks(range(len(rows)), names, fontsize=LABEL_SIZE + 2)
    panel.set_ylim(len(rows) - 0.4, -0.6)
    panel.set_xlabel(f"fraction not lost, in percent; dashed: the {promised:g} % that are promised")
    panel.set_title(", ".join(methods))
    panel.grid(True, axis="x", alpha=0.3)
    inside = Line2D([], [], marker="o", color="C0", label="95 % interval holds what is promised")
    outside = Line2D([], [], marker="o", color="C3", label="it does not")
    figure.legend(handles=[inside, outside], loc="outside lower center", ncols=2, frameon=False)
    return figure


def _interval(hits: int, count: int) -> tuple[float, float, float]:
    """Fraction of hits, and its 95 % confidence interval (Wilson's)."""
    fraction, z = hits / count, NORMAL_QUANTILE * NORMAL_QUANTILE / count
    center, half = (fraction + z / 2) / (1 + z), sqrt(fraction * (1 - fraction) * z + z * z / 4) / (1 + z)
    return fraction, max(center - half, 0.0), min(center + half, 1.0)


def draw_sweeps(study: Study, rows: Sequence[Measurement]) -> Figure:
    """One panel per sweep: largest error against the varied quantity, a line per method and setting; if the study has
    ``draws_fractions``, below a panel of the fraction of items that are not lost.

    Colors are those of the methods, or of the settings of a single one; lines and marks those of a method's settings.
    """
    names = list(dict.fromkeys(r.sweep for r in rows if r.sweep))
    lines = list(dict.fromkeys((r.method, r.setting_text) for r in rows if r.sweep))
    size = (4.6 * len(names), 7.2 if study.draws_fractions else 4.4)
    figure = Figure(figsize=size, dpi=DOTS_PER_INCH, layout="constrained")
    grid = figure.subplots(2 if study.draws_fractions else 1, len(names), squeeze=False, sharex="col", sharey="row")
    methods = list(dict.fromkeys(method for method, _ in lines))
    handles: dict[str, Any] = {}
    looks: dict[tuple[str, str], tuple[str, Any, str]] = {}
    for number, (method, setting) in enumerate(lines):
        own = [line for line in lines if line[0] == method].index((method, setting))
        color = f"C{methods.index(method) if len(methods) > 1 else number}"
        looks[method, setting] = color, LINE_STYLES[own % len(LINE_STYLES)], MARKERS[own % len(MARKERS)]
    for column, name in zip(grid.T, names, strict=True):
        panel, values = column[-1], [float(r.value or 0) for r in rows if r.sweep == name]
        panel.set(xscale="log", yscale="log", xlabel=name)
        _ticks(panel.xaxis, max(values) / min(values) / TIME_MARGIN**2)  # varied quantities have short numbers
        for each in column:
            each.grid(True, which="major", alpha=0.3)
        for method, setting in lines:
            case_rows = [r for r in rows if r.sweep == name and (r.method, r.setting_text) == (method, setting)]
            color, style, marker = looks[method, setting]
            label = f"{method}, {setting}" if setting else method
            handles.setdefault(label, Line2D([], [], linestyle=style, marker=marker, ms=4, color=color, label=label))
            _curve(panel, [(float(r.value or 0), r) for r in case_rows], color, style, marker, ms=4)
            if study.draws_fractions:
                fractions = [1 - r.lost / r.count for r in case_rows]
                ms = 4 + 2 * (len(methods) - 1 - methods.index(method))  # equal ones are seen behind each other
                column[0].plot([r.value for r in case_rows], fractions, style, marker=marker, ms=ms, color=color)
    grid[-1, 0].set_ylabel(f"largest error ({study.unit})")
    if study.draws_fractions:
        grid[0, 0].set(ylabel="fraction not lost", ylim=(-0.06, 1.06))
    figure.legend(handles=list(handles.values()), loc="outside upper center", ncols=3, frameon=False)
    return figure


def _ticks(axis: Any, span: float) -> None:
    """Label 1, 2 and 5 on an axis of about a decade; else the decades alone."""
    plain = FuncFormatter(lambda x, _: f"{x:g}")
    axis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
    axis.set_minor_formatter(plain if span * TIME_MARGIN**2 < SHORT_AXIS else NullFormatter())
    if span * TIME_MARGIN**2 < SHORT_AXIS:
        axis.set_major_formatter(plain)


def _height(row: Measurement) -> float:
    """Height of an error; zero is drawn at the bottom."""
    return min(max(row.max_error, MIN_DRAWN), MAX_DRAWN)


def _all_lost(row: Measurement) -> bool:
    """No answer has an error that could be drawn: not finite, or all that were found are of empty ones."""
    return not isfinite(row.max_error) or (row.lost > 0 and not row.max_error > 0)


def _curve(
    panel: Any, points: Sequence[tuple[float, Measurement]], color: str, style: Any = "-", marker: str = "o",
    alpha: float | None = None, ms: float | None = None,
) -> None:  # fmt: skip
    """Points of one method; hollow where answers were lost, crosses at the top edge where all were."""
    drawn = [(x, r) for x, r in points if not _all_lost(r)]
    panel.plot([x for x, _ in drawn], [_height(r) for _, r in drawn], linestyle=style, color=color, alpha=alpha)
    for x, r in drawn:
        panel.plot([x], [_height(r)], marker, color=color, fillstyle="none" if r.lost else "full", ms=ms)
    for x, r in points:
        if _all_lost(r):
            panel.plot([x], [LOST_HEIGHT], "x", color=color, transform=panel.get_xaxis_transform())


def _legend(figure: Figure, methods: Sequence[str], rows: Sequence[Measurement]) -> None:
    knobs = {r.method: f" ({r.knob})" for r in rows if r.setting}  # settings are written beside the points
    names = [method + knobs.get(method, "") for method in methods]
    handles = [Line2D([], [], color=f"C{i}", marker="o", label=name) for i, name in enumerate(names)]
    if any(r.lost and not _all_lost(r) for r in rows):
        label = "hollow: some answers lost"
        handles.append(Line2D([], [], color="gray", marker="o", fillstyle="none", linestyle="", label=label))
    if any(_all_lost(r) for r in rows):
        label = "cross at the top: lost, no error to show"
        handles.append(Line2D([], [], color="gray", marker="x", linestyle="", label=label))
    columns = max(1, min(len(handles), 3, int(figure.get_figwidth() // LEGEND_WIDTH)))
    figure.legend(handles=handles, loc="outside upper center", ncols=columns, frameon=False)


def _label(panel: Any, rows: Sequence[Measurement], unit: float) -> None:
    """Settings, whose names are in the legend, and losses beside the points, in the first free place of their panel."""
    across = panel.get_xaxis_transform()
    anchors = [
        ((r.nanoseconds / unit, LOST_HEIGHT), across)
        if _all_lost(r)
        else ((r.nanoseconds / unit, _height(r)), panel.transData)
        for r in rows
    ]
    pixels = [system.transform(point) for point, system in anchors]
    taken = [Bbox.from_extents(x - MARK, y - MARK, x + MARK, y + MARK) for x, y in pixels]
    for row, (point, system) in zip(rows, anchors, strict=True):
        note = " ".join(part for part in (row.setting, f"({row.lost} lost)" if row.lost else "") if part)
        if note:
            taken.append(_place_label(panel, note, point, system, taken))


def _place_label(panel: Any, note: str, point: tuple[float, float], system: Any, taken: Sequence[Any]) -> Any:
    """Draw one label at the offset of least overlap; return its box."""
    label = panel.annotate(
        note, point, LABEL_OFFSETS[0], xycoords=system, textcoords="offset points", fontsize=LABEL_SIZE
    )
    label.set_in_layout(False)
    frame, faults = panel.get_window_extent(), []

    def box_at(number: int) -> Any:
        label.set_position(LABEL_OFFSETS[number])
        label.set_horizontalalignment("left" if LABEL_OFFSETS[number][0] > 0 else "right")
        return label.get_window_extent()

    for number in range(len(LABEL_OFFSETS)):
        box = box_at(number)
        is_inside = frame.x0 <= box.x0 and box.x1 <= frame.x1 and frame.y0 <= box.y0 and box.y1 <= frame.y1
        faults.append((not is_inside, sum(box.overlaps(other) for other in taken), number))
    return box_at(min(faults)[-1])
