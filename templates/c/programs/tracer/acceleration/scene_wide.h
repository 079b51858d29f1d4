/* bladesmith: first hits of W rays at a time, for scenes of a few planes and spheres: only how far and which. The same
   formulas as in plain_surfaces.py give the same bits; points and normals are asked for later. A checksum of
   the rays' own bits tells then whether they are still the same. */
#include "scene_scale.h"

typedef struct {
  V t, id; /* of the nearest so far; surfaces are few: a floating number tells which */
  V origin[3], direction[3];
} FN(wide);

typedef int32_t FN(wide_ids) __attribute__((vector_size(4 * W)));

BS_INLINE void FN(wide_offer)(FN(wide) * rays, V t, V id)
{
  const M nearer = OR(LT(t, rays->t), AND(EQ(t, rays->t), LT(id, rays->id)));
  const M taken = AND(GT(t, SPLAT(0)), nearer);
  rays->t = SELECT(taken, t, rays->t);
  rays->id = SELECT(taken, id, rays->id);
}

BS_INLINE void FN(plane_wide)(FN(wide) * rays, const S *k, V id)
{
  V row[4], t[1];
  FN(load_broadcast)(row, k, 4);
  FN(cga3d_plane_hit)(t, rays->origin, rays->direction, row, row + 3);
  FN(wide_offer)(rays, t[0], id);
}

BS_INLINE void FN(sphere_wide)(FN(wide) * rays, const S *k, V id)
{
  V row[4], t[2], first[3], last[3];
  FN(load_broadcast)(row, k, 4);
  FN(cga3d_sphere_hit)(t, first, last, rays->origin, rays->direction, row, row + 3);
  /* t[0] <= t[1], or neither is a number */
  FN(wide_offer)(rays, SELECT(GT(t[0], SPLAT(0)), t[0], t[1]), id);
}

BS_INLINE void FN(wide_load)(V *columns, const void *rows, ptrdiff_t stride, ptrdiff_t i, int count)
{
  const S *const from = (const S *)rows + i * stride;
  if (!stride) {
    FN(load_broadcast)(columns, from, 3);
  } else if (count == W) {
    FN(load_rows)(columns, from, 3);
  } else {
    FN(load_tail)(columns, from, 3, count);
  }
}

/* Bits of six numbers folded into one, different for each place of each bit: what is turned over, moved or exchanged
   in several at once does not cancel. */
BS_INLINE UI FN(wide_bits)(const V *origin, const V *direction)
{
  UI bits = (UI)BITS(origin[0]);
  BS_UNROLL
  for (int i = 1; i < 6; i++) {
    const UI more = (UI)BITS(i < 3 ? origin[i] : direction[i - 3]);
    bits += more ^ (more >> (5 * i));
  }
  return bits;
}

/* The checksums of all lanes in one. */
BS_INLINE uint64_t FN(wide_checksum)(UI lanes)
{
  uint64_t checksum = 0;
  for (int l = 0; l < W; l++) {
    checksum = (checksum ^ lanes[l]) * UINT64_C(0x9e3779b97f4a7c15);
    checksum ^= checksum >> 29;
  }
  return checksum;
}

/* Rays of one checksum. */
BS_INLINE void FN(wide_part)(
    const bs_scene *scene, ptrdiff_t begin, ptrdiff_t end, const bs_rays *given, const bs_hits *out)
{
  /* copies, which no result that is stored could change */
  const void *const origins = given->origins, *const directions = given->directions;
  const ptrdiff_t origin_stride = given->origin_stride, direction_stride = given->direction_stride;
  const S *const reals = (const S *)scene->reals;
  const ptrdiff_t *const integers = scene->integers;
  const ptrdiff_t (*const tables)[BS_TABLE_SIZE] = (const ptrdiff_t (*)[BS_TABLE_SIZE])(integers + BS_LAYOUT_SIZE);
  S *const times = (S *)out->t;
  int32_t *const surfaces = out->surface;
  uint8_t *const statuses = out->status;
  UI checksum = {0};
  for (ptrdiff_t i = begin; i < end; i += W) {
    const int count = end - i < W ? (int)(end - i) : W;
    FN(wide) rays;
    FN(wide_load)(rays.origin, origins, origin_stride, i, count);
    FN(wide_load)(rays.direction, directions, direction_stride, i, count);
    checksum ^= FN(wide_bits)(rays.origin, rays.direction);
    checksum += checksum << 5;
    checksum ^= checksum >> (BS_BITS / 2 - 1);
    const V *const o = rays.origin, square = FN(scene_scaled)(rays.direction),
                   reach = ABS(o[0]) + ABS(o[1]) + ABS(o[2]);
    const M valid =
        AND(LE(reach + square, SPLAT(BS_FAR)), GT(square, SPLAT(0))); /* the square adds nothing to BS_FAR */
    rays.t = SPLAT(BS_FAR), rays.id = SPLAT(-1);
#define BS_EACH(number, name, given_size, size)                                        \
  for (ptrdiff_t k = 0; k < tables[number][BS_TABLE_ROWS]; k++)                        \
    FN(name##_wide)(&rays, reals + tables[number][BS_TABLE_CONSTANTS_AT] + k * (size), \
        SPLAT(integers[tables[number][BS_TABLE_IDS_AT] + k]));
    BS_SCENE_KINDS(BS_EACH)
#undef BS_EACH
    const V distance = rays.t * SQRT(square);
    const V id = SELECT(AND(valid, LE(distance + reach, SPLAT(BS_FAR))), rays.id, SPLAT(-1));
    const M answered = AND(valid, EQ(id, rays.id)); /* nothing found is too far away: as scene_rays.h has it */
    const V t = SELECT(GE(id, SPLAT(0)), distance, SPLAT(BS_NOT_A_NUMBER));
    const FN(wide_ids) ids = __builtin_convertvector(id, FN(wide_ids));
    if (count == W && !ANY(NOT(answered))) {
      FN(store_rows)(times + i, &t, 1);
      __builtin_memcpy(surfaces + i, &ids, sizeof ids);
      __builtin_memset(statuses + i, BS_STATUS_OK, W);
    } else {
      for (int l = 0; l < count; l++) {
        times[i + l] = t[l];
        surfaces[i + l] = ids[l];
        statuses[i + l] = (uint8_t)(BS_LANE(answered, l) ? BS_STATUS_OK : BS_STATUS_INVALID);
      }
    }
  }
  if (out->checksum) out->checksum[begin >> BS_CHECKSUM_BITS] = FN(wide_checksum)(checksum);
}

static void FN(scene_wide)(
    const bs_scene *scene, ptrdiff_t begin, ptrdiff_t end, const bs_rays *given, const bs_hits *out)
{
  const ptrdiff_t most = (ptrdiff_t)1 << BS_CHECKSUM_BITS;
  for (ptrdiff_t i = begin; i < end; i += most) FN(wide_part)(scene, i, i + most < end ? i + most : end, given, out);
}
