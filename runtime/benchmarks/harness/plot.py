"""Work-precision plots. Needs matplotlib; imported only when a plot is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import Bbox

from .runner import Measurement, time_unit
from .study import Study

#: Errors below this are drawn on this line: a logarithmic axis has no zero.
SMALLEST_DRAWN = 1e-18
#: Half the width of a 95 % interval of normal numbers; inches of a row of a picture of shares.
NORMAL, ROW_HEIGHT = 1.959964, 0.42
#: Inches that a column of a legend takes.
LEGEND_WIDTH = 2.4
#: Where in a panel's height methods stand that lost every answer.
TOP = 0.96
#: Room around the points, for their labels: a factor of time, and decades of error.
TIME_MARGIN, DECADES = 3.0, 2.0
#: An axis shorter than this factor has labels between its decades.
FEW_DECADES = 300.0
#: Labels are tried at these places around their point, in points of the page: the first that is free wins.
PLACES = [(x, y) for y in (4, -10, 13, -19, 22, -28, 31, -37) for x in (5, -5)]
LABEL_SIZE, DOTS_PER_INCH = 7, 110
#: Half the side of what a point's mark covers, in pixels.
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
        own = [r for r in rows if r.case == case]
        times = [r.nanoseconds / unit for r in own]
        panel.set(xscale="log", yscale="log", title=case, xlabel=f"{name} per item")
        panel.set_xlim(min(times) / TIME_MARGIN, max(times) * TIME_MARGIN)
        panel.set_ylim(min(heights) / 10**DECADES, max(heights) * 10**above)
        _ticks(panel.xaxis, max(times) / min(times))
        panel.grid(True, which="major", alpha=0.3)
        for number, method in enumerate(methods):
            _curve(panel, [r for r in own if r.method == method], f"C{number}", unit)
    for panel in list(axes.flat)[len(cases) :]:
        panel.set_visible(False)
    for row in axes:
        row[0].set_ylabel(f"largest error ({study.unit})")
    _legend(figure, methods, rows)
    figure.draw_without_rendering()  # the layout is known only then, and labels go where there is room
    for panel, case in zip(axes.flat, cases, strict=False):
        _label(panel, [r for r in rows if r.case == case], unit)
    return figure


def draw_shares(study: Study, rows: Sequence[Measurement]) -> Figure:
    """A row per case and method: the share of items that are not lost, with the 95 % interval of a share of so many
    (Wilson's), against the share that is promised."""
    assert study.promised is not None
    promised = 100 * study.promised
    figure = Figure(figsize=(9.2, ROW_HEIGHT * len(rows) + 1.5), dpi=DOTS_PER_INCH, layout="constrained")
    panel = figure.subplots()
    methods = list(dict.fromkeys(r.method for r in rows))
    for place, row in enumerate(rows):
        share, low, high = (100 * x for x in _interval(row.count - row.lost, row.count))
        color = f"C{methods.index(row.method)}" if low <= promised <= high else "C3"
        panel.plot([low, high], [place, place], "-", color=color, lw=2)
        panel.plot([share], [place], "o", color=color)
        note = f"{share:.1f} % ({row.count - row.lost} of {row.count})"
        panel.annotate(note, (1.01, place), xycoords=panel.get_yaxis_transform(), fontsize=LABEL_SIZE + 1, va="center")
    panel.axvline(promised, color="black", lw=1, ls="--")
    several = len(methods) > 1
    names = [f"{r.case}\n{r.method}" if several else r.case for r in rows]
    panel.set_yticks(range(len(rows)), names, fontsize=LABEL_SIZE + 2)
    panel.set_ylim(len(rows) - 0.4, -0.6)
    panel.set_xlabel(f"share not lost, in percent; dashed: the {promised:g} % that are promised")
    panel.set_title(", ".join(methods))
    panel.grid(True, axis="x", alpha=0.3)
    inside = Line2D([], [], marker="o", color="C0", label="95 % interval holds what is promised")
    outside = Line2D([], [], marker="o", color="C3", label="it does not")
    figure.legend(handles=[inside, outside], loc="outside lower center", ncols=2, frameon=False)
    return figure


def _interval(hits: int, count: int) -> tuple[float, float, float]:
    """The share of hits, and the 95 % interval of what it may come from (Wilson's)."""
    share, z = hits / count, NORMAL * NORMAL / count
    middle, half = (share + z / 2) / (1 + z), sqrt(share * (1 - share) * z + z * z / 4) / (1 + z)
    return share, max(middle - half, 0.0), min(middle + half, 1.0)


def draw_sweeps(study: Study, rows: Sequence[Measurement]) -> Figure:
    """One panel per sweep: largest error against what is varied, a line per method and setting; where the study asks
    for it, below a panel of the share of items that are not lost."""
    names = list(dict.fromkeys(r.sweep for r in rows if r.sweep))
    lines = list(dict.fromkeys((r.method, r.setting) for r in rows if r.sweep))
    size = (4.6 * len(names), 7.2 if study.shares else 4.4)
    figure = Figure(figsize=size, dpi=DOTS_PER_INCH, layout="constrained")
    grid = figure.subplots(2 if study.shares else 1, len(names), squeeze=False, sharex="col", sharey="row")
    methods = list(dict.fromkeys(method for method, _ in lines))
    handles: dict[str, Any] = {}
    for column, name in zip(grid.T, names, strict=True):
        panel, values = column[-1], [float(r.value or 0) for r in rows if r.sweep == name]
        panel.set(xscale="log", yscale="log", xlabel=name)
        _ticks(panel.xaxis, max(values) / min(values) / TIME_MARGIN**2)  # what is varied has short numbers
        for each in column:
            each.grid(True, which="major", alpha=0.3)
        for method, setting in lines:
            own = [r for r in rows if r.sweep == name and (r.method, r.setting) == (method, setting)]
            found = [r for r in own if not _all_lost(r)]
            style: Any = "--" if setting == "float32" else "-"
            color, rank = f"C{methods.index(method)}", len(methods) - 1 - methods.index(method)
            label = f"{method} {setting}".strip()
            handles.setdefault(label, Line2D([], [], linestyle=style, color=color, label=label))
            panel.plot([r.value for r in found], [_height(r) for r in found], style, color=color)
            for r in found:
                panel.plot([r.value], [_height(r)], "o", color=color, fillstyle="none" if r.lost else "full", ms=4)
            for r in own:
                if _all_lost(r):
                    panel.plot([r.value], [TOP], "x", color=color, transform=panel.get_xaxis_transform())
            if study.shares:
                kept = [1 - r.lost / r.count for r in own]
                column[0].plot(
                    [r.value for r in own], kept, style, marker="o", ms=4 + 2 * rank, color=color
                )  # seen behind each other
    grid[-1, 0].set_ylabel(f"largest error ({study.unit})")
    if study.shares:
        grid[0, 0].set(ylabel="share not lost", ylim=(-0.06, 1.06))
    figure.legend(handles=list(handles.values()), loc="outside upper center", ncols=3, frameon=False)
    return figure


def _ticks(axis: Any, span: float) -> None:
    """Plain numbers at 1, 2 and 5 where there is hardly a decade; else at the decades alone."""
    plain = FuncFormatter(lambda x, _: f"{x:g}")
    axis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
    axis.set_minor_formatter(plain if span * TIME_MARGIN**2 < FEW_DECADES else NullFormatter())
    if span * TIME_MARGIN**2 < FEW_DECADES:
        axis.set_major_formatter(plain)


def _height(row: Measurement) -> float:
    """Where an error is drawn: no error at all at the bottom."""
    return max(row.max_error, SMALLEST_DRAWN)


def _all_lost(row: Measurement) -> bool:
    """No answer has an error that could be drawn: not finite, or all that were found are of empty ones."""
    return row.lost > 0 and not row.max_error > 0


def _curve(panel: Any, rows: Sequence[Measurement], color: str, unit: float) -> None:
    """Points of one method; hollow where answers were lost, crosses at the top edge where all were."""
    drawn = [r for r in rows if not _all_lost(r)]
    panel.plot([r.nanoseconds / unit for r in drawn], [_height(r) for r in drawn], "-", color=color, alpha=0.5)
    for r in drawn:
        panel.plot([r.nanoseconds / unit], [_height(r)], "o", color=color, fillstyle="none" if r.lost else "full")
    for r in rows:
        if _all_lost(r):
            panel.plot([r.nanoseconds / unit], [TOP], "x", color=color, transform=panel.get_xaxis_transform())


def _legend(figure: Figure, methods: Sequence[str], rows: Sequence[Measurement]) -> None:
    handles = [Line2D([], [], color=f"C{i}", marker="o", label=method) for i, method in enumerate(methods)]
    if any(r.lost and not _all_lost(r) for r in rows):
        label = "hollow: some answers lost"
        handles.append(Line2D([], [], color="gray", marker="o", fillstyle="none", linestyle="", label=label))
    if any(_all_lost(r) for r in rows):
        label = "cross at the top: lost, no error to show"
        handles.append(Line2D([], [], color="gray", marker="x", linestyle="", label=label))
    columns = max(1, min(len(handles), 3, int(figure.get_figwidth() // LEGEND_WIDTH)))
    figure.legend(handles=handles, loc="outside upper center", ncols=columns, frameon=False)


def _label(panel: Any, rows: Sequence[Measurement], unit: float) -> None:
    """Settings and losses beside the points, each in the first place that is free and inside its panel."""
    across = panel.get_xaxis_transform()
    anchors = [
        ((r.nanoseconds / unit, TOP), across) if _all_lost(r) else ((r.nanoseconds / unit, _height(r)), panel.transData)
        for r in rows
    ]
    pixels = [system.transform(point) for point, system in anchors]
    taken = [Bbox.from_extents(x - MARK, y - MARK, x + MARK, y + MARK) for x, y in pixels]
    for row, (point, system) in zip(rows, anchors, strict=True):
        note = " ".join(part for part in (row.setting, f"({row.lost} lost)" if row.lost else "") if part)
        if note:
            taken.append(_placed(panel, note, point, system, taken))


def _placed(panel: Any, note: str, point: tuple[float, float], system: Any, taken: Sequence[Any]) -> Any:
    """Draw one label where it hides least; returns the box that it fills."""
    label = panel.annotate(note, point, PLACES[0], xycoords=system, textcoords="offset points", fontsize=LABEL_SIZE)
    label.set_in_layout(False)
    frame, faults = panel.get_window_extent(), []

    def box_at(number: int) -> Any:
        label.set_position(PLACES[number])
        label.set_horizontalalignment("left" if PLACES[number][0] > 0 else "right")
        return label.get_window_extent()

    for number in range(len(PLACES)):
        box = box_at(number)
        is_inside = frame.x0 <= box.x0 and box.x1 <= frame.x1 and frame.y0 <= box.y0 and box.y1 <= frame.y1
        faults.append((not is_inside, sum(box.overlaps(other) for other in taken), number))
    return box_at(min(faults)[-1])
