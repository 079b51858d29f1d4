/* bladesmith: the tree over boxes, made once for a scene. Items are parted where the surface area heuristic expects the
   least work of rays; far down, and where all centres are one, in halves. The four parts of a node come of three such
   cuts, the largest part being cut first. */

enum {
  BS_BINS = 16,                 /* places along an axis where items may be parted */
  BS_HEURISTIC_LEVELS = 28,     /* below, parts are quarters: no tree of 2^31 items is deeper than BS_TREE_LEVELS */
  BS_RANGES_WAITING = BS_TREE_LEVELS * (BS_PARTS - 1) + 1
};

typedef struct { ptrdiff_t begin, end; double box[6]; } bs_range;
typedef struct { bs_range range; ptrdiff_t node; int level; } bs_unbuilt;
typedef struct { const double *boxes; int32_t *order; } bs_build;

static void bs_empty(double *box)
{
  for (int i = 0; i < 3; i++) box[i] = BS_HUGE_VALUE, box[3 + i] = -BS_HUGE_VALUE;
}

static void bs_enlarge(double *box, const double *by)
{
  for (int i = 0; i < 3; i++) {
    if (by[i] < box[i]) box[i] = by[i];
    if (by[3 + i] > box[3 + i]) box[3 + i] = by[3 + i];
  }
}

static double bs_area(const double *box)
{
  const double x = box[3] - box[0], y = box[4] - box[1], z = box[5] - box[2];
  return x * y + y * z + z * x;
}

static double bs_center(const double *box, int axis)
{
  return 0.5 * box[axis] + 0.5 * box[3 + axis];
}

/* The box of a range, and that of its items' centres. */
static void bs_measure(const bs_build *build, bs_range *range, double *centers)
{
  bs_empty(range->box), bs_empty(centers);
  for (ptrdiff_t p = range->begin; p < range->end; p++) {
    const double *const box = build->boxes + 6 * (ptrdiff_t)build->order[p];
    bs_enlarge(range->box, box);
    for (int i = 0; i < 3; i++) {
      const double c = bs_center(box, i);
      if (c < centers[i]) centers[i] = c;
      if (c > centers[3 + i]) centers[3 + i] = c;
    }
  }
}

static int bs_bin(const double *box, int axis, double start, double scale)
{
  const int bin = (int)((bs_center(box, axis) - start) * scale);
  return bin < 0 ? 0 : bin < BS_BINS ? bin : BS_BINS - 1;
}

/* The bin before which the least is expected if items are parted there; 0 where nothing can be told. */
static int bs_best_cut(const bs_build *build, const bs_range *range, int axis, double start, double scale)
{
  double bins[BS_BINS][6], right[BS_BINS], box[6], least = BS_HUGE_VALUE;
  ptrdiff_t counts[BS_BINS], count = 0;
  int best = 0;
  for (int b = 0; b < BS_BINS; b++) counts[b] = 0, bs_empty(bins[b]);
  for (ptrdiff_t p = range->begin; p < range->end; p++) {
    const double *const item = build->boxes + 6 * (ptrdiff_t)build->order[p];
    const int bin = bs_bin(item, axis, start, scale);
    counts[bin]++;
    bs_enlarge(bins[bin], item);
  }
  bs_empty(box);
  for (int b = BS_BINS - 1; b > 0; b--) {
    bs_enlarge(box, bins[b]);
    count += counts[b];
    right[b] = count ? (double)count * bs_area(box) : BS_HUGE_VALUE;
  }
  bs_empty(box);
  count = 0;
  for (int b = 1; b < BS_BINS; b++) {
    bs_enlarge(box, bins[b - 1]);
    count += counts[b - 1];
    const double cost = count ? (double)count * bs_area(box) + right[b] : BS_HUGE_VALUE;
    if (cost < least) least = cost, best = b;
  }
  return best;
}

/* Part a range in two; both have items. */
static void bs_cut(const bs_build *build, const bs_range *range, int halves, bs_range *low, bs_range *high)
{
  int32_t *const order = build->order;
  ptrdiff_t middle = range->begin + (range->end - range->begin) / 2;
  double centers[6];
  *low = *range;
  bs_measure(build, low, centers);
  int axis = 0;
  for (int i = 1; i < 3; i++)
    if (centers[3 + i] - centers[i] > centers[3 + axis] - centers[axis]) axis = i;
  const double start = centers[axis], scale = BS_BINS / (centers[3 + axis] - start);
  if (!halves && scale > 0 && scale < BS_HUGE_VALUE) {
    const int cut = bs_best_cut(build, range, axis, start, scale);
    ptrdiff_t i = range->begin, j = range->end - 1;
    while (cut && i <= j) {
      const int32_t item = order[i];
      if (bs_bin(build->boxes + 6 * (ptrdiff_t)item, axis, start, scale) < cut) {
        i++;
      } else {
        order[i] = order[j];
        order[j--] = item;
      }
    }
    if (cut) middle = i;
  }
  low->begin = range->begin, low->end = middle;
  high->begin = middle, high->end = range->end;
  bs_measure(build, low, centers);
  bs_measure(build, high, centers);
}

/* Up to four parts of a range; their number. */
static int bs_part(const bs_build *build, const bs_range *range, int halves, bs_range *parts)
{
  int count = 1;
  parts[0] = *range;
  while (count < BS_PARTS) {
    int chosen = -1;
    double most = -1;
    for (int i = 0; i < count; i++) {
      const double items = (double)(parts[i].end - parts[i].begin), area = halves ? 1 : bs_area(parts[i].box);
      const double size = area < BS_HUGE_VALUE ? items * area : items;
      if (items > 1 && size > most) most = size, chosen = i;
    }
    if (chosen < 0) break;
    const bs_range whole = parts[chosen];
    bs_cut(build, &whole, halves, &parts[chosen], &parts[count++]);
  }
  return count;
}

/* The tree over boxes (rows: low, high), nodes in the order in which they were made, their root first. There must be
   room for as many nodes as there are boxes. `order` is room for the builder. Returns the number of nodes. */
static ptrdiff_t bs_build_tree(ptrdiff_t count, const double *boxes, double *node_boxes, int32_t *parts, int32_t *order)
{
  const bs_build build = {boxes, order};
  bs_unbuilt waiting[BS_RANGES_WAITING];
  ptrdiff_t nodes = 0;
  int unbuilt = 0;
  double centers[6];
  if (count < 1) return 0;
  for (ptrdiff_t i = 0; i < count; i++) order[i] = (int32_t)i;
  waiting[0].range.begin = 0, waiting[0].range.end = count, waiting[0].level = 0, waiting[0].node = nodes++;
  bs_measure(&build, &waiting[0].range, centers);
  for (unbuilt = 1; unbuilt > 0;) {
    const bs_unbuilt now = waiting[--unbuilt];
    bs_range cut[BS_PARTS];
    const int found = bs_part(&build, &now.range, now.level >= BS_HEURISTIC_LEVELS, cut);
    double *const sides = node_boxes + 6 * BS_PARTS * now.node;
    for (int c = 0; c < BS_PARTS; c++) {
      const ptrdiff_t items = c < found ? cut[c].end - cut[c].begin : 0;
      for (int i = 0; i < 6; i++) sides[BS_PARTS * i + c] = items ? cut[c].box[i] : 0;
      parts[BS_PARTS * now.node + c] = items == 0 ? BS_NO_PART : items == 1 ? ~order[cut[c].begin] : (int32_t)nodes;
      if (items < 2) continue;
      waiting[unbuilt].range = cut[c], waiting[unbuilt].level = now.level + 1, waiting[unbuilt++].node = nodes++;
    }
  }
  return nodes;
}
