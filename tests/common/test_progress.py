"""The option ``progress=``: a bar, a function of one Progress, or nothing."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import bladesmith
from bladesmith.common import deprecation
from bladesmith.common.progress import open_progress
from bladesmith.errors import InputError


def told_by(option, total=4):
    with open_progress(option, "work", "items", total) as report:
        report(1, "the first")
        report(4)


def test_a_function_gets_one_frozen_record():
    told = []
    told_by(told.append)
    assert told == [bladesmith.Progress(1, 4, "items", "the first"), bladesmith.Progress(4, 4, "items")]
    with pytest.raises(AttributeError):
        told[0].done = 2


def test_old_functions_of_two_arguments_are_called_for_one_release(monkeypatch):
    monkeypatch.setattr(deprecation, "_warned", set())
    told = []
    with pytest.warns(FutureWarning, match=r"function of \(done, total\) is now a function of one bladesmith.Progress"):
        told_by(lambda done, total: told.append((done, total)))
    assert told == [(1, 4), (4, 4)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # no second warning, and none for what also takes one argument
        told_by(lambda done, total: None)
        told_by(lambda progress, seen=told: seen.append(progress))
        told_by(lambda *progress: told.append(progress[0]))
    assert told[-1] == bladesmith.Progress(4, 4, "items")


def test_a_bar_is_on_standard_error_and_nothing_without(capsys, monkeypatch):
    monkeypatch.setattr("bladesmith.codegen.progress.PATIENCE", 0)
    for option in (False, None):
        told_by(option)
    assert capsys.readouterr() == ("", "")
    told_by(True)
    out, err = capsys.readouterr()
    assert out == "" and "work" in err


@pytest.mark.parametrize(
    ("option", "message"),
    [
        (3, "progress is 3; it is True, False"),
        ("yes", "progress is 'yes'"),
        (lambda a, b, c: None, r"takes \(a, b, c\)"),
    ],
)
def test_other_options_are_refused(option, message):
    with pytest.raises(InputError, match=message):
        told_by(option)


def test_what_a_function_returns_is_ignored():
    told_by(lambda progress: np.zeros(3))


def test_classes_are_refused():
    with pytest.raises(InputError, match="progress is <class 'dict'>"):
        told_by(dict)
