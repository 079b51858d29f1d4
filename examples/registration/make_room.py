"""Makes room.obj and room_scan.ply: the edges of a room with furniture, and what a detector saw of them.

    python examples/registration/make_room.py [--seed 2] [--noise 0.01] [--wrong 0.4] [--folder .]

Edges are segments: elements `l` of OBJ, and `edge` of PLY. In the scan they are cut, in another order, with ends that
are off; some were not seen, and 40 % are of what does not stand in the drawing. It is turned and moved anyhow.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from bladesmith import cga3d, registration

HERE = Path(__file__).resolve().parent
#: Boxes by their least and greatest corners, in metres: the room, a table on four legs, a cupboard with two boards, a
#: door, a window, and a crate that stands askew.
BOXES = [
    ((0, 0, 0), (5, 4, 2.5)), ((1.5, 1.2, 0.72), (3.1, 2.0, 0.75)),
    *(((x, y, 0), (x + 0.05, y + 0.05, 0.72)) for x in (1.55, 3.0) for y in (1.25, 1.9)),
    ((0, 3.4, 0), (1.2, 4, 2)), ((0, 3.4, 0.7), (1.2, 4, 0.72)), ((0, 3.4, 1.3), (1.2, 4, 1.32)),
    ((3.8, 0, 0), (4.7, 0.05, 2.05)), ((5, 1, 0.9), (5.1, 2.4, 2.1)),
]  # fmt: skip
CRATE = (0.6, 0.4, 0.3)


def edges_of_box(low: tuple[float, ...], high: tuple[float, ...]) -> np.ndarray:
    """The 12 edges (12, 2, 3) of a box."""
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True), indexing="ij"), -1).reshape(8, 3)
    return np.array([(corners[i], corners[i | bit]) for i in range(8) for bit in (1, 2, 4) if not i & bit])


def room() -> np.ndarray:
    """All edges (n, 2, 3)."""
    crate = registration.Model(segments=edges_of_box((0, 0, 0), CRATE))
    askew = crate.transformed(cga3d.translator((3.6, 2.7, 0)) * cga3d.rotor((0, 0, 1), 0.4)).segments
    return np.concatenate([*(edges_of_box(*box) for box in BOXES), askew])


def scan(edges: np.ndarray, seed: int, noise: float, wrong: float) -> tuple[np.ndarray, np.ndarray]:
    """What was seen of edges, and the 4 x 4 matrix that takes it back."""
    random = np.random.default_rng(seed)
    seen = edges[random.permutation(len(edges))[: round(0.8 * len(edges))]]
    low, high = np.sort(random.uniform(-0.5, 1.5, (2, len(seen), 1)), axis=0)
    low, high = np.clip(low, 0, 0.7), np.clip(high, 0.3, 1)
    high = np.maximum(high, low + 0.3)
    seen = seen[:, :1] + np.concatenate([low, high], 1)[..., None] * (seen[:, 1:] - seen[:, :1])
    more = round(len(seen) * wrong / (1 - wrong))
    begin, along = random.uniform((0, 0, 0), (5, 4, 2.5), (more, 3)), random.normal(size=(more, 3))
    other = np.stack([begin, begin + 0.4 * along], 1)
    motor = cga3d.translator(random.normal(size=3)) * cga3d.rotor(random.normal(size=3), random.uniform(0, np.pi))
    matrix = motor.to_matrix()
    both = np.concatenate([seen, other])[random.permutation(len(seen) + more)]
    moved = both @ matrix[:3, :3].T + matrix[:3, 3] + noise * random.normal(size=both.shape)
    return moved, (~motor).to_matrix()


def obj_text(edges: np.ndarray) -> str:
    """Edges as elements `l` of OBJ."""
    rows = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in edges.reshape(-1, 3).tolist()]
    return "\n".join([*rows, *(f"l {2 * i + 1} {2 * i + 2}" for i in range(len(edges)))]) + "\n"


def ply_text(edges: np.ndarray) -> str:
    """Edges as elements `edge` of PLY."""
    head = ["ply", "format ascii 1.0", f"element vertex {2 * len(edges)}", *(f"property double {x}" for x in "xyz")]
    head += [f"element edge {len(edges)}", "property int vertex1", "property int vertex2", "end_header"]
    rows = [f"{x:.6f} {y:.6f} {z:.6f}" for x, y, z in edges.reshape(-1, 3).tolist()]
    return "\n".join([*head, *rows, *(f"{2 * i} {2 * i + 1}" for i in range(len(edges)))]) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--noise", type=float, default=0.01, help="standard deviation of ends, in metres")
    parser.add_argument("--wrong", type=float, default=0.4, help="fraction of segments that are not of the room")
    parser.add_argument("--folder", type=Path, default=HERE)
    arguments = parser.parse_args()
    edges = room()
    seen, back = scan(edges, arguments.seed, arguments.noise, arguments.wrong)
    (arguments.folder / "room.obj").write_text(obj_text(edges), encoding="utf-8")
    (arguments.folder / "room_scan.ply").write_text(ply_text(seen), encoding="utf-8")
    print(f"{len(edges)} edges, {len(seen)} segments\nfrom the scan to the room:\n{np.round(back, 4)}")


if __name__ == "__main__":
    main()
