"""The pixels of a picture: colors and other layers."""

from __future__ import annotations

from typing import NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import (
    INFINITY,
    NAN,
    InOut,
    Int,
    Ints,
    Ints32,
    Out,
    Real,
    Reals,
    Vector,
    empty,
    zeros,
)
from .hits import length
from .kernels import camera_direction, camera_position
from .records import CAMERA, COLOR, HIT, LEFT_OVER, PICTURE, RAY, SCENE, SEARCH, STATE
from .search import SearchAlgorithms
from .shading import shading_algorithms

CAMERA_SIZE, MOTOR_SIZE = CAMERA.size, CAMERA.offsets["lens"]


class PictureAlgorithms(NamedTuple):
    """Pixels from one to another, and the color of one."""

    render: algorithm
    paint: algorithm


@inlined
def pixel_ray(direction: Out[Vector[3]], camera: CAMERA, picture: PICTURE, x: Real, y: Real) -> None:
    """Direction of the ray through a point of the image plane, in pixels from the left and from the top."""
    right = 2.0 * x / float(picture.width) - 1.0
    up = 1.0 - 2.0 * y / float(picture.height)
    direction[:] = camera_direction(camera.motor, camera.lens, (right, up))


def picture_algorithms(
    search_of: SearchAlgorithms, has_layers: bool, has_reflection: bool, has_checker: bool, defers: bool = False
) -> PictureAlgorithms:
    """The algorithms of a program.

    Parameters
    ----------
    search_of : SearchAlgorithms
    has_layers, has_reflection, has_checker : bool
        Normals, depth and more of pictures; mirrors; checkered surfaces.
    defers : bool
        Whether a color is no number where the search of one of its rays cannot tell: another one is asked.
    """
    normal_at = search_of.normal
    find_seen, add_color = shading_algorithms(search_of, has_reflection, has_checker, defers)

    @inlined
    def store_layers(
        place: Int, scene: SCENE, integers: Ints, reals: Reals, picture: PICTURE, ray: RAY, normal: InOut[Reals],
        depth: InOut[Reals], alpha: InOut[Reals], cost: InOut[Ints32],
    ) -> None:  # fmt: skip
        """What the ray through the middle of a pixel meets. Nothing is infinitely far away, and has no normal."""
        search = empty(SEARCH)
        state = empty(STATE)
        hit = zeros(1, HIT)
        find_seen(scene, integers, reals, ray, search, hit, state)
        is_hit = state.count > 0
        if picture.cost != 0:
            cost[place] = state.cost
        if picture.depth != 0:
            distance = hit[0].t * length(ray.direction)
            depth[place] = distance if is_hit else INFINITY
        if picture.alpha != 0:
            alpha[place] = hit[0].alpha if is_hit else NAN
        if picture.normal != 0:
            at = 3 * place
            for i in range(3):
                normal[at + i] = NAN
            if is_hit:
                normal_at(normal[at : at + 3], state.hit_kind, state.hit_index, integers, reals, ray, hit[0])

    @inlined
    def color_of(
        total: Out[Vector[3]], column: Real, line: Real, origin: Vector[3], scene: SCENE, integers: Ints, reals: Reals,
        picture: PICTURE,
    ) -> None:  # fmt: skip
        """The color of a pixel: the mean of its rays'."""
        ray = empty(RAY)
        seen = empty(3)
        grid = scene.grid
        share = 1.0 / float(grid * grid)
        total[:] = 0.0
        for down in range(grid):
            y = line + (float(down) + 0.5) / float(grid)
            for right in range(grid):
                x = column + (float(right) + 0.5) / float(grid)
                ray.origin[:] = origin
                pixel_ray(ray.direction, reals[scene.camera_at : scene.camera_at + CAMERA_SIZE], picture, x, y)
                seen[:] = 0.0
                add_color(seen, scene, integers, reals, ray)
                for i in range(3):
                    total[i] += share * seen[i]

    @algorithm
    def paint(pixel: Int, scene: SCENE, integers: Ints, reals: Reals, picture: PICTURE, color: Out[Vector[3]]) -> None:
        """The color of a pixel by its number, in reading order."""
        origin = camera_position(reals[scene.camera_at : scene.camera_at + MOTOR_SIZE])
        column, line = float(pixel % picture.width), float(pixel // picture.width)
        color_of(color, column, line, origin, scene, integers, reals, picture)

    @algorithm
    def render(
        begin: Int, end: Int, scene: SCENE, integers: Ints, reals: Reals, picture: PICTURE, color: InOut[Reals],
        normal: InOut[Reals], depth: InOut[Reals], alpha: InOut[Reals], cost: InOut[Ints32],
    ) -> None:  # fmt: skip
        """Pixels from one to another, in reading order: row 0 is the top."""
        total = empty(3)
        camera_at = scene.camera_at
        camera = reals[camera_at : camera_at + CAMERA_SIZE]
        origin = camera_position(camera[:MOTOR_SIZE])
        column = begin % picture.width - 1
        line = begin // picture.width
        for pixel in range(begin, end):
            column += 1  # counted: a division of integers takes as long as a twentieth of a ray
            if column == picture.width:
                column = 0
                line += 1
            place = pixel - picture.first
            if has_layers:
                ray = empty(RAY)
                ray.origin[:] = origin
                pixel_ray(ray.direction, camera, picture, float(column) + 0.5, float(line) + 0.5)
                store_layers(place, scene, integers, reals, picture, ray, normal, depth, alpha, cost)
            if picture.color == COLOR or (picture.color == LEFT_OVER and color[3 * place] != color[3 * place]):
                color_of(total, float(column), float(line), origin, scene, integers, reals, picture)
                for i in range(3):
                    color[3 * place + i] = total[i]

    return PictureAlgorithms(render, paint)
