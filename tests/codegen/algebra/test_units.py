"""unit(..) of the language of specs: members of quadrics in any signature, and what has no unit."""

import numpy as np
import pytest

from bladesmith.codegen.algebra.kind_checks import check_kind, member_rank
from bladesmith.codegen.algebra.loader import algebra_from_data
from bladesmith.codegen.algebra.members import NumericSource, RationalSource, SampleSource, sample
from bladesmith.codegen.errors import SpecError
from bladesmith.codegen.rings.protocol import SampleRing

METRIC = [["0", "0", 1], ["1", "1", 1], ["2", "2", -1], ["3", "3", -1], ["no", "ni", -1], ["4", "4", 2]]


def kind(member, square, blades=None):
    own = {"blades": blades} if blades else {"grades": [1]}
    data = {
        "name": "mixed",
        "vectors": ["0", "1", "2", "3", "no", "ni", "4", "5"],
        "metric": METRIC,
        "kinds": {"own": {**own, "constraints": [f"x * x - ({square})"], "member": member}},
    }
    return algebra_from_data(data).kind("own")


@pytest.mark.parametrize(
    ("member", "square", "blades"),
    [
        ("unit(e0, e1, e2, e3)", 1, ["e0", "e1", "e2", "e3"]),
        ("unit(e2, e0, e1, e3)", -1, ["e0", "e1", "e2", "e3"]),
        ("unit(e2, e3)", -1, ["e2", "e3"]),
        ("unit(e0, no, ni)", 1, ["e0", "no", "ni"]),  # a pair of null vectors
        ("unit(e3, no, ni, e1)", -1, ["e3", "no", "ni", "e1"]),
        ("unit(e0, e4, e2)", 1, ["e0", "e4", "e2"]),  # of square 2
        ("unit(e0, e2, e1, e5)", 1, ["e0", "e1", "e2", "e5"]),  # of square 0
        ("unit(e01, e02, e12)", -1, ["e01", "e02", "e12"]),
        ("unit((3 * e0 + 4 * e1) / 5, (4 * e0 - 3 * e1) / 5, e2)", 1, ["e0", "e1", "e2"]),
    ],
)
def test_units_have_the_square_of_the_first(member, square, blades):
    own = kind(member, square, blades)
    check_kind(own)  # exact, and as general as the constraint allows
    assert member_rank(own) == own.size - 1
    exact = sample(own, RationalSource(2))
    assert (exact * exact).terms == {0: square}
    x = sample(own, NumericSource(200, 3))
    rows = np.stack(own.values(x), -1)
    error = np.abs((x * x).terms[0] - square)
    assert (error <= 1e-14 * (1 + (rows**2).sum(-1))).all() and (np.ptp(rows, axis=0) > 0.1).all()


@pytest.mark.parametrize(
    ("member", "says"),
    [
        ("unit()", "has no arguments. Name the vectors"),
        ("unit(no, ni)", "a square other than 1 and -1. Begin with one that has"),
        ("unit(e5, e0)", "a square other than 1 and -1"),
        ("unit(e4, e0)", "a square other than 1 and -1"),
        ("unit(e0, e0 + e2)", "is not orthogonal to the others. Begin with one that is"),
        ("unit(e01, e23)", "squares of sums of the arguments of unit(..) are no numbers. Give it vectors"),
        ("unit(e0, e12)", "squares of sums"),
    ],
)
def test_what_has_no_unit_is_refused_on_every_ring(member, says):
    own = kind(member, 1)
    for source in (SampleSource(SampleRing(4), 1), RationalSource(1), NumericSource(5, 1)):
        with pytest.raises(SpecError) as caught:
            sample(own, source)
        assert says in str(caught.value) and "member of mixed.own" in str(caught.value)
