"""Light and color: what is seen along one ray, with shadows and reflections."""

from __future__ import annotations

from typing import NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import (
    NAN,
    Bool,
    InOut,
    Ints,
    Out,
    Real,
    Reals,
    Rows,
    Vector,
    empty,
    epsilon,
    largest,
    zeros,
)
from ...status import Status
from .hits import BOXES_OF, IDS_OF, SINGLE, TABLE_SIZE, TABLES, begin_search, distance_of_origin, length, search_status
from .kernels import light_terms, reflected_direction
from .records import HIT, LIGHT, MATERIAL, RAY, SCENE, SEARCH, SKY, STATE
from .search import SearchAlgorithms
from .tree.tree_search import REACH

#: What a camera sees is at least so far away, in units of the numbers that the point was made of: one that stands on a
#: surface looks through it. In single precision, where a camera may be near the ground of a large scene, and in double.
LEAST = (2.0**-16, 2.0**-37)
#: Rays that leave a surface start so far off it, relative to the numbers that the point was made of: more than the
#: error of a hit, less than anything that can be seen.
OFFSET = (2.0**-12, 2.0**-37)
LIGHT_SIZE, MATERIAL_SIZE, SKY_SIZE = LIGHT.size, MATERIAL.size, SKY.size
REFLECTIVITY = MATERIAL.offsets["reflectivity"]


class ShadingAlgorithms(NamedTuple):
    """What is seen first along a ray of a camera, and the color that is seen along any ray."""

    find_seen: algorithm
    add_color: algorithm


@inlined
def size_of_hit(ray: RAY, hit: HIT) -> Real:
    """Size of the numbers that a hit was made of: its errors are relative to it."""
    size = 0.0
    for i in range(3):
        size += abs(ray.origin[i]) + abs(hit.point[i]) + abs(hit.t * ray.direction[i])
    return size


@algorithm
def extent_of_hit(integers: Ints, reals: Reals, ray: RAY, hit: HIT, state: STATE) -> Real:
    """The same, with the numbers of the surface."""
    box = integers[TABLES + TABLE_SIZE * state.hit_kind + BOXES_OF] + 6 * state.hit_index
    size = size_of_hit(ray, hit)
    for i in range(6):
        side = abs(reals[box + i])
        size += side if side <= largest() else 0.0
    return size


@inlined
def floor_of(x: Real) -> Real:
    """The next integer below."""
    if not abs(x) < 2.0**52:
        return x
    cut = float(int(x))
    return cut - 1.0 if cut > x else cut


@inlined
def color_at(color: Out[Vector[3]], material: MATERIAL, point: Vector[3], is_checkered: Bool) -> None:
    """The color of a surface at a point."""
    color[:] = material.color
    if is_checkered:
        across = material.across
        u = across[0, 0] * point[0] + across[0, 1] * point[1] + across[0, 2] * point[2]
        v = across[1, 0] * point[0] + across[1, 1] * point[1] + across[1, 2] * point[2]
        half = 0.5 * (floor_of(u) + floor_of(v))
        if half != floor_of(half):
            color[:] = material.second


@inlined
def add_sky(seen: InOut[Vector[3]], weight: Real, sky: SKY, direction: Vector[3]) -> None:
    """Add the color of the sky."""
    up = direction[2] if direction[2] > 0.0 else 0.0
    for i in range(3):
        seen[i] += weight * ((1.0 - up) * sky.horizon[i] + up * sky.zenith[i])


def shading_algorithms(
    search_of: SearchAlgorithms, has_reflection: bool, has_checker: bool, defers: bool
) -> ShadingAlgorithms:
    """The algorithms of a program.

    Parameters
    ----------
    search_of : SearchAlgorithms
    has_reflection, has_checker : bool
        Mirrors; checkered surfaces.
    defers : bool
        Whether a color is no number where the search of one of its rays cannot tell: another one is asked.
    """
    find, normal_at = search_of.find, search_of.normal

    @inlined
    def is_lit(
        seen: InOut[Vector[3]], scene: SCENE, integers: Ints, reals: Reals, lamp: LIGHT, start: Vector[3],
        towards: Vector[3],
    ) -> Bool:  # fmt: skip
        """Whether a lamp sees a point.

        The way ends before the lamp by the error of a hit: a lamp on a surface is not in the shadow of that surface,
        and shines to both of its sides.
        """
        size = 0.0
        for i in range(3):
            size += abs(start[i]) + abs(lamp.position[i])
        margin = (OFFSET[0] if epsilon() > SINGLE else OFFSET[1]) * size
        distance = length(towards)
        if not distance > margin:
            return True
        shadow = empty(RAY)
        search = empty(SEARCH)
        state = empty(STATE)
        hit = empty(1, HIT)
        shadow.origin[:] = start
        for i in range(3):
            shadow.direction[i] = (1.0 - margin / distance) * towards[i]
        begin_search(scene, 1, search, state)
        search.t_max = 1.0
        find(True, scene, integers, reals, shadow, search, hit, state)
        if defers and search_status(search) != Status.OK:
            seen[0] = NAN
        found: Bool = state.count == 0
        return found

    @inlined
    def add_light(
        seen: InOut[Vector[3]], weight: Real, scene: SCENE, integers: Ints, reals: Reals, material: MATERIAL,
        direction: Vector[3], start: Vector[3], normal: Vector[3],
    ) -> None:  # fmt: skip
        """Add the light that a surface sends back along a ray, without its reflection (Blinn and Phong)."""
        color = empty(3)
        light = empty(3)
        color_at(color, material, start, has_checker)
        for i in range(3):
            light[i] = material.ambient * color[i]
        for number in range(scene.lights):
            at = scene.lights_at + LIGHT_SIZE * number
            lamp = reals[at : at + LIGHT_SIZE]
            towards, factors = light_terms(start, normal, direction, lamp[:3], material.shininess)
            if not factors[0] > 0.0:
                continue
            lit = is_lit(seen, scene, integers, reals, lamp, start, towards)
            if not lit:
                continue
            for i in range(3):
                light[i] += lamp[3 + i] * (material.diffuse * factors[0] * color[i] + material.specular * factors[1])
        for i in range(3):
            seen[i] += weight * light[i]

    @algorithm
    def find_seen(
        scene: SCENE, integers: Ints, reals: Reals, ray: RAY, search: Out[SEARCH], hit: InOut[Rows[HIT]],
        state: Out[STATE],
    ) -> None:  # fmt: skip
        """Find what a camera sees along a ray, but for what it stands on."""
        least = LEAST[0] if epsilon() > SINGLE else LEAST[1]
        near = 8.0 * least * (distance_of_origin(ray) + reals[REACH])  # of all surfaces
        begin_search(scene, 1, search, state)
        find(False, scene, integers, reals, ray, search, hit, state)
        while state.count > 0 and hit[0].t <= near:
            if defers and search_status(search) != Status.OK:
                return  # another search would forget it
            extent = extent_of_hit(integers, reals, ray, hit[0], state)
            begin = least * extent / length(ray.direction)
            if not hit[0].t <= begin:
                return
            cost = state.cost
            begin_search(scene, 1, search, state)
            search.t_min = begin
            state.cost = cost
            find(False, scene, integers, reals, ray, search, hit, state)

    @algorithm
    def add_color(seen: InOut[Vector[3]], scene: SCENE, integers: Ints, reals: Reals, ray: InOut[RAY]) -> None:
        """Add the color seen along a ray of unit direction; reflections are followed one after the other."""
        weight = 1.0
        bounce = 0
        search = empty(SEARCH)
        state = empty(STATE)
        hit = zeros(1, HIT)
        normal = empty(3)
        start = empty(3)
        while True:
            if bounce > 0:
                begin_search(scene, 1, search, state)
                find(False, scene, integers, reals, ray, search, hit, state)
            else:
                find_seen(scene, integers, reals, ray, search, hit, state)
            if defers and search_status(search) != Status.OK:
                seen[0] = NAN
                return
            if state.count == 0:
                add_sky(seen, weight, reals[scene.sky_at : scene.sky_at + SKY_SIZE], ray.direction)
                return
            ids = integers[TABLES + TABLE_SIZE * state.hit_kind + IDS_OF]
            at = scene.materials_at + MATERIAL_SIZE * integers[ids + state.hit_index]
            material = reals[at : at + MATERIAL_SIZE]
            mirror = reals[at + REFLECTIVITY] if bounce < scene.depth else 0.0
            offset = (OFFSET[0] if epsilon() > SINGLE else OFFSET[1]) * size_of_hit(ray, hit[0])
            normal_at(normal, state.hit_kind, state.hit_index, integers, reals, ray, hit[0])
            for i in range(3):
                start[i] = hit[0].point[i] + offset * normal[i]
            if mirror < 1.0:
                share = weight * (1.0 - mirror)
                add_light(seen, share, scene, integers, reals, material, ray.direction, start, normal)
            if not has_reflection:
                return
            if not mirror > 0.0:
                return
            onward = reflected_direction(ray.direction, normal)
            ray.origin[:] = start
            ray.direction[:] = onward
            weight *= mirror
            bounce += 1

    return ShadingAlgorithms(find_seen, add_color)
