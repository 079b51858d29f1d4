"""Inertias of links: checked, moved to the frames of joints, and added up where links are welded."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.validation import as_choice, finite_array
from ...mechanics.inertia import Inertia
from ...mechanics.principal_axes import principal

Array = NDArray[Any]
#: Whether inertias that no body can have are an error.
CHECKS = ("error", "keep")
#: The six numbers of a symmetric matrix.
UPPER = np.triu_indices(3)


def link_rows(masses: Array, centers: Array, tensors: Array) -> Array:
    """Rows (n, 10) of `Link`, of codegen/algorithms/trees/records.py.

    Parameters
    ----------
    masses : array (n,)
    centers : array (n, 3)
        Centers of mass, from the origin of each frame.
    tensors : array (n, 3, 3)
        About the centers of mass.
    """
    squares = (centers**2).sum(-1)[:, None, None] * np.eye(3) - centers[:, :, None] * centers[:, None, :]
    about_origin = tensors + masses[:, None, None] * squares
    return np.column_stack([masses, masses[:, None] * centers, about_origin[:, *UPPER]])


def moved(frames: Array, centers: Array, tensors: Array) -> tuple[Array, Array]:
    """Centers and tensors of frames (n, 4, 4) in the frame that those are in."""
    turns = frames[:, :3, :3]
    return (
        np.einsum("nij,nj->ni", turns, centers) + frames[:, :3, 3],
        turns @ tensors @ np.swapaxes(turns, -1, -2),
    )


def read_inertias(
    inertias: Any, centers: Any, tensors: Any, names: Sequence[str], impossible: str
) -> tuple[Array, Array, Array]:
    """Masses (n,), centers (n, 3) and tensors (n, 3, 3) of a user's arguments, checked; see `Chain.with_inertias`.

    Raises
    ------
    InputError, ShapeError
    """
    count = len(names)
    if isinstance(inertias, Sequence) and all(isinstance(x, Inertia) for x in inertias):
        if centers is not None or tensors is not None:
            raise InputError("inertias have their own centers and tensors.", remedy="Give masses, centers and tensors")
        if len(inertias) != count:
            raise InputError(f"{len(inertias)} inertias for {count} links: {', '.join(names)}.")
        masses = np.array([float(x.mass) for x in inertias])
        return masses, np.stack([x.center for x in inertias]), np.stack([x.tensor for x in inertias])
    if centers is None or tensors is None:
        raise InputError(
            "a link's inertia is its mass, its center of mass and its tensor about that.",
            remedy="Give masses (n,), centers (n, 3) and tensors (n, 3, 3), or a list of dynamics.Inertia",
        )
    masses = finite_array(inertias, "the masses", (count,))
    centers = finite_array(centers, "the centers", (count, 3))
    given = finite_array(tensors, "the tensors")
    if given.shape == (count, 3) and count != 3:
        given = given[:, :, None] * np.eye(3)
    given = finite_array(given, "the tensors", (count, 3, 3))
    for name, mass, tensor in zip(names, masses, given, strict=True):
        check_inertia(f"the link of {name}", mass, tensor, impossible)
    return masses, centers, given


def check_inertia(what: str, mass: float, tensor: Array, impossible: str = "error", where: str | None = None) -> None:
    """Refuse a mass and a tensor about the center that no body has. A link may be massless, a point or a rod.

    Raises
    ------
    InputError
    """
    remedy = "Mend it, or keep such inertias as they are with impossible='keep'"
    if as_choice(impossible, "impossible", CHECKS) == "keep":
        return
    if not mass >= 0:
        raise InputError(f"the mass of {what} is {mass:g}; a mass is positive, or zero.", where=where, remedy=remedy)
    if not tensor.any():
        return
    if mass == 0:
        raise InputError(f"{what} has moments of inertia, and no mass.", where=where, remedy=remedy)
    try:
        principal(tensor, thin=True)
    except InputError as error:
        raise InputError(f"the inertia of {what}: {error.what}", where=where, remedy=remedy) from None
