"""`bladesmith report`: what it says and keeps, its plots; studies of users' files, that of the docs among them."""

import json
import re

import pytest

from bladesmith import benchmarks
from bladesmith.benchmarks.registry import STUDIES
from bladesmith.cli import demo, main
from bladesmith.codegen.targets.templates import template_text
from bladesmith.errors import InputError

from ..support.checkout import CHECKOUT

SMALL = """import numpy as np
from bladesmith.benchmarks import Case, Method, Study

half = lambda x, setting: x.astype(setting) / 2
STUDY = Study(
    "NAME", "Halves", (Method("half", half, "precision", ("float32", "float64")),),
    (Case("numbers", lambda rng, count: rng.normal(size=count)),),
    lambda x: x / 2, lambda answer, truth, x: np.abs(answer - truth), "",
)
"""


def written(path, text):
    path.write_text(text)
    return str(path)


@pytest.mark.slow
def test_the_study_of_the_docs(tmp_path, capsys):
    page = (CHECKOUT / "docs" / "accuracy" / "studies.md").read_text(encoding="utf-8")
    own = written(tmp_path / "mine.py", re.findall(r"```python\n(.*?)```", page, re.DOTALL)[0])
    published = tmp_path / "page.md"
    options = ["--quick", "--study", own, "-o", str(tmp_path / "out"), "--publish", str(published)]
    assert main.run(["report", *options]) == 0
    first, second, last = capsys.readouterr().out.splitlines()
    assert first == "1 study" and second.startswith("mine: 8 measurements") and last.startswith("wrote ")
    assert (tmp_path / "out" / "mine.png").exists()
    ((name, found),) = json.loads((tmp_path / "out" / "report.json").read_text())["studies"].items()
    assert name == "mine"
    page = published.read_text(encoding="utf-8")
    assert "`bladesmith report --quick --publish`" in page and "mine: 8 measurements" in page
    assert page.count("\n| near the origin | ") == 4 and "| differences | float64 |" in page
    errors = {(r["case"], r["method"], r["setting"]): r["max_error"] for r in found["rows"]}
    assert errors["far apart", "inner_product", "float32"] > 100 * errors["far apart", "inner_product", "float64"]


@pytest.mark.slow
def test_own_studies_beside_others(tmp_path, capsys):
    own = written(tmp_path / "halves.py", SMALL.replace("NAME", "halves"))
    assert main.run(["report", "--quick", "--study", own, "--study", "distance", "-o", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert out.startswith("2 studies, about 5 s on two cores, and yours\nhalves: 2 measurements")
    assert "1 left, about 5 s\ndistance: 18 measurements" in out


def test_a_changed_file_is_read_again(tmp_path):
    path = tmp_path / "own.py"
    first = benchmarks.load_study(written(path, SMALL.replace("NAME", "one")))
    assert benchmarks.load_study(str(path)) is first
    assert benchmarks.load_study(written(path, "\n" + SMALL.replace("NAME", "two"))).name == "two"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (None, "own.py: cannot be read: No such file"),
        ("x = 1\ny = (", "own.py, line 2: is not Python"),
        ("import numpy\n\nx = numpy.nothing", "own.py, line 3: cannot be run: AttributeError"),
        ("import bladesmith as bs\nbs.algebra(-1)", "SignatureError: p is -1"),
        ("x = 1", "own.py: has no STUDY. Write STUDY = "),
        ("STUDY = [1, 2]", r"own.py: has a STUDY that is \[1, 2\]"),
    ],
)
def test_files_without_a_study(text, says, tmp_path, capsys):
    path = tmp_path / "own.py"
    if text is not None:
        path.write_text(text)
    assert main.run(["report", "--study", str(path), "-o", str(tmp_path / "out")]) == 2
    assert re.search(says, capsys.readouterr().err)
    assert not (tmp_path / "out").exists()


def test_where_a_page_cannot_be_published_nothing_is_measured(tmp_path, capsys):
    page = tmp_path / "nowhere" / "page.md"
    assert main.run(["report", "--study", "distance", "-o", str(tmp_path / "out"), "--publish", str(page)]) == 2
    assert "there is no folder" in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_the_page_of_the_site_is_small_and_has_the_present_chooser():
    page = CHECKOUT / "docs" / "accuracy" / "report.md"
    text = page.read_text(encoding="utf-8")
    assert page.stat().st_size < 600_000 and template_text("chooser.js") in text
    form = template_text("chooser.html.j2").partition('<div id="drawing"')[0]
    assert form in text and "<code>rtol=</code>" in form
    (measured,) = re.findall(r'id="measured">(.*)</script>', text)
    studies = json.loads(measured)
    assert studies.keys() <= STUDIES.keys() and all(study["title"] in text for study in studies.values())
    assert re.search(r"^\| date \| \d{4}-\d\d-\d\d \|$", text, re.MULTILINE)


def test_two_studies_of_one_name(tmp_path):
    paths = [written(tmp_path / f"{name}.py", SMALL.replace("NAME", "halves")) for name in "ab"]
    assert main.run(["report", *(f"--study={path}" for path in paths), "-o", str(tmp_path)]) == 2
    with pytest.raises(InputError, match=r"no study 'distanc' .*did you mean 'distance'.*mine.py"):
        benchmarks.load_study("distanc")


def interrupt(*_):
    raise KeyboardInterrupt


def small_study(name, run=lambda inputs, setting: inputs):
    import numpy as np

    from bladesmith.benchmarks.harness.study import Case, Method, Study

    case = Case("numbers", lambda rng, count: rng.normal(size=count))
    return Study(name, name, (Method("itself", run),), (case,), lambda x: x, lambda a, b, _: np.abs(a - b), "units")


@pytest.mark.slow
def test_a_report_says_first_how_long_it_takes_and_keeps_each_study(tmp_path, capsys, monkeypatch):
    from bladesmith.benchmarks import registry
    from bladesmith.benchmarks.harness import write

    studies = {"one": small_study("one"), "two": small_study("two", interrupt)}
    entries = {"one": registry.Entry("one", 40, 4), "two": registry.Entry("two", 200, 20)}
    monkeypatch.setattr(write, "load_study", studies.__getitem__)
    monkeypatch.setattr(registry, "STUDIES", entries)
    assert main.run(["report", "-o", str(tmp_path)]) == main.INTERRUPTED
    said = capsys.readouterr()
    first, second = said.out.splitlines()
    assert first == "2 studies, about 4 min on two cores"
    assert second.startswith("one: 1 measurements") and second.endswith("1 left, about 3 min")
    assert f"1 of 2 studies are in {tmp_path / 'index.html'}" in said.err
    assert list(json.loads((tmp_path / "report.json").read_text())["studies"]) == ["one"]
    assert (tmp_path / "one.png").exists() and 'src="one.png"' in (tmp_path / "index.html").read_text()


def test_an_unknown_study_is_refused_before_any_is_run(tmp_path, capsys):
    assert main.run(["report", "-o", str(tmp_path / "r"), "--study", "products", "--study", "distanc"]) == 2
    assert "distance" in capsys.readouterr().err and not (tmp_path / "r").exists()


@pytest.mark.slow
def test_a_report_measures_each_study_once_and_not_where_nothing_can_be_written(tmp_path, capsys, monkeypatch):
    from bladesmith.benchmarks import registry
    from bladesmith.benchmarks.harness import write

    measured = []
    studies = {"one": small_study("one", lambda x, setting: measured.append(1) or x)}
    monkeypatch.setattr(write, "load_study", studies.__getitem__)
    monkeypatch.setattr(registry, "load_study", studies.__getitem__)
    monkeypatch.setattr(registry, "STUDIES", {"one": registry.Entry("one", 40, 4)})
    (tmp_path / "file").write_text("")
    assert main.run(["report", "-o", str(tmp_path / "file" / "r"), "--study", "one"]) == 2
    assert not measured and f"{tmp_path / 'file' / 'r'}: cannot be written: Not a directory" in capsys.readouterr().err
    assert main.run(["report", "-o", str(tmp_path / "r"), "--study", "one", "--study", "one"]) == 0
    assert measured and capsys.readouterr().out.startswith("1 study, about ")


def test_every_study_says_how_long_it_takes():
    from bladesmith.benchmarks.harness.runner import duration_text
    from bladesmith.benchmarks.registry import STUDIES, expected_seconds

    assert set(demo.parts.DEMO_STUDIES) <= set(STUDIES)
    assert all(0 < entry.quick_seconds <= entry.seconds for entry in STUDIES.values())
    assert expected_seconds(demo.parts.DEMO_STUDIES, quick=True) < 45
    assert [duration_text(s) for s in (1, 42, 99, 100, 1790)] == ["5 s", "40 s", "100 s", "2 min", "30 min"]


def test_plots_tell_errors_from_losses_and_keep_labels_apart(tmp_path):
    from bladesmith.benchmarks.harness import plot
    from bladesmith.benchmarks.harness.runner import Measurement
    from bladesmith.benchmarks.harness.study import Case, Study

    def row(setting, error, lost, time):
        return Measurement("m", "n", setting, "c", "ordinary", 10, error, "", lost, "", time, "")

    rows = [row("8", 1e-2, 9, 400.0), row("16", 9e-3, 1, 410.0), row("32", 1e-9, 0, 420.0), row("64", 0.0, 3, 900.0)]
    study = Study("s", "S", (), (Case("c", lambda rng, n: None),), lambda x: x, lambda a, b, c: a, "units")
    figure = plot.draw(study, rows)
    panel = figure.axes[0]
    crosses = [line for line in panel.lines if line.get_marker() == "x"]
    assert [line.get_ydata()[0] for line in crosses] == [plot.LOST_HEIGHT]
    boxes = [text.get_window_extent() for text in panel.texts]
    frame = panel.get_window_extent()
    assert [text.get_text() for text in panel.texts] == ["8 (9 lost)", "16 (1 lost)", "32", "64 (3 lost)"]
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    assert all(frame.x0 <= b.x0 and b.x1 <= frame.x1 and frame.y0 <= b.y0 and b.y1 <= frame.y1 for b in boxes)
    assert any("lost, no error" in text.get_text() for text in figure.legends[0].get_texts())
