/* bladesmith: surfaces evolved linearly between two circles. Everything is done in the surface's own frame, moved and
   scaled to about unit size; its constants are made there once. evolved.h finds the roots; here they become points. */

enum {
  FN(EVOLVED_CENTER) = 0,   /* of the frame, in the world */
  FN(EVOLVED_SCALE) = 3,    /* length of its unit, and one over it */
  FN(EVOLVED_BOUND) = 5,    /* centre and radius of a sphere around the surface, in the frame */
  FN(EVOLVED_SURFACE) = 9,  /* m0, kappa */
  FN(EVOLVED_CIRCLES) = 11, /* C1, C2, M4 C1, M4 C2 */
  FN(EVOLVED_SIZE) = 51
};

/* What evolved.h asks for. Of a method that the program leaves out, only the name remains. */
BS_INLINE void FN(evolved_octic)(S *out, const S *ray, const S *surface)
{
#if BS_SCENE_ISOLATE
  FN(cga3d_evolved_octic)(out, ray, surface);
#else
  (void)out, (void)ray, (void)surface;
#endif
}

BS_INLINE S FN(evolved_octic_bound)(const S *ray, const S *surface, S a, S b)
{
#if BS_SCENE_ISOLATE
  S bound[1];
  FN(cga3d_evolved_octic_bound)(bound, ray, surface, &a, &b);
  return bound[0];
#else
  (void)ray, (void)surface, (void)a, (void)b;
  return K(0);
#endif
}

BS_INLINE S FN(evolved_condition)(const S *ray, const S *surface, S a, S b)
{
  S f[1];
  FN(cga3d_evolved_condition)(f, ray, surface, &a, &b);
  return f[0];
}

BS_INLINE S FN(evolved_meet_square)(const S *ray, const S *surface, S a, S b)
{
#if BS_SCENE_COMPANION || BS_SCENE_SAMPLED
  S f[1];
  FN(cga3d_evolved_meet_square)(f, ray, surface, &a, &b);
  return f[0];
#else
  return FN(evolved_condition)(ray, surface, a, b);
#endif
}

BS_INLINE void FN(evolved_dodecic)(S *out, const S *ray, const S *surface)
{
#if BS_SCENE_COMPANION
  FN(cga3d_evolved_dodecic)(out, ray, surface);
#else
  (void)out, (void)ray, (void)surface;
#endif
}

#include "evolved.h"

#ifndef BS_EVOLVED_HIT_CONSTANTS
#define BS_EVOLVED_HIT_CONSTANTS
/* Squared cosine between ray and axis below which a ray counts as near the plane of the circle: the meet's point
   loses a digit for each of the cosine. */
#define BS_EVOLVED_FLAT 1e-4
/* Newton steps from a root to the point; three are enough, the fourth confirms. */
enum { BS_EVOLVED_STEPS = 4 };
#endif

/* Parameters of a surface: frame (centre, unit, one over it), then centre, normal, radius of both circles in it. */
BS_INLINE int FN(evolved_circles_1_prepare)(S *k, const S *parameters)
{
  const S *first = parameters + 5, *second = parameters + 12;
  S *circles = k + FN(EVOLVED_CIRCLES);
  FN(copy)(k, parameters, 5);
  for (int i = 0; i < 3; i++) k[FN(EVOLVED_BOUND) + i] = 0;
  k[FN(EVOLVED_BOUND) + 3] = BS_FAR; /* unbounded, until somebody knows better */
  FN(cga3d_evolved_constants)(circles, circles + 10, circles + 20, circles + 30, k + FN(EVOLVED_SURFACE), first,
                              first + 3, first + 6, second, second + 3, second + 6);
  return 1;
}

typedef struct {
  const S *k;
  S origin[3];      /* of the ray, in the frame, moved along it to where the surface is */
  S moved;          /* by this parameter */
  const S *direction;
  const S *roots;
  int root_count;
  S flat_t[BS_HITS_MOST], flat_a[BS_HITS_MOST]; /* points found by evolved_flat_hits */
  int flat_count;
} FN(evolved_meeting);

BS_INLINE void FN(evolved_offer)(FN(search) *search, const FN(evolved_meeting) *m, S t, S a, const S *position)
{
  const S unit = m->k[FN(EVOLVED_SCALE)];
  FN(hit) *const hit = FN(accept)(search, (t + m->moved) * unit, K(1) - a); /* the curve's parameter is 0 at the first circle */
  if (!hit) return;
  for (int i = 0; i < 3; i++) {
    hit->local[i] = position[i];
    hit->point[i] = m->k[i] + unit * position[i];
  }
}

/* 1 if the nearest root to a is this one, and no other root has found the same point: each point counts once. */
BS_INLINE int FN(evolved_own)(FN(evolved_meeting) *m, int root, S t, S a)
{
  const S settled = BS_ROOTS_NEAR(S) * BS_ROOTS_NEAR(S);
  for (int i = 0; i < m->root_count; i++)
    if (ABS(m->roots[i] - a) < ABS(m->roots[root] - a) - settled) return 0;
  for (int i = 0; i < m->flat_count; i++)
    if (ABS(m->flat_t[i] - t) <= settled * (K(1) + ABS(t)) && ABS(m->flat_a[i] - a) <= settled) return 0;
  m->flat_t[m->flat_count] = t, m->flat_a[m->flat_count++] = a;
  return 1;
}

/* Hits of a ray that lies near the plane of the circle of a root, where the meet vanishes: its points on the circle's
   sphere, refined. A root that only touches has two. */
BS_OWN void FN(evolved_flat_hits)(FN(search) *search, FN(evolved_meeting) *m, int root)
{
  const S *const surface = m->k + FN(EVOLVED_SURFACE), *const c = m->k + FN(EVOLVED_CIRCLES);
  S a = m->roots[root], b = K(1) - a, start[2];
  FN(cga3d_evolved_sphere)(start, m->origin, m->direction, surface, &a, &b, c, c + 10, c + 20, c + 30);
  for (int side = 0; side < 2; side++) {
    S t = start[side], step[2] = {0, 0}, position[3];
    a = m->roots[root];
    for (int i = 0; i < BS_EVOLVED_STEPS; i++) {
      b = K(1) - a;
      FN(cga3d_evolved_polish)(step, m->origin, m->direction, &t, surface, &a, &b, c, c + 10, c + 20, c + 30);
      t += step[0], a += step[1];
    }
    const S margin = K(BS_ROOTS_MARGIN) * BS_ROOTS_UNIT(S), settled = BS_ROOTS_NEAR(S) * BS_ROOTS_NEAR(S);
    if (!(a >= -margin && a <= K(1) + margin && ABS(step[1]) < settled)) continue;
    a = a < 0 ? K(0) : a > 1 ? K(1) : a;
    if (!FN(evolved_own)(m, root, t, a)) continue;
    for (int i = 0; i < 3; i++) position[i] = m->origin[i] + t * m->direction[i];
    FN(evolved_offer)(search, m, t, a, position);
  }
}

BS_INLINE int FN(evolved_roots)(S *roots, const S *ray, const S *surface, const FN(search) *search)
{
#if BS_SCENE_COMPANION
  if (search->method == 1) return FN(evolved_companion)(roots, BS_ROOTS_MOST, ray, surface);
#endif
#if BS_SCENE_SAMPLED
  if (search->method == 2) return FN(evolved_sampled)(roots, BS_ROOTS_MOST, ray, surface, search->samples);
#endif
#if BS_SCENE_ISOLATE
  if (search->method == 0) return FN(evolved_isolate)(roots, BS_ROOTS_MOST, ray, surface);
#endif
  return 0;
}

BS_OWN void FN(evolved_circles_1_hits)(FN(search) *search, const S *k, const FN(ray) *ray)
{
  const S *const surface = k + FN(EVOLVED_SURFACE), *const c = k + FN(EVOLVED_CIRCLES);
  const S *const bound = k + FN(EVOLVED_BOUND), *const unit = k + FN(EVOLVED_SCALE);
  S scalars[9], roots[BS_ROOTS_MOST];
  FN(evolved_meeting) m;
  m.k = k, m.direction = ray->direction, m.roots = roots, m.flat_count = 0, m.moved = 0;
  for (int i = 0; i < 3; i++) m.origin[i] = (ray->origin[i] - k[i]) * unit[1];
  if (bound[3] < BS_FAR) {
    S span[2], first[3], last[3];
    FN(cga3d_sphere_hit)(span, first, last, m.origin, m.direction, bound, bound + 3);
    if (!(span[1] * unit[0] > search->t_min && span[0] * unit[0] < search->t_max)) return;
    m.moved = K(0.5) * (span[0] + span[1]);
    for (int i = 0; i < 3; i++) m.origin[i] += m.moved * m.direction[i];
  }
  FN(cga3d_evolved_ray)(scalars, m.origin, m.direction, c, c + 10, c + 20, c + 30);
  m.root_count = FN(evolved_roots)(roots, scalars, surface, search);
  if (m.root_count < 0)
    search->status = m.root_count == BS_EVOLVED_VANISHES ? BS_STATUS_SINGULAR : BS_STATUS_INVALID;
  for (int i = 0; i < m.root_count; i++) {
    const S a = roots[i], b = K(1) - a;
    S t_cosine[2], position[3];
    FN(cga3d_evolved_point)(t_cosine, position, m.origin, m.direction, surface, &a, &b, c, c + 10, c + 20, c + 30);
    if (t_cosine[1] > K(BS_EVOLVED_FLAT)) {
      FN(evolved_offer)(search, &m, t_cosine[0], a, position);
    } else {
      FN(evolved_flat_hits)(search, &m, i);
    }
  }
}

BS_OWN void FN(evolved_circles_1_normal)(S *normal, const S *k, const FN(ray) *ray, const FN(hit) *hit)
{
  const S *const c = k + FN(EVOLVED_CIRCLES), b = hit->alpha, a = K(1) - b;
  (void)ray;
  FN(cga3d_evolved_normal)(normal, hit->local, k + FN(EVOLVED_SURFACE), &a, &b, c, c + 10, c + 20, c + 30);
}
