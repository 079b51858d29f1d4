"""Pictures of registrations."""

from __future__ import annotations

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import registration
from bladesmith.errors import InputError
from bladesmith.registration.plotting.glyphs import ModelSketch

from ...support.registration import POSE, full_disk, mixed, noisy_lines, tables

CGA = bs.cga3d


def artists(ax):
    """Segments, and marks, by colour."""
    from matplotlib.colors import to_hex
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Path3DCollection

    found = {}
    for artist in ax.collections:
        if isinstance(artist, Line3DCollection):
            for segment, color in zip(
                artist._segments3d, np.resize(artist.get_colors(), (len(artist._segments3d), 4)), strict=True
            ):
                found.setdefault(to_hex(color), []).append(np.asarray(segment))
        elif isinstance(artist, Path3DCollection):
            found.setdefault(to_hex(artist.get_facecolors()[0]), []).append(np.stack(artist._offsets3d, 1))
    return found


def on_line(segment, line):
    away = segment - line[:3]
    return np.linalg.norm(away - (away @ line[3:])[:, None] * line[3:], axis=1).max()


def test_pictures_show_every_line_where_it_is():
    query, reference = noisy_lines()
    result = registration.register(query, reference)
    figure = registration.picture(result, query, reference)
    before, after = figure.axes
    red, black, blue, green = (registration.picture.__globals__[n] for n in ("RED", "BLACK", "BLUE", "GREEN"))
    found = artists(before)
    for color, model in ((red, query), (black, reference)):
        assert max(map(on_line, found[color], model.parameters["line"])) < 1e-9
    found, rows = artists(after), reference.parameters["line"]
    matched = np.zeros(len(reference), bool)
    matched[result.matches["lines"][result.inliers["lines"]]] = True
    assert 0 < matched.sum() < len(matched)
    assert len(found[green]) == matched.sum() and len(found[black]) == (~matched).sum()
    assert max(map(on_line, found[green], rows[matched])) < 1e-9
    assert max(map(on_line, found[black], rows[~matched])) < 1e-9
    moved = query.transformed(result.motor).parameters["line"]
    assert max(map(on_line, found[blue], moved)) < 1e-9
    for segment, match in zip(
        found[blue], result.matches["lines"], strict=True
    ):  # matched lines are drawn side by side
        if match >= 0:
            other = ModelSketch(reference).segments[match]
            assert np.abs(np.linalg.norm(segment - other, axis=1)).max() < 0.2
    assert [t.get_text() for t in after.get_legend().get_texts()] == [
        "reference, without a match (12)", "reference, matched (28)", "query, moved (40, 12 without a match)"
    ]  # fmt: skip


def test_pictures_have_equal_axes_and_nothing_outside():
    query, reference = noisy_lines()
    for ax in registration.picture(registration.register(query, reference), query, reference).axes:
        limits = np.array([ax.get_xlim3d(), ax.get_ylim3d(), ax.get_zlim3d()])
        sides = np.diff(limits)[:, 0]
        np.testing.assert_allclose(ax._box_aspect / ax._box_aspect[0], sides / sides[0], rtol=1e-6)
        for segments in artists(ax).values():
            for segment in segments:
                assert (segment > limits[:, 0]).all() and (segment < limits[:, 1]).all()


def test_lines_end_where_others_pass_however_the_model_is_turned():
    """The table's legs are drawn from the rails to the top, and no further; so are those of the moved table."""
    query, table = tables()
    legs = np.abs(table.parameters["line"][:, 5]) > 0.9
    ends = np.sort(ModelSketch(table).segments[legs][:, :, 2], axis=1)
    assert (np.abs(ends - (0.15, 0.75)) < 0.1).all()
    lengths = [
        np.sort(np.linalg.norm(np.diff(ModelSketch(m).segments, axis=1), axis=2).ravel()) for m in (query, table)
    ]
    np.testing.assert_allclose(*lengths, rtol=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("n", [2, 12])
def test_pictures_of_all_kinds(n, tmp_path):
    from PIL import Image

    reference = mixed(n)
    query = reference.transformed(~POSE)
    result = registration.register(query, reference)
    for suffix in ("png", "svg"):
        registration.picture(result, query, reference, tmp_path / f"p.{suffix}", show="after", title="Mixed")
    with Image.open(tmp_path / "p.png") as picture:
        assert picture.size == (800, 600)
        colors = np.asarray(picture.convert("RGB")).reshape(-1, 3)
        assert (np.ptp(colors, axis=1) > 60).mean() > 0.02  # something green and blue is there
    assert "Mixed" in (tmp_path / "p.svg").read_text() or "<path" in (tmp_path / "p.svg").read_text()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["p.png", "p.svg"]


def test_a_query_far_away_is_drawn_nearer_and_that_is_told():
    query, reference = noisy_lines()
    far = query.transformed(CGA.translator((1e4, 0, 0)))
    ax = registration.picture(registration.register(far, reference), far, reference, show="before").axes[0]
    assert "away, drawn nearer" in ax.get_legend().get_texts()[1].get_text()
    assert np.ptp(ax.get_xlim3d()) < 100


def test_what_has_no_picture_is_told(tmp_path, monkeypatch):
    query, reference = tables()
    result = registration.register(query, reference)
    other = registration.Model(lines=[[(0, 0, 0), (1, 0, 0)]])
    for arguments, message in [
        ((result, query, reference, None, "later"), "show is 'later'"),
        ((result, other, reference), "lines of the models are not those that were registered"),
        ((result, query, other), "lines of the models are not those that were registered"),
        ((None, query, reference), "the result is None"),
        ((result, query, {}), "the reference is {}"),
        ((result, query, reference, tmp_path / "p.xyz"), "'xyz' is not a format of pictures.*png"),
        ((result, query, reference, tmp_path / "p"), "has no suffix"),
    ]:
        with pytest.raises(InputError, match=message):
            registration.picture(*arguments[:4], **({"show": arguments[4]} if len(arguments) > 4 else {}))
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", full_disk)
    with pytest.raises(InputError, match="p.png: cannot be written: No space left"):
        registration.picture(result, query, reference, tmp_path / "p.png")
    assert not list(tmp_path.iterdir())


def test_models_alone_are_drawn_with_colours_of_their_own():
    _, table = tables()
    colors = ["#2f9461"] * 11 + ["#22303c"] * 11
    ax = registration.draw_model(
        table, color={"lines": colors}, label="table", motor=CGA.translator((5, 0, 0)).as_kind("motor")
    )
    found = artists(ax)
    assert {c: len(s) for c, s in found.items()} == {"#2f9461": 11, "#22303c": 11}
    assert min(s[:, 0].min() for s in found["#2f9461"]) > 4


def test_an_empty_model_is_drawn_as_nothing():
    pytest.importorskip("matplotlib")
    ax = registration.draw_model(registration.Model())
    assert not ax.collections and not ax.lines
    with pytest.raises(InputError, match="the model is None"):
        registration.draw_model(None)
