"""Names of surfaces on a page."""

from __future__ import annotations


def test_quotation_marks_in_the_names_of_a_page() -> None:
    from bladesmith.tracer.viewer.plotly_figure import _text

    assert _text("""a "b" <i>&'c'""") == """a "b" &lt;i&gt;&amp;'c'"""
