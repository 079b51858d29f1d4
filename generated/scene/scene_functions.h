/* Constants of rows of a kind that has some of its own. */
BS_OUTLINED void FN(prepare_rows)(ptrdiff_t kind, ptrdiff_t rows, const S *parameters, S *constants)
{
  ptrdiff_t given;
  ptrdiff_t to;
  if (kind == 5) {
    for (ptrdiff_t i = 0; i < rows; i++) {
      given = 35 * i;
      to = 65 * i;
      FN(prepare_evolved_circles_1)(parameters + given, constants + to);
    }
  }
  if (kind == 6) {
    for (ptrdiff_t i = 0; i < rows; i++) {
      given = 45 * i;
      to = 111 * i;
      FN(prepare_evolved_circles_2)(parameters + given, constants + to);
    }
  }
  if (kind == 7) {
    for (ptrdiff_t i = 0; i < rows; i++) {
      given = 55 * i;
      to = 157 * i;
      FN(prepare_evolved_circles_3)(parameters + given, constants + to);
    }
  }
  if (kind == 8) {
    for (ptrdiff_t i = 0; i < rows; i++) {
      given = 35 * i;
      to = 69 * i;
      FN(prepare_evolved_point_pairs_1)(parameters + given, constants + to);
    }
  }
  if (kind == 9) {
    for (ptrdiff_t i = 0; i < rows; i++) {
      given = 45 * i;
      to = 115 * i;
      FN(prepare_evolved_point_pairs_2)(parameters + given, constants + to);
    }
  }
  if (kind == 10) {
    for (ptrdiff_t i = 0; i < rows; i++) {
      given = 55 * i;
      to = 161 * i;
      FN(prepare_evolved_point_pairs_3)(parameters + given, constants + to);
    }
  }
}

/* Begin a search of all of a ray, or of its line where there is room for more than one point. */
BS_INLINE void FN(begin_search)(const ptrdiff_t scene[BS_LENGTH(16)], ptrdiff_t room, S search[BS_LENGTH(4)],
    ptrdiff_t state[BS_LENGTH(10)])
{
  search[0] = room > 1 ? -K(BS_GREATEST) : K(0.0);
  search[1] = K(BS_GREATEST);
  search[2] = K(BS_GREATEST);
  search[3] = K(BS_GREATEST);
  state[0] = room;
  state[1] = 0;
  state[4] = 0;
  state[5] = 0;
  state[6] = scene[3];
  state[7] = scene[4];
  state[8] = 0;
  state[9] = 0;
}

/* How far the origin of a ray is from that of the world, or further; no number if one of its own is none. */
BS_INLINE S FN(distance_of_origin)(const S ray[BS_LENGTH(6)])
{
  return ABS(ray[0]) + ABS(ray[1]) + ABS(ray[2]);
}

/* Ray i of two arrays; whether it is one. A stride is 0, one for all, or 3. */
BS_INLINE int FN(load_ray)(const S *origins, ptrdiff_t origin_stride, const S *directions,
    ptrdiff_t direction_stride, ptrdiff_t i, S ray[BS_LENGTH(6)])
{
  ray[0] = origins[i * origin_stride];
  ray[3] = directions[i * direction_stride];
  ray[1] = origins[i * origin_stride + 1];
  ray[4] = directions[i * direction_stride + 1];
  ray[2] = origins[i * origin_stride + 2];
  ray[5] = directions[i * direction_stride + 2];
  const S result = FN(distance_of_origin)(ray);
  const S far = result;
  const S result1 = FN(scene_scaled)(ray + 3);
  const S square = result1;
  const int found = far - far == K(0.0) && square > K(0.0) && square - square == K(0.0);
  return found;
}

/* Offer a point of the ray, given relative to a centre. */
BS_INLINE void FN(offer)(S t, const S center[BS_LENGTH(3)], const S local[BS_LENGTH(3)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  const ptrdiff_t result = FN(accept_hit)(t, K(BS_NOT_A_NUMBER), search, hits, state, integers);
  const ptrdiff_t place = result;
  if (place >= 0) {
    const ptrdiff_t hit_at = 9 * place;
    hits[hit_at + 6] = local[0];
    hits[hit_at + 3] = center[0] + local[0];
    hits[hit_at + 6 + 1] = local[1];
    hits[hit_at + 3 + 1] = center[1] + local[1];
    hits[hit_at + 6 + 2] = local[2];
    hits[hit_at + 3 + 2] = center[2] + local[2];
  }
}

/* Offer the point on a plane. */
BS_OUTLINED void FN(plane_hits)(const S row[BS_LENGTH(4)], const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  S local[3];
  S row1[1];
  FN(cga3d_plane_hit)(row1, ray, ray + 3, row, row + 3);
  const S t = row1[0];
  local[0] = t * ray[3];
  local[1] = t * ray[4];
  local[2] = t * ray[5];
  FN(offer)(t, ray, local, search, hits, state, integers);
}

/* Offer both points on a sphere. */
BS_OUTLINED void FN(sphere_hits)(const S row[BS_LENGTH(4)], const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  S t[2];
  S first[3];
  S last[3];
  FN(cga3d_sphere_hit)(t, first, last, ray, ray + 3, row, row + 3);
  FN(offer)(t[0], row, first, search, hits, state, integers);
  FN(offer)(t[1], row, last, search, hits, state, integers);
}

/* Offer where a ray in the disc's plane meets the rim: nowhere, once where it touches, or twice. */
BS_OUTLINED void FN(disc_rim)(const S row[BS_LENGTH(7)], const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)], S *hits,
    ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  S t[2];
  S first[3];
  S last[3];
  FN(cga3d_rim_hit)(t, first, last, ray, ray + 3, row, row + 3, row + 6);
  FN(offer)(t[0], row, first, search, hits, state, integers);
  FN(offer)(t[1], row, last, search, hits, state, integers);
}

/* Offer the point of a ray that only grazes the disc. */
BS_OUTLINED void FN(disc_grazed)(const S row[BS_LENGTH(7)], const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  S row1[1];
  S local[3];
  FN(cga3d_disc_graze)(row1, local, ray, ray + 3, row, row + 3, row + 6);
  const S t = row1[0];
  FN(offer)(t, row, local, search, hits, state, integers);
}

/* Offer the points on a disc. */
BS_OUTLINED void FN(disc_hits)(const S row[BS_LENGTH(7)], const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)], S *hits,
    ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  S measures[3];
  S local[3];
  FN(cga3d_disc_hit)(measures, local, ray, ray + 3, row, row + 3, row + 6);
  if (measures[2] > K(0.0)) {
    FN(disc_rim)(row, ray, search, hits, state, integers);
  } else {
    if (measures[1] <= K(0.0) && measures[2] < K(0.0)) {
      FN(disc_grazed)(row, ray, search, hits, state, integers);
    } else {
      if (measures[1] <= K(0.0)) {
        FN(offer)(measures[0], row, local, search, hits, state, integers);
      }
    }
  }
}

/* The axes in a cyclic order in which the largest coordinate of a vector is the last. */
BS_INLINE void FN(cyclic_axes)(const S x[BS_LENGTH(3)], ptrdiff_t axes[BS_LENGTH(3)])
{
  const S a = ABS(x[0]);
  const S b = ABS(x[1]);
  const S c = ABS(x[2]);
  ptrdiff_t last = 2;
  if (a > b) {
    if (a > c) {
      last = 0;
    }
  } else {
    if (b > c) {
      last = 1;
    }
  }
  axes[0] = last == 2 ? 0 : last + 1;
  axes[1] = last == 0 ? 2 : last - 1;
  axes[2] = last;
}

/* Offer the point on a triangle. */
BS_OUTLINED void FN(facet_hits)(const S row[BS_LENGTH(9)], const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  ptrdiff_t axes[3];
  S origin[3];
  S direction[3];
  S corners[9];
  FN(cyclic_axes)(ray + 3, axes);
  for (ptrdiff_t i = 0; i < 3; i++) {
    origin[i] = ray[axes[i]];
    direction[i] = ray[3 + axes[i]];
    corners[i] = row[axes[i]];
    corners[3 + i] = row[3 + axes[i]];
    corners[6 + i] = row[6 + axes[i]];
  }
  S sides[3];
  FN(cga3d_facet_sides)(sides, origin, direction, corners, corners + 3, corners + 6);
  const int is_outside = sides[0] < K(0.0) || sides[1] < K(0.0) || sides[2] < K(0.0);
  if (is_outside && (sides[0] > K(0.0) || sides[1] > K(0.0) || sides[2] > K(0.0))) {
    return;
  }
  S row1[1];
  S weights[3];
  S local[3];
  FN(cga3d_facet_hit)(row1, weights, local, origin, direction, corners, corners + 3, corners + 6, sides);
  const S t = row1[0];
  const ptrdiff_t result = FN(accept_hit)(t, K(BS_NOT_A_NUMBER), search, hits, state, integers);
  const ptrdiff_t place = result;
  if (place >= 0) {
    const ptrdiff_t hit_at = 9 * place;
    for (ptrdiff_t k = 0; k < 3; k++) {
      hits[hit_at + 6 + k] = weights[k];
    }
    for (ptrdiff_t i = 0; i < 3; i++) {
      hits[hit_at + 3 + axes[i]] = row[axes[i]] + local[i];
    }
  }
}

/* Offer the point on a triangle that is shaded with the normals of its corners. */
BS_INLINE void FN(smooth_facet_hits)(const S row[BS_LENGTH(18)], const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  FN(facet_hits)(row, ray, search, hits, state, integers);
}

/* Offer the points of a ray on a piece, found as the scene says. */
BS_INLINE void FN(hits_by_method_evolved_circles_1)(const S *row, const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  if (state[6] == 0) {
    FN(hits_evolved_circles_1_isolate)(row, ray, search, hits, state, integers);
  }
  if (state[6] == 1) {
    FN(hits_evolved_circles_1_companion)(row, ray, search, hits, state, integers);
  }
  if (state[6] == 2) {
    FN(hits_evolved_circles_1_sampled)(row, ray, search, hits, state, integers);
  }
}

/* Offer the points of a ray on a piece, found as the scene says. */
BS_INLINE void FN(hits_by_method_evolved_circles_2)(const S *row, const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  if (state[6] == 0) {
    FN(hits_evolved_circles_2_isolate)(row, ray, search, hits, state, integers);
  }
  if (state[6] == 1) {
    FN(hits_evolved_circles_2_companion)(row, ray, search, hits, state, integers);
  }
  if (state[6] == 2) {
    FN(hits_evolved_circles_2_sampled)(row, ray, search, hits, state, integers);
  }
}

/* Offer the points of a ray on a piece, found as the scene says. */
BS_INLINE void FN(hits_by_method_evolved_circles_3)(const S *row, const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  if (state[6] == 0) {
    FN(hits_evolved_circles_3_isolate)(row, ray, search, hits, state, integers);
  }
  if (state[6] == 1) {
    FN(hits_evolved_circles_3_companion)(row, ray, search, hits, state, integers);
  }
  if (state[6] == 2) {
    FN(hits_evolved_circles_3_sampled)(row, ray, search, hits, state, integers);
  }
}

/* Offer the points of a ray on a piece, found as the scene says. */
BS_INLINE void FN(hits_by_method_evolved_point_pairs_1)(const S *row, const S ray[BS_LENGTH(6)],
    S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  if (state[6] == 0) {
    FN(hits_evolved_point_pairs_1_isolate)(row, ray, search, hits, state, integers);
  }
  if (state[6] == 1) {
    FN(hits_evolved_point_pairs_1_companion)(row, ray, search, hits, state, integers);
  }
  if (state[6] == 2) {
    FN(hits_evolved_point_pairs_1_sampled)(row, ray, search, hits, state, integers);
  }
}

/* Offer the points of a ray on a piece, found as the scene says. */
BS_INLINE void FN(hits_by_method_evolved_point_pairs_2)(const S *row, const S ray[BS_LENGTH(6)],
    S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  if (state[6] == 0) {
    FN(hits_evolved_point_pairs_2_isolate)(row, ray, search, hits, state, integers);
  }
  if (state[6] == 1) {
    FN(hits_evolved_point_pairs_2_companion)(row, ray, search, hits, state, integers);
  }
  if (state[6] == 2) {
    FN(hits_evolved_point_pairs_2_sampled)(row, ray, search, hits, state, integers);
  }
}

/* Offer the points of a ray on a piece, found as the scene says. */
BS_INLINE void FN(hits_by_method_evolved_point_pairs_3)(const S *row, const S ray[BS_LENGTH(6)],
    S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  if (state[6] == 0) {
    FN(hits_evolved_point_pairs_3_isolate)(row, ray, search, hits, state, integers);
  }
  if (state[6] == 1) {
    FN(hits_evolved_point_pairs_3_companion)(row, ray, search, hits, state, integers);
  }
  if (state[6] == 2) {
    FN(hits_evolved_point_pairs_3_sampled)(row, ray, search, hits, state, integers);
  }
}

/* Keep what the row that was asked said, which could not tell, with the place where its box begins. */
BS_OUTLINED void FN(note_status)(const ptrdiff_t scene[BS_LENGTH(16)], const ptrdiff_t *integers, const S *reals,
    const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)], ptrdiff_t state[BS_LENGTH(10)])
{
  (void)scene;
  S begin = -K(BS_GREATEST);
  S first[3];
  S last[3];
  const ptrdiff_t low = integers[16 + 4 * state[2] + 2] + 6 * state[3];
  S near[3];
  S far[3];
  S inverse[3];
  FN(cga3d_box_ray)(near, far, inverse, ray, ray + 3, reals);
  for (ptrdiff_t i = 0; i < 3; i++) {
    const int is_backward = ray[3 + i] < K(0.0);
    first[i] = is_backward ? reals[low + 3 + i] : reals[low + i];
    last[i] = is_backward ? reals[low + i] : reals[low + 3 + i];
  }
  S row[2];
  row[0] = -K(BS_GREATEST);
  row[1] = K(BS_GREATEST);
  S span[2];
  FN(cga3d_box_span)(span, near, far, inverse, first, last, row);
  begin = span[0];
  if (state[8] == 1) {
    if (begin < search[2]) {
      search[2] = begin;
    }
  } else {
    if (begin < search[3]) {
      search[3] = begin;
    }
  }
  state[8] = 0;
}

/* Count a row that was asked, and note what it said. */
BS_INLINE void FN(after_row)(const ptrdiff_t scene[BS_LENGTH(16)], const ptrdiff_t *integers, const S *reals,
    const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)], ptrdiff_t state[BS_LENGTH(10)])
{
  state[9] = state[9] + 1;
  if (state[8] != 0) {
    FN(note_status)(scene, integers, reals, ray, search, state);
  }
}

/* Ask the row of an item. */
BS_INLINE void FN(ask_row)(ptrdiff_t item, const ptrdiff_t scene[BS_LENGTH(16)], const ptrdiff_t *integers,
    const S *reals, const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)])
{
  state[2] = integers[scene[11] + 2 * item];
  state[3] = integers[scene[11] + 2 * item + 1];
  ptrdiff_t at;
  if (state[2] == 0) {
    at = integers[17] + 4 * state[3];
    FN(plane_hits)(reals + at, ray, search, hits, state, integers);
  }
  if (state[2] == 1) {
    at = integers[21] + 4 * state[3];
    FN(sphere_hits)(reals + at, ray, search, hits, state, integers);
  }
  if (state[2] == 2) {
    at = integers[25] + 7 * state[3];
    FN(disc_hits)(reals + at, ray, search, hits, state, integers);
  }
  if (state[2] == 3) {
    at = integers[29] + 9 * state[3];
    FN(facet_hits)(reals + at, ray, search, hits, state, integers);
  }
  if (state[2] == 4) {
    at = integers[33] + 18 * state[3];
    FN(smooth_facet_hits)(reals + at, ray, search, hits, state, integers);
  }
  if (state[2] == 5) {
    at = integers[37] + 65 * state[3];
    FN(hits_by_method_evolved_circles_1)(reals + at, ray, search, hits, state, integers);
  }
  if (state[2] == 6) {
    at = integers[41] + 111 * state[3];
    FN(hits_by_method_evolved_circles_2)(reals + at, ray, search, hits, state, integers);
  }
  if (state[2] == 7) {
    at = integers[45] + 157 * state[3];
    FN(hits_by_method_evolved_circles_3)(reals + at, ray, search, hits, state, integers);
  }
  if (state[2] == 8) {
    at = integers[49] + 69 * state[3];
    FN(hits_by_method_evolved_point_pairs_1)(reals + at, ray, search, hits, state, integers);
  }
  if (state[2] == 9) {
    at = integers[53] + 115 * state[3];
    FN(hits_by_method_evolved_point_pairs_2)(reals + at, ray, search, hits, state, integers);
  }
  if (state[2] == 10) {
    at = integers[57] + 161 * state[3];
    FN(hits_by_method_evolved_point_pairs_3)(reals + at, ray, search, hits, state, integers);
  }
  FN(after_row)(scene, integers, reals, ray, search, state);
}

/* Whether the distance of a hit, and its point, are numbers. */
BS_INLINE int FN(is_within)(S distance, const S ray[BS_LENGTH(6)])
{
  const S result = FN(distance_of_origin)(ray);
  const int found = ABS(distance) + result <= K(BS_GREATEST);
  return found;
}

/* How far the parameter of a curve runs, from the first to the last row of the surface that is asked. */
BS_INLINE S FN(period_of)(ptrdiff_t kind, const ptrdiff_t *integers, const S *reals)
{
  S found = K(0.0);
  ptrdiff_t first;
  ptrdiff_t last;
  if (kind == 5) {
    first = integers[37] + 5;
    last = first + 65 * (integers[36] - 1);
    found = reals[last] + reals[last + 1] - reals[first];
  }
  if (kind == 6) {
    first = integers[41] + 5;
    last = first + 111 * (integers[40] - 1);
    found = reals[last] + reals[last + 1] - reals[first];
  }
  if (kind == 7) {
    first = integers[45] + 5;
    last = first + 157 * (integers[44] - 1);
    found = reals[last] + reals[last + 1] - reals[first];
  }
  if (kind == 8) {
    first = integers[49] + 5;
    last = first + 69 * (integers[48] - 1);
    found = reals[last] + reals[last + 1] - reals[first];
  }
  if (kind == 9) {
    first = integers[53] + 5;
    last = first + 115 * (integers[52] - 1);
    found = reals[last] + reals[last + 1] - reals[first];
  }
  if (kind == 10) {
    first = integers[57] + 5;
    last = first + 161 * (integers[56] - 1);
    found = reals[last] + reals[last + 1] - reals[first];
  }
  return found;
}

/* The place, among the points of a line, of another that is this one; -1 for none. */
BS_INLINE ptrdiff_t FN(joint_at)(ptrdiff_t begin, ptrdiff_t kept, S distance, const ptrdiff_t *integers,
    const S *reals, const S ray[BS_LENGTH(6)], const S hit[BS_LENGTH(9)], const ptrdiff_t state[BS_LENGTH(10)],
    const S *t, const S *alpha, const int32_t *rows)
{
  if (!(kept > 0 && hit[1] - hit[1] == K(0.0))) {
    return -1;
  }
  const S result = FN(length)(ray);
  const S size = ABS(distance) + result;
  const S result1 = FN(period_of)(state[2], integers, reals);
  const S period = result1;
  const S near = (K(BS_EPSILON) > K(1e-10) ? K(6.103515625e-05) : K(7.275957614183426e-12)) * (K(1.0) + ABS(hit[1]));
  const S place = K(BS_EPSILON) > K(1e-10) ? K(0.00034526698300124393) : K(1.4901161193847656e-08);
  for (ptrdiff_t i = 0; i < kept; i++) {
    const S apart = ABS(alpha[begin + i] - hit[1]);
    const int is_joint = (ptrdiff_t)rows[begin + i] != state[3] && apart <= near;
    if ((is_joint || ABS(apart - period) <= near) && (ABS(t[begin + i] - distance) <= place * size)) {
      return i;
    }
  }
  return -1;
}

/* Move a hit from one place of the arrays to another. */
BS_INLINE void FN(move_row)(ptrdiff_t to, ptrdiff_t place, S *t, S *alpha, S *point, S *normal, int32_t *rows)
{
  rows[to] = (int32_t)((ptrdiff_t)rows[place]);
  t[to] = t[place];
  alpha[to] = alpha[place];
  for (ptrdiff_t i = 0; i < 3; i++) {
    point[3 * to + i] = point[3 * place + i];
    normal[3 * to + i] = normal[3 * place + i];
  }
}

/* Normal of a plane. */
BS_INLINE void FN(plane_normal)(S normal[BS_LENGTH(3)], const S row[BS_LENGTH(4)], const S ray[BS_LENGTH(6)],
    const S hit[BS_LENGTH(9)])
{
  (void)ray;
  (void)hit;
  for (ptrdiff_t k = 0; k < 3; k++) {
    normal[k] = row[k];
  }
}

/* Normal of a sphere. */
BS_INLINE void FN(sphere_normal)(S normal[BS_LENGTH(3)], const S row[BS_LENGTH(4)], const S ray[BS_LENGTH(6)],
    const S hit[BS_LENGTH(9)])
{
  (void)ray;
  normal[0] = hit[6] / row[3];
  normal[1] = hit[7] / row[3];
  normal[2] = hit[8] / row[3];
}

/* Normal of a disc. */
BS_INLINE void FN(disc_normal)(S normal[BS_LENGTH(3)], const S row[BS_LENGTH(7)], const S ray[BS_LENGTH(6)],
    const S hit[BS_LENGTH(9)])
{
  (void)ray;
  (void)hit;
  for (ptrdiff_t k = 0; k < 3; k++) {
    normal[k] = row[3 + k];
  }
}

/* Normal of a triangle. */
BS_INLINE void FN(facet_normal)(S normal[BS_LENGTH(3)], const S row[BS_LENGTH(9)], const S ray[BS_LENGTH(6)],
    const S hit[BS_LENGTH(9)])
{
  (void)ray;
  (void)hit;
  FN(cga3d_facet_normal)(normal, row, row + 3, row + 6);
}

/* Mean of the corners' normals. */
BS_INLINE void FN(smooth_facet_normal)(S normal[BS_LENGTH(3)], const S row[BS_LENGTH(18)], const S ray[BS_LENGTH(6)],
    const S hit[BS_LENGTH(9)])
{
  FN(cga3d_smooth_normal)(normal, ray + 3, row, row + 3, row + 6, row + 9, row + 12, row + 15, hit + 6);
}

/* Unit normal at a hit, on the side that the ray comes from. */
BS_INLINE void FN(normal_at)(S normal[BS_LENGTH(3)], ptrdiff_t kind, ptrdiff_t index, const ptrdiff_t *integers,
    const S *reals, const S ray[BS_LENGTH(6)], const S hit[BS_LENGTH(9)])
{
  S either[3] = {0};
  ptrdiff_t at;
  if (kind == 0) {
    at = integers[17] + 4 * index;
    FN(plane_normal)(either, reals + at, ray, hit);
  }
  if (kind == 1) {
    at = integers[21] + 4 * index;
    FN(sphere_normal)(either, reals + at, ray, hit);
  }
  if (kind == 2) {
    at = integers[25] + 7 * index;
    FN(disc_normal)(either, reals + at, ray, hit);
  }
  if (kind == 3) {
    at = integers[29] + 9 * index;
    FN(facet_normal)(either, reals + at, ray, hit);
  }
  if (kind == 4) {
    at = integers[33] + 18 * index;
    FN(smooth_facet_normal)(either, reals + at, ray, hit);
  }
  if (kind == 5) {
    at = integers[37] + 65 * index;
    FN(normal_evolved_circles_1)(either, reals + at, ray, hit);
  }
  if (kind == 6) {
    at = integers[41] + 111 * index;
    FN(normal_evolved_circles_2)(either, reals + at, ray, hit);
  }
  if (kind == 7) {
    at = integers[45] + 157 * index;
    FN(normal_evolved_circles_3)(either, reals + at, ray, hit);
  }
  if (kind == 8) {
    at = integers[49] + 69 * index;
    FN(normal_evolved_point_pairs_1)(either, reals + at, ray, hit);
  }
  if (kind == 9) {
    at = integers[53] + 115 * index;
    FN(normal_evolved_point_pairs_2)(either, reals + at, ray, hit);
  }
  if (kind == 10) {
    at = integers[57] + 161 * index;
    FN(normal_evolved_point_pairs_3)(either, reals + at, ray, hit);
  }
  FN(cga3d_facing)(normal, either, ray + 3);
}

/* A hit as a row of arrays. */
BS_INLINE void FN(store)(ptrdiff_t place, S distance, ptrdiff_t kind, ptrdiff_t index, const ptrdiff_t *integers,
    const S *reals, const S ray[BS_LENGTH(6)], const S hit[BS_LENGTH(9)], S *t, S *alpha, S *point, S *normal)
{
  const ptrdiff_t at = 3 * place;
  t[place] = distance;
  alpha[place] = hit[1];
  point[at] = hit[3];
  point[at + 1] = hit[4];
  point[at + 2] = hit[5];
  FN(normal_at)(normal + at, kind, index, integers, reals, ray, hit);
}

/* Add the points of the row that was asked to those of a line: by t, and by row where t is the same. */
BS_OUTLINED void FN(gather)(ptrdiff_t begin, ptrdiff_t roots, const ptrdiff_t *integers, const S *reals,
    const S ray[BS_LENGTH(6)], const S *hits, ptrdiff_t state[BS_LENGTH(10)], ptrdiff_t gathered[BS_LENGTH(2)], S *t,
    S *alpha, S *point, S *normal, int32_t *rows)
{
  const S result = FN(length)(ray + 3);
  const S size = result;
  const ptrdiff_t value = state[1];
  for (ptrdiff_t j = 0; j < value; j++) {
    const ptrdiff_t hit_at = 9 * j;
    const S distance = hits[hit_at] * size;
    const int result1 = FN(is_within)(distance, ray);
    if (!result1) {
      gathered[1] = 1;
      continue;
    }
    ptrdiff_t kept = bs_min(gathered[0], roots);
    const ptrdiff_t result2 = FN(joint_at)(begin, kept, distance, integers, reals, ray, hits + hit_at, state, t, alpha,
        rows);
    const ptrdiff_t joint = result2;
    if (joint >= 0) {
      if ((ptrdiff_t)rows[begin + joint] <= state[3]) {
        continue;
      }
      for (ptrdiff_t i = joint; i < kept - 1; i++) {
        FN(move_row)(begin + i, begin + i + 1, t, alpha, point, normal, rows);
      }
      kept = kept - 1;
      gathered[0] = gathered[0] - 1;
    }
    ptrdiff_t place = kept;
    while (place > 0) {
      const ptrdiff_t before = begin + place - 1;
      if (!((t[before] > distance) || (t[before] == distance && (ptrdiff_t)rows[before] > state[3]))) {
        break;
      }
      place = place - 1;
    }
    for (ptrdiff_t i = bs_min(kept, roots - 1); i > place; i--) {
      FN(move_row)(begin + i, begin + i - 1, t, alpha, point, normal, rows);
    }
    gathered[0] = gathered[0] + 1;
    if (place < roots) {
      rows[begin + place] = (int32_t)(state[3]);
      FN(store)(begin + place, distance, state[2], state[3], integers, reals, ray, hits + hit_at, t, alpha, point, normal);
    }
  }
  state[1] = 0;
}

/* Gather the points of a line on every row that it may meet. */
BS_INLINE void FN(find_all)(ptrdiff_t begin, ptrdiff_t roots, const ptrdiff_t scene[BS_LENGTH(16)],
    const ptrdiff_t *integers, const S *reals, const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)], S *hits,
    ptrdiff_t state[BS_LENGTH(10)], ptrdiff_t gathered[BS_LENGTH(2)], S *t, S *alpha, S *point, S *normal,
    int32_t *rows)
{
  S progress[205];
  ptrdiff_t traversal[228];
  ptrdiff_t bare = scene[10];
  while (1) {
    ptrdiff_t item = bare;
    if (bare < scene[9]) {
      bare = bare + 1;
    } else {
      if (bare == scene[9]) {
        FN(begin_tree)(scene, integers, reals, ray, search, state, progress, traversal);
        bare = bare + 1;
      }
      const ptrdiff_t result = FN(next_in_tree)(scene, integers, reals, ray, search, state, progress, traversal);
      item = result;
      if (item < 0) {
        return;
      }
    }
    FN(ask_row)(item, scene, integers, reals, ray, search, hits, state);
    if (state[1] > 0) {
      FN(gather)(begin, roots, integers, reals, ray, hits, state, gathered, t, alpha, point, normal, rows);
    }
  }
}

/* Status of a ray that has been asked: rows that begin behind its first hit have no say. */
BS_INLINE ptrdiff_t FN(search_status)(const S search[BS_LENGTH(4)])
{
  if (search[3] < search[1]) {
    return 6;
  }
  return search[2] < search[1] ? 1 : 0;
}

/* No hit. */
BS_INLINE void FN(store_none)(ptrdiff_t place, S *t, S *alpha, S *point, S *normal, int32_t *surface)
{
  surface[place] = (int32_t)(-1);
  t[place] = K(BS_NOT_A_NUMBER);
  alpha[place] = K(BS_NOT_A_NUMBER);
  point[3 * place] = K(BS_NOT_A_NUMBER);
  normal[3 * place] = K(BS_NOT_A_NUMBER);
  point[3 * place + 1] = K(BS_NOT_A_NUMBER);
  normal[3 * place + 1] = K(BS_NOT_A_NUMBER);
  point[3 * place + 2] = K(BS_NOT_A_NUMBER);
  normal[3 * place + 2] = K(BS_NOT_A_NUMBER);
}

/* All points of each ray's line on the only surface of the scene, in the order of t; also behind the origin. */
BS_OUTLINED void FN(all_hits)(ptrdiff_t begin, ptrdiff_t end, ptrdiff_t roots, const ptrdiff_t scene[BS_LENGTH(16)],
    const ptrdiff_t *integers, const S *reals, const S *origins, ptrdiff_t origin_stride, const S *directions,
    ptrdiff_t direction_stride, S *t, S *alpha, S *point, S *normal, int32_t *rows, int32_t *count, uint8_t *status)
{
  S ray[6];
  S search[4];
  ptrdiff_t state[10];
  ptrdiff_t gathered[2];
  S hits[576];
  for (ptrdiff_t i = begin; i < end; i++) {
    FN(begin_search)(scene, 64, search, state);
    gathered[0] = 0;
    gathered[1] = 0;
    const int result = FN(load_ray)(origins, origin_stride, directions, direction_stride, i, ray);
    const int is_ray = result;
    if (is_ray) {
      FN(find_all)(i * roots, roots, scene, integers, reals, ray, search, hits, state, gathered, t, alpha, point, normal,
          rows);
    }
    const ptrdiff_t total = gathered[1] == 0 ? gathered[0] : 0;
    count[i] = (int32_t)(total);
    const ptrdiff_t result1 = FN(search_status)(search);
    const ptrdiff_t said = result1;
    status[i] = (uint8_t)(is_ray && gathered[1] == 0 ? said : 6);
    for (ptrdiff_t j = total; j < roots; j++) {
      FN(store_none)(i * roots + j, t, alpha, point, normal, rows);
    }
  }
}

/* Direction of the ray through a point of the image plane, in pixels from the left and from the top. */
BS_INLINE void FN(pixel_ray)(S direction[BS_LENGTH(3)], const S camera[BS_LENGTH(11)],
    const ptrdiff_t picture[BS_LENGTH(8)], S x, S y)
{
  const S right = K(2.0) * x / (S)(picture[0]) - K(1.0);
  const S up = K(1.0) - K(2.0) * y / (S)(picture[1]);
  S row[2];
  row[0] = right;
  row[1] = up;
  FN(cga3d_camera_direction)(direction, camera, camera + 8, row);
}

/* Ask every row that the ray may meet; where any hit will do, until there is one. */
BS_OUTLINED void FN(find_false)(const ptrdiff_t scene[BS_LENGTH(16)], const ptrdiff_t *integers, const S *reals,
    const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)])
{
  const ptrdiff_t value = scene[9];
  for (ptrdiff_t item = scene[10]; item < value; item++) {
    FN(ask_row)(item, scene, integers, reals, ray, search, hits, state);
  }
  S progress[205];
  ptrdiff_t traversal[228];
  FN(begin_tree)(scene, integers, reals, ray, search, state, progress, traversal);
  while (1) {
    const ptrdiff_t result = FN(next_in_tree)(scene, integers, reals, ray, search, state, progress, traversal);
    const ptrdiff_t row = result;
    if (row < 0) {
      return;
    }
    FN(ask_row)(row, scene, integers, reals, ray, search, hits, state);
  }
}

/* Size of the numbers that a hit was made of: its errors are relative to it. */
BS_INLINE S FN(size_of_hit)(const S ray[BS_LENGTH(6)], const S hit[BS_LENGTH(9)])
{
  S size = K(0.0);
  for (ptrdiff_t i = 0; i < 3; i++) {
    size = size + (ABS(ray[i]) + ABS(hit[3 + i]) + ABS(hit[0] * ray[3 + i]));
  }
  return size;
}

/* The same, with the numbers of the surface. */
BS_OUTLINED S FN(extent_of_hit)(const ptrdiff_t *integers, const S *reals, const S ray[BS_LENGTH(6)],
    const S hit[BS_LENGTH(9)], const ptrdiff_t state[BS_LENGTH(10)])
{
  const ptrdiff_t box = integers[16 + 4 * state[4] + 2] + 6 * state[5];
  const S result = FN(size_of_hit)(ray, hit);
  S size = result;
  for (ptrdiff_t i = 0; i < 6; i++) {
    const S side = ABS(reals[box + i]);
    size = size + (side <= K(BS_GREATEST) ? side : K(0.0));
  }
  return size;
}

/* Find what a camera sees along a ray, but for what it stands on. */
BS_OUTLINED void FN(find_seen)(const ptrdiff_t scene[BS_LENGTH(16)], const ptrdiff_t *integers, const S *reals,
    const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)], S *hit, ptrdiff_t state[BS_LENGTH(10)])
{
  const S least = K(BS_EPSILON) > K(1e-10) ? K(1.52587890625e-05) : K(7.275957614183426e-12);
  const S result = FN(distance_of_origin)(ray);
  const S near = K(8.0) * least * (result + reals[0]);
  FN(begin_search)(scene, 1, search, state);
  FN(find_false)(scene, integers, reals, ray, search, hit, state);
  while (state[1] > 0 && hit[0] <= near) {
    const S result1 = FN(extent_of_hit)(integers, reals, ray, hit, state);
    const S extent = result1;
    const S result2 = FN(length)(ray + 3);
    const S begin = least * extent / result2;
    if (!(hit[0] <= begin)) {
      return;
    }
    const ptrdiff_t cost = state[9];
    FN(begin_search)(scene, 1, search, state);
    search[0] = begin;
    state[9] = cost;
    FN(find_false)(scene, integers, reals, ray, search, hit, state);
  }
}

/* What the ray through the middle of a pixel meets. Nothing is infinitely far away, and has no normal. */
BS_INLINE void FN(store_layers)(ptrdiff_t place, const ptrdiff_t scene[BS_LENGTH(16)], const ptrdiff_t *integers,
    const S *reals, const ptrdiff_t picture[BS_LENGTH(8)], const S ray[BS_LENGTH(6)], S *normal, S *depth, S *alpha,
    int32_t *cost)
{
  S search[4];
  ptrdiff_t state[10];
  S hit[9] = {0};
  FN(find_seen)(scene, integers, reals, ray, search, hit, state);
  const int is_hit = state[1] > 0;
  if (picture[7] != 0) {
    cost[place] = (int32_t)(state[9]);
  }
  if (picture[5] != 0) {
    const S result = FN(length)(ray + 3);
    const S distance = hit[0] * result;
    depth[place] = is_hit ? distance : K(BS_HUGE_VALUE);
  }
  if (picture[6] != 0) {
    alpha[place] = is_hit ? hit[1] : K(BS_NOT_A_NUMBER);
  }
  if (picture[4] != 0) {
    const ptrdiff_t at = 3 * place;
    for (ptrdiff_t i = 0; i < 3; i++) {
      normal[at + i] = K(BS_NOT_A_NUMBER);
    }
    if (is_hit) {
      FN(normal_at)(normal + at, state[4], state[5], integers, reals, ray, hit);
    }
  }
}

/* Add the color of the sky. */
BS_INLINE void FN(add_sky)(S seen[BS_LENGTH(3)], S weight, const S sky[BS_LENGTH(6)], const S direction[BS_LENGTH(3)])
{
  const S up = direction[2] > K(0.0) ? direction[2] : K(0.0);
  for (ptrdiff_t i = 0; i < 3; i++) {
    seen[i] = seen[i] + weight * ((K(1.0) - up) * sky[i] + up * sky[3 + i]);
  }
}

/* The next integer below. */
BS_INLINE S FN(floor_of)(S x)
{
  if (!(ABS(x) < K(4503599627370496.0))) {
    return x;
  }
  const S cut = (S)((ptrdiff_t)(x));
  return cut > x ? cut - K(1.0) : cut;
}

/* The color of a surface at a point. */
BS_INLINE void FN(color_at)(S color[BS_LENGTH(3)], const S material[BS_LENGTH(17)], const S point[BS_LENGTH(3)],
    int is_checkered)
{
  for (ptrdiff_t k = 0; k < 3; k++) {
    color[k] = material[k];
  }
  if (is_checkered) {
    const S u = material[11] * point[0] + material[12] * point[1] + material[13] * point[2];
    const S v = material[14] * point[0] + material[15] * point[1] + material[16] * point[2];
    const S result = FN(floor_of)(u);
    const S result1 = FN(floor_of)(v);
    const S half = K(0.5) * (result + result1);
    const S result2 = FN(floor_of)(half);
    if (half != result2) {
      for (ptrdiff_t k1 = 0; k1 < 3; k1++) {
        color[k1] = material[8 + k1];
      }
    }
  }
}

/* Ask every row that the ray may meet; where any hit will do, until there is one. */
BS_OUTLINED void FN(find_true)(const ptrdiff_t scene[BS_LENGTH(16)], const ptrdiff_t *integers, const S *reals,
    const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)])
{
  const ptrdiff_t value = scene[9];
  for (ptrdiff_t item = scene[10]; item < value; item++) {
    if (state[1] > 0) {
      return;
    }
    FN(ask_row)(item, scene, integers, reals, ray, search, hits, state);
  }
  if (state[1] > 0) {
    return;
  }
  S progress[205];
  ptrdiff_t traversal[228];
  FN(begin_tree)(scene, integers, reals, ray, search, state, progress, traversal);
  while (1) {
    const ptrdiff_t result = FN(next_in_tree)(scene, integers, reals, ray, search, state, progress, traversal);
    const ptrdiff_t row = result;
    if (row < 0) {
      return;
    }
    FN(ask_row)(row, scene, integers, reals, ray, search, hits, state);
    if (state[1] > 0) {
      return;
    }
  }
}

/* Whether a lamp sees a point. */
BS_INLINE int FN(is_lit)(S seen[BS_LENGTH(3)], const ptrdiff_t scene[BS_LENGTH(16)], const ptrdiff_t *integers,
    const S *reals, const S lamp[BS_LENGTH(6)], const S start[BS_LENGTH(3)], const S towards[BS_LENGTH(3)])
{
  (void)seen;
  S size = K(0.0);
  for (ptrdiff_t i = 0; i < 3; i++) {
    size = size + (ABS(start[i]) + ABS(lamp[i]));
  }
  const S margin = (K(BS_EPSILON) > K(1e-10) ? K(0.000244140625) : K(7.275957614183426e-12)) * size;
  const S result = FN(length)(towards);
  const S distance = result;
  if (!(distance > margin)) {
    return 1;
  }
  S shadow[6];
  S search[4];
  ptrdiff_t state[10];
  S hit[9];
  for (ptrdiff_t k = 0; k < 3; k++) {
    shadow[k] = start[k];
  }
  for (ptrdiff_t i = 0; i < 3; i++) {
    shadow[3 + i] = (K(1.0) - margin / distance) * towards[i];
  }
  FN(begin_search)(scene, 1, search, state);
  search[1] = K(1.0);
  FN(find_true)(scene, integers, reals, shadow, search, hit, state);
  const int found = state[1] == 0;
  return found;
}

/* Add the light that a surface sends back along a ray, without its reflection (Blinn and Phong). */
BS_INLINE void FN(add_light)(S seen[BS_LENGTH(3)], S weight, const ptrdiff_t scene[BS_LENGTH(16)],
    const ptrdiff_t *integers, const S *reals, const S material[BS_LENGTH(17)], const S direction[BS_LENGTH(3)],
    const S start[BS_LENGTH(3)], const S normal[BS_LENGTH(3)])
{
  S color[3];
  S light[3];
  FN(color_at)(color, material, start, 1);
  for (ptrdiff_t i = 0; i < 3; i++) {
    light[i] = material[3] * color[i];
  }
  const ptrdiff_t value = scene[0];
  for (ptrdiff_t number = 0; number < value; number++) {
    const ptrdiff_t at = scene[6] + 6 * number;
    const ptrdiff_t lamp_at = at;
    S row[1];
    row[0] = material[6];
    S towards[3];
    S factors[2];
    FN(cga3d_light_terms)(towards, factors, start, normal, direction, reals + lamp_at, row);
    if (!(factors[0] > K(0.0))) {
      continue;
    }
    const int result = FN(is_lit)(seen, scene, integers, reals, reals + lamp_at, start, towards);
    const int lit = result;
    if (!lit) {
      continue;
    }
    for (ptrdiff_t i = 0; i < 3; i++) {
      light[i] = light[i] + reals[lamp_at + (3 + i)] * (material[4] * factors[0] * color[i] + material[5] * factors[1]);
    }
  }
  for (ptrdiff_t i = 0; i < 3; i++) {
    seen[i] = seen[i] + weight * light[i];
  }
}

/* Add the color seen along a ray of unit direction; reflections are followed one after the other. */
BS_OUTLINED void FN(add_color)(S seen[BS_LENGTH(3)], const ptrdiff_t scene[BS_LENGTH(16)], const ptrdiff_t *integers,
    const S *reals, S ray[BS_LENGTH(6)])
{
  S weight = K(1.0);
  ptrdiff_t bounce = 0;
  S search[4];
  ptrdiff_t state[10];
  S hit[9] = {0};
  S normal[3];
  S start[3];
  while (1) {
    if (bounce > 0) {
      FN(begin_search)(scene, 1, search, state);
      FN(find_false)(scene, integers, reals, ray, search, hit, state);
    } else {
      FN(find_seen)(scene, integers, reals, ray, search, hit, state);
    }
    if (state[1] == 0) {
      FN(add_sky)(seen, weight, reals + scene[8], ray + 3);
      return;
    }
    const ptrdiff_t ids = integers[16 + 4 * state[4] + 3];
    const ptrdiff_t at = scene[5] + 17 * integers[ids + state[5]];
    const ptrdiff_t material_at = at;
    const S mirror = bounce < scene[1] ? reals[at + 7] : K(0.0);
    const S result = FN(size_of_hit)(ray, hit);
    const S offset = (K(BS_EPSILON) > K(1e-10) ? K(0.000244140625) : K(7.275957614183426e-12)) * result;
    FN(normal_at)(normal, state[4], state[5], integers, reals, ray, hit);
    for (ptrdiff_t i = 0; i < 3; i++) {
      start[i] = hit[3 + i] + offset * normal[i];
    }
    if (mirror < K(1.0)) {
      const S share = weight * (K(1.0) - mirror);
      FN(add_light)(seen, share, scene, integers, reals, reals + material_at, ray + 3, start, normal);
    }
    if (!(mirror > K(0.0))) {
      return;
    }
    S onward[3];
    FN(cga3d_reflected_direction)(onward, ray + 3, normal);
    for (ptrdiff_t k = 0; k < 3; k++) {
      ray[k] = start[k];
    }
    for (ptrdiff_t k1 = 0; k1 < 3; k1++) {
      ray[3 + k1] = onward[k1];
    }
    weight = weight * mirror;
    bounce = bounce + 1;
  }
}

/* The color of a pixel: the mean of its rays'. */
BS_INLINE void FN(color_of)(S total[BS_LENGTH(3)], S column, S line, const S origin[BS_LENGTH(3)],
    const ptrdiff_t scene[BS_LENGTH(16)], const ptrdiff_t *integers, const S *reals,
    const ptrdiff_t picture[BS_LENGTH(8)])
{
  S ray[6];
  S seen[3];
  const ptrdiff_t grid = scene[2];
  const S share = K(1.0) / (S)(grid * grid);
  for (ptrdiff_t k = 0; k < 3; k++) {
    total[k] = K(0.0);
  }
  for (ptrdiff_t down = 0; down < grid; down++) {
    const S y = line + ((S)(down) + K(0.5)) / (S)(grid);
    for (ptrdiff_t right = 0; right < grid; right++) {
      const S x = column + ((S)(right) + K(0.5)) / (S)(grid);
      for (ptrdiff_t k1 = 0; k1 < 3; k1++) {
        ray[k1] = origin[k1];
      }
      FN(pixel_ray)(ray + 3, reals + scene[7], picture, x, y);
      for (ptrdiff_t k2 = 0; k2 < 3; k2++) {
        seen[k2] = K(0.0);
      }
      FN(add_color)(seen, scene, integers, reals, ray);
      for (ptrdiff_t i = 0; i < 3; i++) {
        total[i] = total[i] + share * seen[i];
      }
    }
  }
}

/* Pixels from one to another, in reading order: row 0 is the top. */
BS_OUTLINED void FN(render)(ptrdiff_t begin, ptrdiff_t end, const ptrdiff_t scene[BS_LENGTH(16)],
    const ptrdiff_t *integers, const S *reals, const ptrdiff_t picture[BS_LENGTH(8)], S *color, S *normal, S *depth,
    S *alpha, int32_t *cost)
{
  S total[3];
  const ptrdiff_t camera_at = scene[7];
  const ptrdiff_t camera_at1 = camera_at;
  S origin[3];
  FN(cga3d_camera_position)(origin, reals + camera_at1);
  ptrdiff_t column = bs_remainder(begin, picture[0]) - 1;
  ptrdiff_t line = bs_quotient(begin, picture[0]);
  for (ptrdiff_t pixel = begin; pixel < end; pixel++) {
    column = column + 1;
    if (column == picture[0]) {
      column = 0;
      line = line + 1;
    }
    const ptrdiff_t place = pixel - picture[2];
    S ray[6];
    for (ptrdiff_t k = 0; k < 3; k++) {
      ray[k] = origin[k];
    }
    FN(pixel_ray)(ray + 3, reals + camera_at1, picture, (S)(column) + K(0.5), (S)(line) + K(0.5));
    FN(store_layers)(place, scene, integers, reals, picture, ray, normal, depth, alpha, cost);
    if ((picture[3] == 1) || (picture[3] == 2 && color[3 * place] != color[3 * place])) {
      FN(color_of)(total, (S)(column), (S)(line), origin, scene, integers, reals, picture);
      for (ptrdiff_t i = 0; i < 3; i++) {
        color[3 * place + i] = total[i];
      }
    }
  }
}

/* What a ray has found. A hit that is too far away for a number is none, and the ray is not valid. */
BS_INLINE void FN(store_first)(ptrdiff_t i, int is_ray, const ptrdiff_t *integers, const S *reals,
    const S ray[BS_LENGTH(6)], const S search[BS_LENGTH(4)], const S hit[BS_LENGTH(9)],
    const ptrdiff_t state[BS_LENGTH(10)], S *t, S *alpha, S *point, S *normal, int32_t *surface, uint8_t *status)
{
  ptrdiff_t found = 0;
  S distance = K(0.0);
  if (state[1] > 0) {
    const S result = FN(length)(ray + 3);
    distance = hit[0] * result;
    const int result1 = FN(is_within)(distance, ray);
    if (result1) {
      found = 1;
    }
  }
  const ptrdiff_t result2 = FN(search_status)(search);
  const ptrdiff_t said = result2;
  status[i] = (uint8_t)(is_ray && found == state[1] ? said : 6);
  if (found > 0) {
    const ptrdiff_t ids = integers[16 + 4 * state[4] + 3];
    surface[i] = (int32_t)(integers[ids + state[5]]);
    FN(store)(i, distance, state[4], state[5], integers, reals, ray, hit, t, alpha, point, normal);
  } else {
    FN(store_none)(i, t, alpha, point, normal, surface);
  }
}
