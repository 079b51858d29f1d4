"""Parameters of the objects of a model, as rows of numbers: validation, conversion from and to multivectors, motion.

A row contains the arguments of the constructor of its kind, in that order. Errors name kind, item and remedy.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import BladesmithError, InputError
from ...codegen.programs.registration.registration import matched_as
from ...common.validation import as_instance, check_shape, real_array
from ...core.multivector import Multivector
from ...core.registry import stock_algebra
from ...objects.arguments import as_objects, concatenate_objects
from ...status import Status

Rows = NDArray[np.float64]
#: Names and lengths of the parameters, by kind; the order of all models.
FIELDS: dict[str, tuple[tuple[str, int], ...]] = {
    "point": (("xyz", 3),),
    "point_pair": (("a", 3), ("b", 3)),
    "line": (("point", 3), ("direction", 3)),
    "segment": (("a", 3), ("b", 3)),
    "circle": (("center", 3), ("normal", 3), ("radius", 1)),
    "plane": (("normal", 3), ("offset", 1)),
    "sphere": (("center", 3), ("radius", 1)),
}
KINDS = tuple(FIELDS)
#: Names of lists of objects in models and files.
PLURALS = {kind: f"{kind}s" for kind in KINDS}
#: Number of parameters of an object.
SIZES = {kind: sum(size for _, size in fields) for kind, fields in FIELDS.items()}
#: Shapes of parameters in arrays, for kinds whose parameters are several vectors.
SHAPES = {"point_pair": (2, 3), "line": (2, 3), "segment": (2, 3)}
#: Grades of objects that have multivectors of their own.
GRADES = {"point": 1, "point_pair": 2, "line": 3, "circle": 3, "plane": 4, "sphere": 4}
#: Parameters that are positions.
POSITIONS = ("xyz", "a", "b", "point", "center")
#: Parameters that are directions.
DIRECTIONS = ("direction", "normal")
#: Largest coordinate and length: squares of larger ones would overflow.
LARGEST = 1e90
#: Smallest radius: squares of smaller ones would vanish.
SMALLEST = 1e-90
#: From this many lines or segments on it is checked that they are not given as the other ones.
MIN_MISTAKEN = 6
#: Directions that are as near to the positions of the points of their lines, by the mean cosine, are end points: of
#: six random directions one in 100 000.
MISTAKEN_COSINE = 0.85
#: Tolerance of lengths of 1, and of vectors that are parallel.
MISTAKEN_TOLERANCE = 1e-6
#: A direction whose length differs from 1 by less than this stays as it is: then saving and loading changes nothing.
UNIT_TOLERANCE = 4 * float(np.finfo(np.float64).eps)


def columns(kind: str) -> dict[str, slice]:
    """Slice of each parameter in a row."""
    columns, start = {}, 0
    for name, size in FIELDS[kind]:
        columns[name] = slice(start, start + size)
        start += size
    return columns


# -- from users --------------------------------------------------------------------------------------------


def validated_rows(objects: Any, kind: str) -> Rows:
    """Rows (n, k) of multivectors, of a list of them, or of an array of parameters.

    Raises
    ------
    InputError
        Naming list, item and remedy.
    """
    name = PLURALS[kind]
    given_as_objects = _holds_objects(objects)
    if given_as_objects and kind not in GRADES:
        remedy = "Give their end points, or lines" if kind == "segment" else None
        raise InputError(f"{name} are no multivectors; {_expected_array(kind)} is needed.", remedy=remedy)
    rows = _from_objects(objects, kind) if given_as_objects else _from_array(objects, kind)
    for field, place in columns(kind).items():
        bad = ~np.isfinite(rows[:, place]).all(1)
        _refuse(bad, rows[:, place], name, field, "numbers are finite")
        if field in POSITIONS or field == "radius":
            far = (np.abs(rows[:, place]) > LARGEST).any(1)
            _refuse(far, rows[:, place], name, field, f"lengths go to {LARGEST:g}", "Choose another unit of length")
        if field in DIRECTIONS:
            zero = ~(rows[:, place] != 0).any(1)
            _refuse(zero, rows[:, place], name, field, "a direction is not zero")
        if field == "radius":
            bad = ~(rows[:, place] >= SMALLEST).all(1)
            _refuse(bad, rows[:, place], name, field, "a radius is positive",
                    "Give its absolute value, or a point for a radius of zero")  # fmt: skip
    if kind in ("point_pair", "segment"):
        meet = (np.abs(rows[:, :3] - rows[:, 3:]) < SMALLEST).all(1)
        _refuse(meet, rows[:, 3:], name, "b", f"a {_kind_text(kind)} has two end points",
                "Give a point if that is meant")  # fmt: skip
    if not given_as_objects:
        _refuse_mistaken(rows, kind)
    return _with_unit_directions(rows, kind)


def _refuse(bad: Any, values: Rows, name: str, field: str, rule: str, remedy: str | None = None) -> None:
    """Raise an error for the first bad item, with its path."""
    if bad.any():
        i = int(bad.argmax())
        value = values[i].tolist() if values.shape[1] > 1 else float(values[i, 0])
        raise InputError(f"{name}[{i}].{field} is {value}; {rule}.", remedy=remedy)


def _refuse_mistaken(rows: Rows, kind: str) -> None:
    """Raise for lines that are given by their end points, and for segments given by points and directions.

    Directions of length 1 are never taken for end points.
    """
    if kind not in ("line", "segment") or len(rows) < MIN_MISTAKEN:
        return
    size = float(np.abs(rows).max()) or 1.0
    first, second = rows[:, :3] / size, rows[:, 3:] / size
    first_unit, second_unit = (np.abs(np.linalg.norm(v, axis=1) - 1 / size) <= MISTAKEN_TOLERANCE / size
                               for v in (first, second))  # fmt: skip
    if kind == "segment" and second_unit.all() and not first_unit.any():
        raise InputError("segments have second vectors of length 1 throughout, as directions have; the second vector "
                         "of a segment is its other end.",
                         remedy="Give lines if they are directions; else change the ends round")  # fmt: skip
    if kind == "line" and not second_unit.any():
        lengths = np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)
        counting = np.linalg.norm(np.cross(first, second), axis=1) > MISTAKEN_TOLERANCE * lengths  # not radial
        cosines = (first * second).sum(1)[counting] / lengths[counting]
        if len(cosines) >= MIN_MISTAKEN and cosines.mean() > MISTAKEN_COSINE:
            raise InputError("lines have directions that lie beside their points, as the other ends of segments do; a "
                             "line is a point and a direction.",
                             remedy="Give segments if they are end points; else directions of length 1")  # fmt: skip


def _holds_objects(objects: Any) -> bool:
    return isinstance(objects, Multivector) or (
        isinstance(objects, list | tuple) and any(isinstance(x, Multivector) for x in objects)
    )


def _from_array(objects: Any, kind: str) -> Rows:
    name, shape = PLURALS[kind], SHAPES.get(kind, (SIZES[kind],))
    try:
        array = real_array(objects, name).astype(np.float64)
    except InputError as error:
        raise InputError(error.what, remedy=f"Give {_expected_array(kind)}, or multivectors") from None
    if array.size == 0 and array.ndim <= 1:
        return np.empty((0, SIZES[kind]))
    remedy = f"Give {_expected_array(kind)}" + (
        f"; a single {_kind_text(kind)} in a list" if array.ndim == len(shape) else ""
    )
    check_shape(array, name, ("n", *shape), InputError, remedy)
    return array.reshape(len(array), SIZES[kind])


def _from_objects(objects: Any, kind: str) -> Rows:
    """Parameters of multivectors; inward spheres are converted to outward ones."""
    algebra: Any = stock_algebra("cga3d")
    x = _objects(objects, kind)
    if x.ndim:
        check_shape(x, PLURALS[kind], ("n",), InputError, remedy="Use .reshape(-1)")
    x = x.reshape(-1).astype(np.float64) if x.dtype != np.float64 else x.reshape(-1)
    if not len(x):
        return np.empty((0, SIZES[kind]))
    _refuse_others(x, kind)
    unit = x if x.kind.name == kind and x.kind.constraints else x.as_kind(algebra.kind(kind).layout, check=False)
    if unit.kind.is_layout:
        unit = unit.normalized(kind)
    values = algebra.parameters(unit)
    return np.concatenate([np.asarray(v, float).reshape(len(x), -1) for v in values], 1)


def _objects(objects: Any, kind: str) -> Multivector:
    """Multivectors of the kind's grade; of their items only the unit size is checked."""
    name, algebra, grade = PLURALS[kind], stock_algebra("cga3d"), GRADES[kind]
    entries = objects if isinstance(objects, list | tuple) else [objects]
    for i, x in enumerate(entries):
        where = f"{name}[{i}] is" if isinstance(objects, list | tuple) else f"{name} are"
        as_instance(x, f"{name}[{i}]", Multivector, "a multivector", remedy="Do not mix them with parameters")
        if x.algebra is not algebra:
            raise InputError(f"{where} of {x.algebra.name}; a model holds objects of {algebra.name}.",
                             remedy="Convert them, or give parameters")  # fmt: skip
        if x.grades != (grade,):
            raise InputError(f"{where} a {x.kind.name} of grades {x.grades}; {_kind_text(kind)}s have grade {grade}.",
                             remedy=_list_remedy(x.kind.name))  # fmt: skip
    try:
        values = concatenate_objects(objects, name, (grade,)) if isinstance(objects, list | tuple) else objects
        as_objects(values, name, (grade,))
    except BladesmithError as error:  # an object at infinity, of blades that no kind has
        raise InputError(error.what, remedy=f"Give finite {_kind_text(kind)}s") from None
    return values


def _refuse_others(x: Multivector, kind: str) -> None:
    """Raise an error for the first item that is not a unit object of this kind."""
    algebra: Any = stock_algebra("cga3d")
    name = PLURALS[kind]
    if x._status is not None:
        bad = (x._status != Status.OK) & (x._status != Status.NOT_UNIQUE)
        if bad.any():
            i = int(bad.argmax())
            raise InputError(f"{name}[{i}] has no value: its status is {Status(int(x._status[i])).name}.",
                             remedy="Leave it out, or look at what made it")  # fmt: skip
    names = algebra.classify(x)
    wrong = names != _kind_text(kind)
    if wrong.any():
        i = int(wrong.argmax())
        what = {"invalid": "not finite", "zero": "zero", "not a blade": "not a blade"}.get(
            names[i], _with_article(names[i])
        )
        remedy = _list_remedy(names[i].replace(" ", "_")) or "See bladesmith.cga3d.classify"
        if names[i] == "not a blade":
            remedy = "bladesmith.objects.project_to_blade gives the object next to it"
        raise InputError(f"{name}[{i}] is {what}; a {_kind_text(kind)} is needed.", remedy=remedy)
    loose = as_objects(x, name, (GRADES[kind],))._status
    if loose is not None and (loose == Status.INVALID).any():
        i = int((loose == Status.INVALID).argmax())
        raise InputError(f"{name}[{i}] is not a unit {_kind_text(kind)}.", remedy=f"Use .normalized({kind!r})")


def _list_remedy(kind: str) -> str | None:
    """Remedy that names the list of another kind of object."""
    return f"Give it in {PLURALS[kind]}" if kind in PLURALS else None


def _with_article(name: str) -> str:
    return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"


def _kind_text(kind: str) -> str:
    return kind.replace("_", " ")


def _expected_array(kind: str) -> str:
    """Description of the array of parameters of a kind."""
    fields = ", ".join(name for name, _ in FIELDS[kind])
    shape = ", ".join(str(s) for s in SHAPES.get(kind, (SIZES[kind],)))
    return f"an array (n, {shape}) of {fields}"


def _with_unit_directions(rows: Rows, kind: str) -> Rows:
    """Rows with directions of length 1; the offset of a plane is scaled with its normal."""
    result = rows.copy()
    for field, place in columns(kind).items():
        if field in DIRECTIONS and len(result):
            exponent = np.frexp(np.abs(result[:, place]).max(1))[1]  # exact, and no square over- or underflows
            scaled = np.ldexp(result[:, place], -exponent[:, None])
            length = np.linalg.norm(scaled, axis=1)
            loose = np.abs(np.linalg.norm(np.clip(result[:, place], -2, 2), axis=1) - 1) > UNIT_TOLERANCE
            result[loose, place] = scaled[loose] / length[loose, None]
            if kind == "plane":
                with np.errstate(over="ignore"):
                    result[loose, 3] = np.ldexp(result[loose, 3] / length[loose], -exponent[loose])
                far = ~(np.abs(result[:, 3:]) <= LARGEST)[:, 0]
                _refuse(far, result[:, 3:], PLURALS[kind], "offset", "over the length of its normal it is too great",
                        "Choose another unit of length")  # fmt: skip
    result.setflags(write=False)
    return result


# -- to objects --------------------------------------------------------------------------------------------


def build_objects(rows: Rows, kind: str) -> Multivector:
    """Unit objects (n,) of checked rows; of segments the lines through their ends.

    Raises
    ------
    InputError
        If the coefficients of an object are not floating-point numbers.
    """
    algebra: Any = stock_algebra("cga3d")
    parts = [np.ascontiguousarray(rows[:, place]) for place in columns(kind).values()]
    fields = [part[:, 0] if part.shape[1] == 1 else part for part in parts]
    if kind == "segment":  # the line from one end to the other
        fields[1] = fields[1] - fields[0]
    x: Multivector = getattr(algebra, matched_as(kind))(*fields)
    bad = ~(np.abs(rows) <= LARGEST).all(1)
    if "radius" in columns(kind):
        bad |= rows[:, -1] < SMALLEST
    if x._status is not None:
        bad |= x._status != Status.OK
    if bad.any():
        i = int(bad.argmax())
        raise InputError(f"{PLURALS[kind]}[{i}] is beyond floating-point numbers: {rows[i].tolist()}.",
                         remedy="Choose another unit of length, or an origin nearby")  # fmt: skip
    return x


def rows_in_frame(rows: Rows, kind: str, center: Rows, unit: float) -> Rows:
    """Rows of the objects in a frame at a center with another unit of length: (x - center) / unit."""
    shifted = transform_rows(rows, kind, 1.0, np.eye(3), -center)
    return transform_rows(shifted, kind, 1 / unit, np.eye(3), np.zeros(3))


def transform_rows(rows: Rows, kind: str, scale: float, rotation: Rows, translation: Rows) -> Rows:
    """Rows of the objects under x -> scale rotation x + translation."""
    result, place = rows.copy(), columns(kind)
    with np.errstate(all="ignore"):  # build_objects raises for results that are not finite
        for field in place:
            if field in POSITIONS:
                result[:, place[field]] = scale * rows[:, place[field]] @ rotation.T + translation
            elif field in DIRECTIONS:
                result[:, place[field]] = rows[:, place[field]] @ rotation.T
            else:
                result[:, place[field]] = scale * rows[:, place[field]]
        if kind == "plane":
            result[:, 3] += result[:, :3] @ translation
        return _with_unit_directions(result, kind)  # rounding would accumulate over many motions


def row_jacobian(kind: str, scale: float, rotation: Rows, translation: Rows) -> Rows:
    """Derivative (k, k) of `transform_rows` by a row: a plane's normal carries its offset along."""
    size, place = SIZES[kind], columns(kind)
    jacobian = np.zeros((size, size))
    for field, part in place.items():
        if field in (*POSITIONS, *DIRECTIONS):
            jacobian[part, part] = rotation * (scale if field in POSITIONS else 1.0)
        else:
            jacobian[part, part] = scale
    if kind == "plane":
        jacobian[3, :3] = translation @ rotation
    return jacobian
