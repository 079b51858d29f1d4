/* bladesmith: a tree of boxes over the landmarks of objects, and the least cost that a landmark leaves possible.
 *
 * R takes X1 to X2 (or to -X2) along the shortest way: R X1 = X2 R, R^2 = P = +-X2 X1^-1. |A| is the norm of the
 * coefficients on the orthonormal basis, in which |A B| <= 2 |A| |B| (twice as large is the norm of the 4 x 4 matrix
 * that A stands for, and that is no less than the operator's norm). The cost is |R - 1|^2 + |R . e_+|^2.
 *
 * Flats and points. R is a screw: an angle t about an axis a at the distance q from the origin, a shift d along it.
 * The cost is 4 sin^2(t/4) + 3 (q^2 sin^2(t/2) + d^2/4), for what has n_inf as a factor counts three times. The
 * directions differ by 2 sin(t/2) <= 4 sin(t/4). The points p of both objects next to the origin, projected along a,
 * lie on the circle of diameter q from the origin to the axis (Thales), and see the angle t: they differ by
 * q sin t <= 2 q sin(t/2) across a and by d along it. Hence
 *     cost >= |m2 - m1|^2/4 + 3 |p2 - p1|^2/4,
 * with equality for translations, and nearly so for small angles. For points R is the translator.
 *
 * Rounds. Give n0 the weight -1 and n_inf +1; products add weights, and translations only raise them, so the part of
 * least weight of P - 1 does not change if both objects are moved. With the first centred at the origin,
 * X1 = (n0 + r^2/2 n_inf) ^ A1, that part is n0 times a product of A1, A2 and the difference of the centres, of the
 * norm |c2 - c1|/(sqrt(2) r1 r2). Of a round and a flat it is 1/(sqrt(2) r). The inversion in the unit sphere keeps
 * all norms, so the same holds of centres and radii of the inverses. P - 1 = (R - 1)(2 + (R - 1)) gives
 *     |P - 1| <= 2 d + 2 d^2,  d = |R - 1|, so  cost >= d^2 >= ((sqrt(1 + 2 |P - 1|) - 1)/2)^2.
 * That leaves out how rounds are turned. For all: X2 - X1 = (R - 1) X1 - X2 (R - 1), and so
 *     cost >= (|X2 - X1|/(N1 + N2))^2,  N the operator's norm: N^2 = |X|^2 + sqrt(|X|^4 - 1) for a unit blade, which
 * is a unit blade of Euclidean vectors times a single vector with a part along e_-, or the dual of such a one.
 */

enum {                   /* a landmark: position (3), then */
  BS_DIRECTION = 3,
  BS_CURVATURE = 6,
  BS_FLAT_MARKS = 7,     /* that is all of flats and points; of rounds, and flats among them: */
  BS_INVERSE = 7,        /* position (3) and curvature of the inverse */
  BS_INVERSE_CURVATURE = 10,
  BS_NORM = 11,          /* N */
  BS_ROUND_MARKS = 12,   /* and then the coefficients on the orthonormal basis */
  BS_ROW_MOST = 16,      /* coefficients of any kind of object */
  BS_LEAF = 12,          /* objects of a leaf, at most */
  BS_DEEPEST = 40,       /* levels of any tree */
  BS_REBUILD = 4         /* the tree is built anew when this share of its objects is left */
};

static const double BS_OF_POSITION = 0.75, BS_OF_DIRECTION = 0.25; /* weights of squares in the cost, see above */
static const double BS_SURELY = 1.0 - 1e-9; /* bounds and costs are rounded */
static const double BS_NOISE = 64 * 2.220446049250313e-16; /* and coefficients and landmarks, relative to their size */
static const double BS_RADII = 8.0; /* rounds whose radii differ more are parted by radius before place */

static inline int marks_of(const bs_kind *kind)
{
  return kind->marks == BS_FLAT_MARKS ? kind->marks : BS_ROUND_MARKS + kind->size;
}

static inline const double *row_of(const bs_merge *s, int32_t slot)
{
  return s->rows + (ptrdiff_t)bs_kinds[s->kind].size * slot;
}

static inline double *landmark_of(const bs_merge *s, int32_t slot)
{
  return s->landmarks + (ptrdiff_t)s->marks * slot;
}

static inline double *box_of(const bs_merge *s, ptrdiff_t node)
{
  return s->boxes + 2 * (ptrdiff_t)s->marks * node;
}

/* Note where an object is. */
static void mark(const bs_merge *s, int32_t slot)
{
  const bs_kind *kind = &bs_kinds[s->kind];
  const double *row = row_of(s, slot);
  double *x = landmark_of(s, slot), square = 0;
  kind->landmark(x, row);
  if (s->marks == BS_FLAT_MARKS) return;
  for (int i = 0; i < kind->size; i++) {
    const double coefficient = sqrt(kind->squares[i]) * row[i];
    x[BS_ROUND_MARKS + i] = coefficient;
    square += coefficient * coefficient;
  }
  const double excess = square * square - 1;
  x[BS_NORM] = sqrt(square + (excess > 0 ? sqrt(excess) : 0));
}

/* How far x is outside an interval. */
static inline double gap(double x, double least, double most)
{
  const double below = least - x, above = x - most;
  const double outside = below > above ? below : above;
  return outside > 0 ? outside : 0;
}

/* Square of the distance of sign * x from a box, of so many numbers each. */
static inline double gap_squared(const double *x, double sign, const double *least, const double *most, int count)
{
  double total = 0;
  for (int i = 0; i < count; i++) {
    const double g = gap(sign * x[i], least[i], most[i]);
    total += g * g;
  }
  return total;
}

/* The same for whichever of x and -x is nearer. */
static inline double gap_of_axis(const double *x, const double *least, const double *most, int count)
{
  const double same = gap_squared(x, 1, least, most, count), turned = gap_squared(x, -1, least, most, count);
  return same < turned ? same : turned;
}

static inline double positive(double x) { return x > 0 ? x : 0; }

/* No object with a landmark between these can have a lower cost with the object of landmark x, if both are flat. */
static double least_flat_cost(const bs_merge *s, const double *x, const double *least, const double *most)
{
  const double distance = positive(sqrt(gap_squared(x, 1, least, most, 3)) - s->slack);
  const double directions = gap_of_axis(x + BS_DIRECTION, least + BS_DIRECTION, most + BS_DIRECTION, 3);
  return BS_OF_POSITION * distance * distance + BS_OF_DIRECTION * directions;
}

/* The same if not all are, or of kinds of rounds. */
static double least_round_cost(const bs_merge *s, const double *x, const double *least, const double *most)
{
  const double own = x[BS_CURVATURE], flattest = least[BS_CURVATURE], roundest = most[BS_CURVATURE];
  const double norms = x[BS_NORM] * most[BS_NORM];
  double defect;
  if (own > 0 && flattest > 0)
    defect = sqrt(gap_squared(x, 1, least, most, 3)) * own * flattest;
  else if (own == 0)
    defect = flattest;
  else
    defect = roundest == 0 ? own : 0;
  const double product = x[BS_INVERSE_CURVATURE] * least[BS_INVERSE_CURVATURE];
  if (product > 0) {
    const double inverse = product * sqrt(gap_squared(x + BS_INVERSE, 1, least + BS_INVERSE, most + BS_INVERSE, 3));
    if (inverse > defect) defect = inverse;
  }
  defect = positive(sqrt(0.5) * defect - BS_NOISE * norms);
  const double by_place = (sqrt(1 + 2 * defect) - 1) / 2;
  const double apart = sqrt(gap_of_axis(x + BS_ROUND_MARKS, least + BS_ROUND_MARKS, most + BS_ROUND_MARKS,
                                        s->marks - BS_ROUND_MARKS));
  const double by_coefficients = positive(apart / (x[BS_NORM] + most[BS_NORM]) - BS_NOISE);
  const double d = by_place > by_coefficients ? by_place : by_coefficients;
  return d * d;
}

/* A cost of this object that may be all rounding: of a motor at its distance, of products of its coefficients. */
static inline double no_cost(const bs_merge *s, const double *x)
{
  double size = 1 + x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
  if (s->marks > BS_FLAT_MARKS && x[BS_NORM] > 1) size = x[BS_NORM] * x[BS_NORM] * x[BS_NORM] * x[BS_NORM];
  return BS_NOISE * BS_NOISE * size;
}

static inline double least_cost(const bs_merge *s, const double *x, const double *least, const double *most)
{
  if (x[BS_CURVATURE] == 0 && most[BS_CURVATURE] == 0) return BS_SURELY * least_flat_cost(s, x, least, most);
  return BS_SURELY * least_round_cost(s, x, least, most);
}

/* -- building --------------------------------------------------------------------------------------------- */

static inline ptrdiff_t part(ptrdiff_t built, ptrdiff_t index, int level)
{
  return (ptrdiff_t)(((int64_t)built * index) >> level);
}

static void fill_box(const bs_merge *s, double *box, ptrdiff_t begin, ptrdiff_t end)
{
  const int marks = s->marks;
  for (int i = 0; i < marks; i++) box[i] = BS_HUGE_VALUE, box[i + marks] = -BS_HUGE_VALUE;
  for (ptrdiff_t p = begin; p < end; p++) {
    if (s->order[p] < 0) continue;
    const double *x = s->leaves + (ptrdiff_t)marks * p;
    for (int i = 0; i < marks; i++) {
      if (x[i] < box[i]) box[i] = x[i];
      if (x[i] > box[i + marks]) box[i + marks] = x[i];
    }
  }
}

/* The widest of some landmarks, if its width in units of the cost's root is more than that of the best so far. */
static void widest_of(const bs_merge *s, const double *box, int begin, int end, double unit, int *best, double *width)
{
  for (int i = begin; i < end; i++) {
    const double w = unit * (box[i + s->marks] - box[i]);
    if (w > *width) *width = w, *best = i;
  }
}

/* The landmark by which to part the objects of a box. */
static int widest(const bs_merge *s, const double *box)
{
  const double *most = box + s->marks;
  if (most[BS_CURVATURE] > BS_RADII * box[BS_CURVATURE]) return BS_CURVATURE;
  int best = 0;
  double width = 0;
  if (most[BS_CURVATURE] == 0) {
    widest_of(s, box, 0, BS_DIRECTION, sqrt(BS_OF_POSITION), &best, &width);
    widest_of(s, box, BS_DIRECTION, BS_CURVATURE, sqrt(BS_OF_DIRECTION), &best, &width);
    return best;
  }
  const double curved = box[BS_CURVATURE] * most[BS_CURVATURE];
  const double inverse = box[BS_INVERSE_CURVATURE] * most[BS_INVERSE_CURVATURE];
  widest_of(s, box, 0, BS_DIRECTION, sqrt(0.125) * curved, &best, &width);
  widest_of(s, box, BS_INVERSE, BS_INVERSE_CURVATURE, sqrt(0.125) * inverse, &best, &width);
  widest_of(s, box, BS_ROUND_MARKS, s->marks, 0.5 / most[BS_NORM], &best, &width);
  return best;
}

static inline int comes_before(const bs_merge *s, int axis, int32_t a, int32_t b)
{
  const double x = landmark_of(s, a)[axis], y = landmark_of(s, b)[axis];
  return x < y || (x == y && a < b);
}

/* Part order[begin, end) so that what comes before the middle stands before it: quickselect. */
static void select_middle(const bs_merge *s, int axis, ptrdiff_t begin, ptrdiff_t end, ptrdiff_t middle)
{
  int32_t *order = s->order;
  ptrdiff_t low = begin, high = end - 1;
  while (low < high) {
    const int32_t pivot = order[low + (high - low) / 2];
    ptrdiff_t i = low, j = high;
    while (i <= j) {
      while (comes_before(s, axis, order[i], pivot)) i++;
      while (comes_before(s, axis, pivot, order[j])) j--;
      if (i <= j) {
        const int32_t other = order[i];
        order[i++] = order[j];
        order[j--] = other;
      }
    }
    if (middle <= j)
      high = j;
    else if (middle >= i)
      low = i;
    else
      return;
  }
}

static inline void settle_in_leaf(bs_merge *s, int32_t slot, ptrdiff_t place)
{
  const double *x = landmark_of(s, slot);
  double *copy = s->leaves + (ptrdiff_t)s->marks * place;
  s->tree_place[slot] = (int32_t)place;
  for (int i = 0; i < s->marks; i++) copy[i] = x[i];
}

static void build_node(bs_merge *s, ptrdiff_t index, int level)
{
  const ptrdiff_t node = ((ptrdiff_t)1 << level) + index;
  const ptrdiff_t begin = part(s->built, index, level), end = part(s->built, index + 1, level);
  double *box = box_of(s, node);
  for (ptrdiff_t p = begin; p < end; p++) settle_in_leaf(s, s->order[p], p);
  fill_box(s, box, begin, end);
  s->alive[node] = (int32_t)(end - begin);
  if (level == s->levels) return;
  select_middle(s, widest(s, box), begin, end, part(s->built, 2 * index + 1, level + 1));
  build_node(s, 2 * index, level + 1);
  build_node(s, 2 * index + 1, level + 1);
}

/* The tree over all objects that are left. */
static void build_tree(bs_merge *s)
{
  s->built = 0;
  double size = 0;
  for (ptrdiff_t slot = 0; slot < s->count; slot++) {
    if (s->versions[slot] < 0) continue;
    s->order[s->built++] = (int32_t)slot;
    for (int i = 0; i < BS_DIRECTION; i++) {
      const double x = fabs(landmark_of(s, (int32_t)slot)[i]);
      if (x > size) size = x;
    }
  }
  s->slack = BS_NOISE * size;
  s->levels = 0;
  while ((s->built >> s->levels) > BS_LEAF) s->levels++;
  build_node(s, 0, 0);
}

/* -- keeping it up ---------------------------------------------------------------------------------------- */

/* The leaf that an object is in. */
static ptrdiff_t leaf_of(const bs_merge *s, int32_t slot)
{
  const ptrdiff_t place = s->tree_place[slot];
  ptrdiff_t index = 0;
  for (int level = 0; level < s->levels; level++)
    index = 2 * index + (place >= part(s->built, 2 * index + 1, level + 1));
  return index;
}

/* An object has moved, or gone (-1): its boxes are drawn anew, from the leaf to the root. */
static void refit(bs_merge *s, int32_t slot, int change)
{
  const ptrdiff_t index = leaf_of(s, slot), place = s->tree_place[slot];
  if (change < 0)
    s->order[place] = -1;
  else
    settle_in_leaf(s, slot, place);
  ptrdiff_t node = ((ptrdiff_t)1 << s->levels) + index;
  fill_box(s, box_of(s, node), part(s->built, index, s->levels), part(s->built, index + 1, s->levels));
  s->alive[node] += change;
  for (node >>= 1; node > 0; node >>= 1) {
    double *box = box_of(s, node);
    const double *one = box_of(s, 2 * node), *other = box_of(s, 2 * node + 1);
    s->alive[node] += change;
    for (int i = 0; i < s->marks; i++) {
      const int j = i + s->marks;
      box[i] = one[i] < other[i] ? one[i] : other[i]; /* empty boxes are +inf, -inf */
      box[j] = one[j] > other[j] ? one[j] : other[j];
    }
  }
}
