"""What the tests of the root finders share: the printed functions, compiled, and a reference.

The reference has nothing in common with them: geometric algebra on the orthonormal basis, mpmath's roots of
the octic, and the condition f at 50 digits. Everywhere a = t, and C1 is the circle at a = 1.
"""

from functools import cache
from pathlib import Path

import mpmath as mp
import numpy as np
from mpmath import mpf

from bladesmith.codegen.build.extension import load
from bladesmith.codegen.build.flags import WARNING_FLAGS
from bladesmith.codegen.optimise.variants import as_written
from bladesmith.codegen.programs import trace_spec
from bladesmith.codegen.programs.tracer.algorithms import HITS, shared_functions
from bladesmith.codegen.programs.tracer.surface_kinds import surface_kind
from bladesmith.codegen.programs.tracer.surfaces import texts
from bladesmith.codegen.targets.c.loops import c_functions
from bladesmith.codegen.targets.c.printer import c_function
from bladesmith.codegen.targets.c.source import ExtensionSource
from bladesmith.codegen.targets.templates import render, template_text

HEADERS = ("platform.h", "instance.h", "instance_end.h", "loops.h")
METHODS = {"isolate": 0, "companion": 1, "sampled": 2}
VANISHES, INVALID = -1, -2
MOST = 8  # roots of one branch
DIGITS = 50
SAME = mpf(10) ** -25  # at 50 digits: an imaginary part or a relative value of f below this is zero
KIND = "evolved_circles_1"

CDEF = "".join(
    f"""
    void {KIND}_many_{tag}(int method, int samples, int most, int n, const {S} *rays, const {S} *rows,
                           {S} *roots, int *counts);
    void {KIND}_printed_{tag}(int n, const {S} *rays, const {S} *rows, {S} *powers);
    int {KIND}_eigenvalues_{tag}(int n, const {S} *powers, {S} *re, {S} *im);
    void {KIND}_values_{tag}(const {S} *ray, const {S} *row, {S} t, {S} *square_f_rate_bound);
    """
    for tag, S in (("f64", "double"), ("f32", "float"))
)


@cache
def library():
    kind = surface_kind(KIND)
    declared = dict.fromkeys([*kind.kernels, *(k for _, kernels in kind.methods for k in kernels)])
    functions = [c_function(as_written(trace_spec(d))) for d in declared]
    sizes = {
        "ROW": kind.constants, "ROOTS": kind.roots, "GIVEN": kind.rows.direction.end, "NORM": kind.rows.norm.begin,
        "KAPPA": kind.rows.kappa.begin, "PRINTED": kind.rows.printed, "RAY": kind.rows.shared.end,
        "MEMBER": kind.name, "SUFFIX": kind.rows.degree,
    }  # fmt: skip
    features = "".join(f"#define BS_{name} {value}\n" for name, value in sizes.items())
    features += "#define BS_OUTLINED static __attribute__((noinline, unused))\n#define BS_SURFACE BS_OUTLINED\n"
    source = '#include "platform.h"\n' + features + "".join(
        f"#define BS_BITS {bits}\n#define BS_BYTES 0\n#define BS_TAG f{bits}\n"
        '#include "instance.h"\n#include "kernels.h"\n#include "loops.h"\n'
        '#include "scene_hits.h"\n#include "surface_functions.h"\n#include "standin.h"\n'
        for bits in (64, 32)
    )  # fmt: skip
    headers = {name: template_text(name) for name in HEADERS}
    headers["kernels.h"] = render("kernels.h.j2", functions=functions)
    headers[HITS] = c_functions(shared_functions())
    headers[texts.HEADER] = texts.header(texts.surface_functions([kind], METHODS))
    headers["standin.h"] = Path(__file__).with_name("evolved_roots.h").read_text(encoding="utf-8")
    return load(ExtensionSource("roots_standin", CDEF, source, headers, WARNING_FLAGS))


def call(name, dtype, *arguments):
    """A function of the library; arrays of dtype or int32 are handed over as they are."""
    module, scalar = library(), {8: "double", 4: "float"}[np.dtype(dtype).itemsize]
    kinds = {np.dtype(dtype): f"{scalar}[]", np.dtype(np.int32): "int[]"}
    ready = [module.ffi.from_buffer(kinds[x.dtype], x) if isinstance(x, np.ndarray) else x for x in arguments]
    return getattr(module.lib, f"{KIND}_{name}_f{8 * np.dtype(dtype).itemsize}")(*ready)


def real_spans(m0, kappa, dtype):
    """Where the interpolant is real. Sigma's smaller eigenvalue a^2 + b^2 + a b (m0 - sqrt(kappa)) may be negative."""
    unit = float(np.finfo(dtype).eps) / 2
    rounding = 32 * unit * max(1.0, abs(m0))
    above = m0 - np.sqrt(max(kappa, 0.0)) + 2
    if kappa < -(rounding**2) or not above <= rounding:
        return [0, 1, 1, 0, 1, 0, 1, 0]
    root = np.sqrt(max(above * (above - 4), 0.0))
    end = 1 / (1 + (root - above + 2) / 2) - 16 * unit / (root + np.sqrt(unit))
    return [0, end, 1 - end, 1, 1, 0, 1, 0]


def rows(rays, surfaces, nearness, dtype):
    """Rows of constants as far as roots need them."""
    kind = surface_kind(KIND)
    out = np.zeros((len(rays), kind.constants), dtype)
    for row, ray, surface, near in zip(out, rays, surfaces, nearness, strict=True):
        m0, kappa = surface[:2]
        u, x, e = (np.max(np.abs(part) / (1, 2, 1)) for part in np.array(squares(ray)).reshape(3, 3))
        s0, k = max(1, abs(m0) / 2), abs(kappa)
        row[kind.slice("spans")] = real_spans(float(m0), float(kappa), dtype)
        row[kind.slice("norm")] = 1, m0, 1
        row[kind.slice("kappa")] = kappa
        row[kind.slice("controls")], row[kind.slice("products")] = surface[2:22], surface[22:]
        size = 4 * (s0 * u + x / 4) * (s0 * e + k * x / 4) + (k * u + e) ** 2 / 16
        row[kind.slice("sizes")] = near, size
    return out


def squares(meets):
    """u0 u1 u2, x0 x1 x2, e0 e1 e2 of the meets (w, v, h) of both circles and of both products."""
    b, e = [meets[3 * i : 3 * i + 3] for i in (0, 1)], [meets[3 * i : 3 * i + 3] for i in (2, 3)]
    inner = lambda p, q: p[1] * q[1] - (p[0] * q[2] + p[2] * q[0])  # noqa: E731
    cross = lambda p, q: [inner(p[0], q[0]), inner(p[0], q[1]) + inner(p[1], q[0]), inner(p[1], q[1])]  # noqa: E731
    return cross(b, b) + cross(b, e) + cross(e, e)


def padded(rows, size, end):
    """Rows of which the end is not given: rays without origin and direction, surfaces without controls and products."""
    ends = np.broadcast_to(np.array(end, rows.dtype), (len(rows), len(end)))
    return rows if rows.shape[1] == size else np.hstack([rows, ends])


def solve(method, rays, surfaces, dtype=np.float64, samples=64, most=MOST, nearness=1.0):
    """Roots, and counts or statuses, of many rays (n, 18) (meets, origin, direction) and surfaces (n, 2 or 42)."""
    rays, surfaces = (np.ascontiguousarray(np.atleast_2d(x), dtype) for x in (rays, surfaces))
    rays, surfaces = padded(rays, 18, [0, 0, 0, 1, 0, 0]), padded(surfaces, 42, [0] * 40)
    with np.errstate(all="ignore"):
        constants = rows(rays, surfaces, np.broadcast_to(nearness, len(rays)), dtype)
    roots, counts = np.full((len(rays), MOST), np.nan, dtype), np.zeros(len(rays), np.int32)
    call("many", dtype, METHODS[method], samples, most, len(rays), rays, constants, roots, counts)
    return [row[: max(count, 0)] for row, count in zip(roots, counts, strict=True)], counts


# -- geometric algebra of e1 e2 e3 e+ e- on dicts {bitmask: coefficient}, and the surface ------------------


@cache
def sign(a, b):
    swaps, shifted = 0, a >> 1
    while shifted:
        swaps, shifted = swaps + (shifted & b).bit_count(), shifted >> 1
    return -1 if (swaps + ((a & b) >> 4)) & 1 else 1


def product(x, y, keep=lambda a, b: True):
    out = {}
    for a, p in x.items():
        for b, q in y.items():
            if keep(a, b):
                out[a ^ b] = out.get(a ^ b, 0) + sign(a, b) * p * q
    return out


def outer(x, y):
    return product(x, y, lambda a, b: not a & b)


def grade(x, k):
    return {a: p for a, p in x.items() if a.bit_count() == k}


def combine(p, x, q, y):
    return {a: p * x.get(a, 0) + q * y.get(a, 0) for a in x | y}


def scalar(x, y):
    return sum((sign(a, a) * x[a] * y[a] for a in x.keys() & y.keys()), mpf(0))


I5, INFINITY = {31: mpf(1)}, {8: mpf(1), 16: mpf(1)}


def meet(x, y):
    return product(outer(product(x, I5), product(y, I5)), I5)


def point(v):
    square = sum(c * c for c in v) / 2
    return {1: v[0], 2: v[1], 4: v[2], 8: square - mpf("0.5"), 16: square + mpf("0.5")}


def unit(x):
    return {a: p / mp.sqrt(scalar(x, x)) for a, p in x.items()}


class Line:
    """A unit line: the blade, and the frame X, D, n_inf in which its meets have the parts w, v and h."""

    def __init__(self, origin, direction):
        size = mp.sqrt(sum(mpf(d) ** 2 for d in direction))
        self.origin, self.direction = [mpf(p) for p in origin], [mpf(d) / size for d in direction]
        along = sum(p * d for p, d in zip(self.origin, self.direction, strict=True))
        way = combine(1, dict(zip((1, 2, 4), self.direction, strict=True)), along, INFINITY)
        self.frame = point(self.origin), way, INFINITY
        ahead = [p + d for p, d in zip(self.origin, self.direction, strict=True)]
        self.blade = unit(outer(outer(point(self.origin), point(ahead)), INFINITY))

    def parts(self, y):
        """w, v and h of Y = w X + v D + h n_inf."""
        x, way, far = self.frame
        return [-scalar(y, far), scalar(y, way), -scalar(y, x)]


def line(origin, direction):
    return Line(origin, direction)


def circle_through(*points):
    a, b, c = (point([mpf(x) for x in p]) for p in points)
    return unit(outer(outer(a, b), c))


def circle(center, normal, radius):
    """Counter-clockwise about the normal."""
    n = mp.matrix(normal) / mp.norm(mp.matrix(normal))
    axis = mp.matrix([int(i == min(range(3), key=lambda j: abs(n[j]))) for i in range(3)])
    u = axis - (axis.T * n)[0] * n
    u /= mp.norm(u)
    v = [n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]]
    ring = lambda t: [mpf(center[i]) + radius * (mp.cos(t) * u[i] + mp.sin(t) * v[i]) for i in range(3)]  # noqa: E731
    return circle_through(ring(0), ring(2), ring(4))


def reverse(x):
    return {a: -p for a, p in x.items()}


def null_coefficients(x):
    """Coefficients of a trivector on the kernels' blades, which have n_0 and n_inf in place of e+ and e-."""
    part = lambda a: x.get(a, mpf(0))  # noqa: E731
    near = lambda a: [part(a + 16) - part(a + 8), (part(a + 8) + part(a + 16)) / 2]  # noqa: E731
    return [part(7), *near(3), *near(5), part(25), *near(6), part(26), part(28)]


class Surface:
    """C' = a C1 + (1 - a) C2 and what a ray needs of it."""

    def __init__(self, c1, c2):
        m = combine(1, product(c1, c2), 1, product(c2, c1))
        self.c, self.m0, self.m4 = (c1, c2), m.get(0, mpf(0)), grade(m, 4)
        self.kappa = scalar(self.m4, self.m4)
        self.d = [grade(product(self.m4, c), 3) for c in self.c]

    @property
    def nearness(self):
        """Size of M4 relative to the circles."""
        length = lambda x: mp.sqrt(sum(p * p for p in x.values()))  # noqa: E731
        return float(length(self.m4) / (length(self.c[0]) * length(self.c[1])))

    @property
    def scalars(self):
        return [self.m0, self.kappa]

    @property
    def constants(self):
        """m0, kappa, then the coefficients of both circles and of both products as the kernels have them."""
        return [*self.scalars, *(x for y in (self.c[1], self.c[0], self.d[1], self.d[0]) for x in null_coefficients(y))]

    def ray(self, ray):
        """Meets (w, v, h) of circles and products, the circle of t = 0 first; origin and direction of the line."""
        meets = [part for x in (*self.c[::-1], *self.d[::-1]) for part in ray.parts(grade(meet(ray.blade, x), 1))]
        return [*meets, *ray.origin, *ray.direction]

    def meet_square(self, ray, a):
        """(L v C)^2 by the projector, step by step; None where the interpolant is imaginary."""
        raw = combine(a, self.c[0], 1 - a, self.c[1])
        sigma = product(raw, raw)  # = -C' ~C'
        s0, s4 = sigma[0], grade(sigma, 4)
        norm = mp.sqrt(s0 * s0 - scalar(s4, s4))
        if mp.im(norm) or s0 + norm < 0:
            return None
        root = mp.sqrt(2 * (s0 + norm))
        projected = product(combine((s0 + norm) / root / norm, {0: mpf(1)}, -1 / root / norm, s4), raw)
        y = grade(meet(ray.blade, grade(projected, 3)), 1)
        return scalar(y, y)


# -- the reference -----------------------------------------------------------------------------------------


def convolve(p, q):
    out = [mpf(0)] * (len(p) + len(q) - 1)
    for i, x in enumerate(p):
        for j, y in enumerate(q):
            out[i + j] += x * y
    return out


def octic(ray, m0, kappa):
    """p_k of sum p_k a^k b^(8 - k)."""
    nine = squares(ray)
    u, x, e, s0 = nine[:3], nine[3:6], nine[6:], [1, m0, 1]
    p, q = convolve(s0, u), convolve(s0, e)
    for i in range(3):
        p[i + 1], q[i + 1] = p[i + 1] - x[i], q[i + 1] - kappa * x[i]
    d = [kappa * v - w for v, w in zip(u, e, strict=True)]
    last = [0, 0, *convolve(d, d), 0, 0]
    return [4 * v + w for v, w in zip(convolve(p, q), last, strict=True)]


def powers(scaled):
    """Coefficients by powers of a of sum h_k a^k (1 - a)^(n - k)."""
    n = len(scaled) - 1
    out = [mpf(0)] * (n + 1)
    for k, h in enumerate(scaled):
        for j in range(k, n + 1):
            out[j] += (-1) ** (j - k) * mp.binomial(n - k, j - k) * h
    return out


def condition(ray, m0, kappa, a):
    """2 D t f, and a size to compare it with; None where the interpolant is imaginary."""
    b, ab = 1 - a, a * (1 - a)
    s0 = a * a + b * b + ab * m0
    square = s0 * s0 - kappa * ab * ab
    if square < 0 or (s0 < 0 and kappa >= 0):
        return None
    s = mp.sqrt(square)
    t = s0 + s if s0 >= 0 else -kappa * ab * ab / (s - s0)
    nine = squares(ray)
    u, x, e = (nine[i] * b * b + nine[i + 1] * ab + nine[i + 2] * a * a for i in (0, 3, 6))
    terms = t * t * u, -2 * ab * t * x, ab * ab * e
    return sum(terms), sum(abs(v) for v in terms)


def reference(ray, m0, kappa):
    """All roots of f in [0, 1], as floats: those roots of the octic at which f vanishes."""
    coefficients = powers(octic(ray, m0, kappa))[::-1]
    scaled = [c / max(abs(c) for c in coefficients) for c in coefficients]
    guess = np.roots([float(c) for c in scaled]) * (1 + 1e-9j)  # off the real line, where pairs could not part
    start = [mp.mpc(z) for z in guess] if len(guess) == 8 else None
    candidates = mp.polyroots(scaled, maxsteps=500, extraprec=200, roots_init=start)
    roots = []
    for root in candidates:
        if abs(mp.im(root)) < SAME and 0 <= mp.re(root) <= 1:
            f = condition(ray, m0, kappa, mp.re(root))
            if f is not None and abs(f[0]) <= SAME * f[1]:
                roots.append(float(mp.re(root)))
    return sorted(roots)


def pair(family, seed):
    """Two circles and a ray, parameters exact in double precision."""
    rng = np.random.default_rng([seed, *family.encode()])
    normal, base = rng.normal(size=(2, 3)), rng.normal(size=3)
    center, radius = rng.normal(size=(2, 3)), rng.uniform(0.3, 2, 2)
    if family == "tube":
        center[1] = center[0] + base / np.linalg.norm(base) * rng.uniform(0.5, 2) + 0.3 * normal[0]
        normal, radius[1] = base + 0.3 * normal, radius[0] * rng.uniform(0.5, 1.5)
    if family == "cospherical":
        normal = base + 0.7 * normal
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        height = rng.uniform(-0.8, 0.8, (2, 1))
        center = normal * height + 10.0 ** -rng.uniform(4, 8) * center
        radius = np.sqrt(1 - height[:, 0] ** 2)
    origin = center.mean(axis=0) + 0.8 * rng.normal(size=3)
    shape = [circle(c.tolist(), n.tolist(), float(r)) for c, n, r in zip(center, normal, radius, strict=True)]
    return Surface(*shape), line(origin.tolist(), rng.normal(size=3).tolist())


def as_floats(values, dtype=np.float64):
    return [float(dtype(float(v))) for v in values]


def matched(want, got, reach):
    """Lost, false and largest error: each true root takes the nearest found one within reach."""
    rest, error, lost = list(map(float, got)), 0.0, 0
    for root in want:
        nearest = min(rest, key=lambda x: abs(x - root), default=np.inf)
        if abs(nearest - root) <= reach:
            rest.remove(nearest)
            error = max(error, abs(nearest - root))
        else:
            lost += 1
    return lost, len(rest), error
