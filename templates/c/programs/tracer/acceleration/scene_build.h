/* bladesmith: the tree over boxes, made once for a scene. Items are parted where the surface area heuristic expects the
   least work of rays; far down, and where all centres are one, in halves. The four parts of a node come of three such
   cuts, the largest part being cut first. Items are moved, boxes and all: what is read together lies together. */

enum {
  BS_BINS = 16,                 /* places along an axis where items may be parted */
  BS_FEW = 12,                  /* items that are sorted, and may be parted between any two */
  BS_HEURISTIC_LEVELS = 28,     /* below, parts are quarters: no tree of 2^31 items is deeper than BS_TREE_LEVELS */
  BS_RANGES_WAITING = BS_TREE_LEVELS * (BS_PARTS - 1) + 1
};

typedef struct { double box[6]; int64_t number; } bs_item;
typedef struct { double box[6], centers[6]; ptrdiff_t count; } bs_extent; /* of items, and of their boxes' centres */
typedef struct { bs_item *items; bs_extent extent; } bs_range;
typedef struct { bs_range range; ptrdiff_t node; int level; } bs_unbuilt;

static void bs_empty(bs_extent *extent)
{
  for (int i = 0; i < 3; i++) {
    extent->box[i] = extent->centers[i] = BS_HUGE_VALUE;
    extent->box[3 + i] = extent->centers[3 + i] = -BS_HUGE_VALUE;
  }
  extent->count = 0;
}

static inline double bs_center(const double *box, int axis)
{
  return 0.5 * box[axis] + 0.5 * box[3 + axis];
}

static inline void bs_enlarge(double *box, const double *low, const double *high)
{
  for (int i = 0; i < 3; i++) {
    box[i] = low[i] < box[i] ? low[i] : box[i];
    box[3 + i] = high[i] > box[3 + i] ? high[i] : box[3 + i];
  }
}

static inline void bs_add_item(bs_extent *extent, const bs_item *item)
{
  const double *const b = item->box;
  const double center[3] = {bs_center(b, 0), bs_center(b, 1), bs_center(b, 2)};
  bs_enlarge(extent->box, b, b + 3);
  bs_enlarge(extent->centers, center, center);
  extent->count++;
}

static void bs_add(bs_extent *extent, const bs_extent *other)
{
  bs_enlarge(extent->box, other->box, other->box + 3);
  bs_enlarge(extent->centers, other->centers, other->centers + 3);
  extent->count += other->count;
}

static double bs_area(const double *box)
{
  const double x = box[3] - box[0], y = box[4] - box[1], z = box[5] - box[2];
  return x * y + y * z + z * x;
}

/* What rays are expected to ask of some items, in nodes, which cost the same with any number of parts: BS_HUGE_VALUE of
   none, so that no part is empty. */
static double bs_cost(const bs_extent *extent)
{
  const ptrdiff_t nodes = (extent->count + BS_PARTS - 1) / BS_PARTS;
  return nodes ? (double)nodes * bs_area(extent->box) : BS_HUGE_VALUE;
}

/* The place among a row of extents before which the least is expected if they are parted there, and both parts; 0
   where nothing can be told. */
static int bs_best_cut(const bs_extent *row, int count, bs_extent *low, bs_extent *high)
{
  double after[BS_BINS > BS_FEW ? BS_BINS : BS_FEW], least = BS_HUGE_VALUE;
  bs_extent extent;
  int best = 0;
  bs_empty(&extent);
  for (int b = count - 1; b > 0; b--) {
    bs_add(&extent, row + b);
    after[b] = bs_cost(&extent);
  }
  bs_empty(&extent);
  for (int b = 1; b < count; b++) {
    bs_add(&extent, row + b - 1);
    const double cost = bs_cost(&extent) + after[b];
    if (cost < least) least = cost, best = b, *low = extent;
  }
  bs_empty(high);
  for (int b = best; b < count; b++) bs_add(high, row + b);
  return best;
}

/* Part a few items between any two of them, in the order of their centres; 0 where nothing can be told. */
static int bs_cut_few(const bs_range *range, int axis, bs_range *low, bs_range *high)
{
  bs_extent row[BS_FEW];
  bs_item *const items = range->items;
  const int count = (int)range->extent.count;
  for (int i = 1; i < count; i++) {
    const bs_item item = items[i];
    int place = i;
    for (; place > 0 && bs_center(items[place - 1].box, axis) > bs_center(item.box, axis); place--)
      items[place] = items[place - 1];
    items[place] = item;
  }
  for (int i = 0; i < count; i++) bs_empty(row + i), bs_add_item(row + i, items + i);
  return bs_best_cut(row, count, &low->extent, &high->extent);
}

static inline int bs_bin(const bs_item *item, int axis, double start, double scale)
{
  const int bin = (int)((bs_center(item->box, axis) - start) * scale);
  return bin < 0 ? 0 : bin < BS_BINS ? bin : BS_BINS - 1;
}

/* Part items at one of a few places along an axis; 0 where nothing can be told. */
static int bs_cut_many(const bs_range *range, int axis, bs_range *low, bs_range *high)
{
  const double start = range->extent.centers[axis], scale = BS_BINS / (range->extent.centers[3 + axis] - start);
  bs_extent bins[BS_BINS];
  if (!(scale > 0 && scale < BS_HUGE_VALUE)) return 0;
  for (int b = 0; b < BS_BINS; b++) bs_empty(bins + b);
  for (ptrdiff_t i = 0; i < range->extent.count; i++)
    bs_add_item(&bins[bs_bin(range->items + i, axis, start, scale)], range->items + i);
  const int cut = bs_best_cut(bins, BS_BINS, &low->extent, &high->extent);
  if (!cut) return 0;
  bs_item *i = range->items, *j = range->items + range->extent.count;
  for (;;) {
    while (i < j && bs_bin(i, axis, start, scale) < cut) i++;
    while (i < j && bs_bin(j - 1, axis, start, scale) >= cut) j--;
    if (i >= j) return 1;
    const bs_item item = *i;
    *i++ = *--j;
    *j = item;
  }
}

/* Part a range in two; both have items. */
static void bs_cut(const bs_range *given, int halves, bs_range *low, bs_range *high)
{
  const bs_range range = *given;
  const ptrdiff_t count = range.extent.count;
  int axis = 0, cut = 0;
  for (int i = 1; i < 3; i++)
    if (range.extent.centers[3 + i] - range.extent.centers[i]
        > range.extent.centers[3 + axis] - range.extent.centers[axis]) axis = i;
  if (!halves) cut = count <= BS_FEW ? bs_cut_few(&range, axis, low, high) : bs_cut_many(&range, axis, low, high);
  if (!cut) {
    bs_empty(&low->extent), bs_empty(&high->extent);
    for (ptrdiff_t i = 0; i < count; i++) bs_add_item(i < count / 2 ? &low->extent : &high->extent, range.items + i);
  }
  low->items = range.items, high->items = range.items + low->extent.count;
}

/* Up to four parts of a range; their number. */
static int bs_part(const bs_range *range, int halves, bs_range *parts)
{
  int count = 1;
  parts[0] = *range;
  while (count < BS_PARTS) {
    int chosen = -1;
    double most = -1;
    for (int i = 0; i < count; i++) {
      const double items = (double)parts[i].extent.count, area = halves ? 1 : bs_area(parts[i].extent.box);
      const double size = area < BS_HUGE_VALUE ? items * area : items;
      if (items > 1 && size > most) most = size, chosen = i;
    }
    if (chosen < 0) break;
    const bs_range whole = parts[chosen];
    bs_cut(&whole, halves, &parts[chosen], &parts[count++]);
  }
  return count;
}

/* The parts of so few items: each is one. */
static int bs_singles(const bs_range *range, bs_range *parts)
{
  for (int i = 0; i < (int)range->extent.count; i++) {
    parts[i].items = range->items + i;
    bs_empty(&parts[i].extent), bs_add_item(&parts[i].extent, parts[i].items);
  }
  return (int)range->extent.count;
}

/* The tree over boxes (rows: low, high), nodes in the order in which they were made, their root first. There must be
   room for as many nodes as there are boxes, and for as many items. Returns the number of nodes. */
static ptrdiff_t bs_build_tree(ptrdiff_t count, const double *boxes, double *node_boxes, int32_t *parts, void *room)
{
  bs_unbuilt waiting[BS_RANGES_WAITING];
  bs_range all = {(bs_item *)room, {{0}, {0}, 0}};
  ptrdiff_t nodes = 0;
  int unbuilt = 0;
  if (count < 1) return 0;
  bs_empty(&all.extent);
  for (ptrdiff_t i = 0; i < count; i++) {
    for (int j = 0; j < 6; j++) all.items[i].box[j] = boxes[6 * i + j];
    all.items[i].number = i;
    bs_add_item(&all.extent, all.items + i);
  }
  waiting[0].range = all, waiting[0].level = 0, waiting[0].node = nodes++;
  for (unbuilt = 1; unbuilt > 0;) {
    const bs_unbuilt now = waiting[--unbuilt];
    const int halves = now.level >= BS_HEURISTIC_LEVELS;
    bs_range cut[BS_PARTS];
    const int found = now.range.extent.count <= BS_PARTS ? bs_singles(&now.range, cut) : bs_part(&now.range, halves, cut);
    double *const sides = node_boxes + 6 * BS_PARTS * now.node;
    for (int c = 0; c < BS_PARTS; c++) {
      const ptrdiff_t items = c < found ? cut[c].extent.count : 0;
      for (int i = 0; i < 6; i++) sides[BS_PARTS * i + c] = items ? cut[c].extent.box[i] : 0;
      parts[BS_PARTS * now.node + c] =
        items == 0 ? BS_NO_PART : items == 1 ? (int32_t)~cut[c].items->number : (int32_t)nodes;
      if (items < 2) continue;
      waiting[unbuilt].range = cut[c], waiting[unbuilt].level = now.level + 1, waiting[unbuilt++].node = nodes++;
    }
  }
  return nodes;
}
