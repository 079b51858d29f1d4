/* bladesmith: greedy merging of the cheapest pair, exactly, with a tree and a queue.
 *
 * Every object keeps its nearest other one of the time when it was last asked. For each pair that lives, the younger
 * of the two was asked while the other was there; so the least cost in the queue is the least of all pairs, or is one
 * whose other object has gone or changed since, and is then asked again. The mean asks for itself when it is made.
 */

/* The same number for both orders of the pair. */
static inline double pair_cost(const bs_merge *s, int32_t a, int32_t b)
{
  const bs_kind *kind = &bs_kinds[s->kind];
  double cost;
  (s->align ? kind->aligned_cost : kind->cost)(&cost, row_of(s, a < b ? a : b), row_of(s, a < b ? b : a));
  return cost;
}

/* The mean of a pair, a < b; whether there is one. */
static inline int pair_mean(const bs_merge *s, double *out, int32_t a, int32_t b)
{
  const bs_kind *kind = &bs_kinds[s->kind];
  double status;
  (s->align ? kind->aligned_mean : kind->mean)(out, &status, row_of(s, a), row_of(s, b), s->weights + a,
                                               s->weights + b);
  return status == 0;
}

/* -- the nearest object ----------------------------------------------------------------------------------- */

typedef struct {
  int32_t slot;
  double cost;
  double enough; /* a cost that ends the search */
  int64_t evaluations;
} bs_nearest;

static void visit_leaf(const bs_merge *s, int32_t slot, ptrdiff_t index, bs_nearest *best)
{
  const double *own = landmark_of(s, slot);
  const ptrdiff_t end = part(s->built, index + 1, s->levels);
  double unused[BS_ROW_MOST];
  for (ptrdiff_t p = part(s->built, index, s->levels); p < end; p++) {
    const int32_t other = s->order[p];
    const double *mark = s->leaves + (ptrdiff_t)s->marks * p;
    if (other < 0 || other == slot || least_cost(s, own, mark, mark) > best->cost) continue;
    const double cost = pair_cost(s, slot, other);
    best->evaluations++;
    if (!(cost < best->cost || (cost == best->cost && (best->slot < 0 || other < best->slot)))) continue;
    if (!pair_mean(s, unused, slot < other ? slot : other, slot < other ? other : slot)) continue;
    best->cost = cost;
    best->slot = other;
    if (cost <= best->enough) return;
  }
}

/* The other object of least cost within the threshold, of equal ones that of the lowest slot. Among copies of one
 * object any serves: the first that cannot be told from it ends the search, or n copies would cost n^2; and each
 * looks at home first, or one would be the neighbour of all. */
static bs_nearest find_nearest(const bs_merge *s, int32_t slot)
{
  const double *own = landmark_of(s, slot);
  const ptrdiff_t leaves = (ptrdiff_t)1 << s->levels;
  bs_nearest best = {-1, s->threshold, no_cost(s, own), 0};
  const ptrdiff_t home = leaves + leaf_of(s, slot);
  ptrdiff_t nodes[BS_DEEPEST];
  double bounds[BS_DEEPEST];
  int depth = 0;
  nodes[depth] = 1, bounds[depth++] = 0;
  while (depth && !(best.slot >= 0 && best.cost <= best.enough)) {
    const ptrdiff_t node = nodes[--depth];
    if (bounds[depth] > best.cost) continue;
    if (node >= leaves) {
      visit_leaf(s, slot, node - leaves, &best);
      continue;
    }
    ptrdiff_t above = home; /* on the level of the children */
    while (above > 2 * node + 1) above >>= 1;
    double bound[2];
    for (int side = 0; side < 2; side++) {
      const ptrdiff_t child = 2 * node + side;
      const double *box = box_of(s, child);
      bound[side] = s->alive[child] ? least_cost(s, own, box, box + s->marks) : BS_HUGE_VALUE;
    }
    const int far = bound[0] < bound[1] || (bound[0] == bound[1] && above != 2 * node + 1);
    for (int k = 0; k < 2; k++) { /* the nearer one is visited first */
      const int side = k ? !far : far;
      if (s->alive[2 * node + side] && bound[side] <= best.cost)
        nodes[depth] = 2 * node + side, bounds[depth++] = bound[side];
    }
  }
  return best;
}

static int64_t ask(const bs_merge *s, int32_t slot)
{
  const bs_nearest best = find_nearest(s, slot);
  s->nearest[slot] = best.slot;
  s->seen[slot] = best.slot < 0 ? 0 : s->versions[best.slot];
  s->costs[slot] = best.cost;
  return best.evaluations;
}

/* -- the queue -------------------------------------------------------------------------------------------- */

static inline int is_cheaper(const bs_merge *s, int32_t a, int32_t b)
{
  return s->costs[a] < s->costs[b] || (s->costs[a] == s->costs[b] && a < b);
}

static inline void put(bs_merge *s, ptrdiff_t place, int32_t slot)
{
  s->heap[place] = slot;
  s->heap_place[slot] = (int32_t)place;
}

/* Bring a slot, whose place in the heap is free for others, to where its cost belongs. */
static void settle(bs_merge *s, ptrdiff_t place, int32_t slot)
{
  while (place > 0 && is_cheaper(s, slot, s->heap[(place - 1) / 2])) {
    put(s, place, s->heap[(place - 1) / 2]);
    place = (place - 1) / 2;
  }
  for (;;) {
    ptrdiff_t child = 2 * place + 1;
    if (child >= s->heap_size) break;
    if (child + 1 < s->heap_size && is_cheaper(s, s->heap[child + 1], s->heap[child])) child++;
    if (!is_cheaper(s, s->heap[child], slot)) break;
    put(s, place, s->heap[child]);
    place = child;
  }
  put(s, place, slot);
}

static void leave_queue(bs_merge *s, int32_t slot)
{
  const ptrdiff_t place = s->heap_place[slot];
  if (place < 0) return;
  s->heap_place[slot] = -1;
  const int32_t last = s->heap[--s->heap_size];
  if (last != slot) settle(s, place, last);
}

/* Ask for a slot's nearest object, and queue it with that. */
static void requeue(bs_merge *s, int32_t slot)
{
  s->evaluations += ask(s, slot);
  if (s->nearest[slot] < 0)
    leave_queue(s, slot);
  else
    settle(s, s->heap_place[slot] < 0 ? s->heap_size++ : s->heap_place[slot], slot);
}

/* -- merging ---------------------------------------------------------------------------------------------- */

static void merge_pair(bs_merge *s, int32_t one, int32_t other, double cost)
{
  const bs_kind *kind = &bs_kinds[s->kind];
  const int32_t kept = one < other ? one : other, gone = one < other ? other : one;
  double mean[BS_ROW_MOST];
  pair_mean(s, mean, kept, gone);
  for (int i = 0; i < kind->size; i++) s->rows[(ptrdiff_t)kind->size * kept + i] = mean[i];
  s->weights[kept] += s->weights[gone];
  mark(s, kept);
  s->versions[kept]++;
  s->versions[gone] = -1;
  s->live--;
  s->merged_costs[s->merges] = cost;
  s->kept[s->merges] = kept;
  s->gone[s->merges++] = gone;
  leave_queue(s, gone);
  if (s->live * BS_REBUILD < s->built)
    build_tree(s);
  else
    refit(s, gone, -1), refit(s, kept, 0);
  requeue(s, kept);
}

void bs_merge_begin(bs_merge *s)
{
  for (ptrdiff_t slot = 0; slot < s->count; slot++) {
    if (s->versions[slot] >= 0) mark(s, (int32_t)slot);
    s->heap_place[slot] = -1;
  }
  s->heap_size = 0;
  build_tree(s);
}

/* Objects of these places of the tree, right after bs_merge_begin. */
int64_t bs_merge_find(const bs_merge *s, ptrdiff_t begin, ptrdiff_t end)
{
  int64_t evaluations = 0;
  for (ptrdiff_t p = begin; p < end; p++) evaluations += ask(s, s->order[p]);
  return evaluations;
}

void bs_merge_queue(bs_merge *s)
{
  for (ptrdiff_t slot = 0; slot < s->count; slot++)
    if (s->versions[slot] >= 0 && s->nearest[slot] >= 0) settle(s, s->heap_size++, (int32_t)slot);
}

/* At most so many merges; fewer were done only if no pair is left. */
ptrdiff_t bs_merge_step(bs_merge *s, ptrdiff_t most)
{
  const ptrdiff_t before = s->merges;
  while (s->heap_size && s->merges - before < most) {
    const int32_t slot = s->heap[0], other = s->nearest[slot];
    if (s->versions[other] != s->seen[slot])
      requeue(s, slot);
    else
      merge_pair(s, slot, other, s->costs[slot]);
  }
  return s->merges - before;
}

/* The least cost that the landmarks of two objects promise, for tests. */
double bs_merge_bound(const bs_merge *s, ptrdiff_t first, ptrdiff_t second)
{
  const double *other = landmark_of(s, (int32_t)second);
  return least_cost(s, landmark_of(s, (int32_t)first), other, other);
}
