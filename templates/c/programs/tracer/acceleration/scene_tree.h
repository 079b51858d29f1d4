/* bladesmith: a ray against a tree over the boxes of rows. What is found does not depend on the tree in any bit: boxes
   hold all that a kind's functions may say, rounding included (codegen/formulas/boxes.py).

   Nodes are asked with numbers of 32 bits, four boxes at once, seen from the tree's centre in its unit. A ray is taken
   there from where it enters the whole, and steps of about one unit are counted from there instead of t: so all
   numbers are about 1, and BS_TREE_MARGIN holds their roundings. */
#ifndef BS_TREE
#define BS_TREE

/* A ray as the boxes of nodes see it; numbers are the same for each part. */
typedef struct {
  float near[3][BS_PARTS], far[3][BS_PARTS], inverse[3][BS_PARTS];
  float start, end;            /* 0, and the steps to t_max, or a few more */
  ptrdiff_t first[3], last[3]; /* places of the sides, of a node's boxes, that the ray meets first and last */
  double begin, steps;         /* t where the ray enters the whole, and steps in one of t */
} bs_sight;

/* A part that waits: above its number, the bits of the steps to its box, which are no negative number and so have its
   order; less than 0 is no part. */
typedef int64_t bs_waiting;

BS_INLINE float bs_waiting_steps(bs_waiting waiting)
{
  union { int32_t bits; float steps; } both;
  both.bits = (int32_t)(waiting >> 32);
  return both.steps;
}

BS_INLINE void bs_nearer_last(bs_waiting *first, bs_waiting *last)
{
  const bs_waiting a = *first, b = *last;
  *first = a < b ? b : a, *last = a < b ? a : b;
}

/* The parts of a node that the ray enters in time, after those that wait: the nearest last. Nothing branches: which
   parts are entered no processor can tell beforehand, and to be wrong costs as much as a node. */
BS_INLINE int bs_tree_enter(bs_waiting *waiting, int count, const bs_node *node, const bs_sight *sight)
{
  const float *const first_x = node->boxes + sight->first[0], *const last_x = node->boxes + sight->last[0];
  const float *const first_y = node->boxes + sight->first[1], *const last_y = node->boxes + sight->last[1];
  const float *const first_z = node->boxes + sight->first[2], *const last_z = node->boxes + sight->last[2];
  bs_waiting found[BS_PARTS];
  int missed = 0;
#pragma omp simd reduction(+ : missed)
  for (int c = 0; c < BS_PARTS; c++) { /* boxes.box_span; where a side is no number, it says nothing */
    union { float steps; int32_t bits; } in;
    float out = sight->end, side;
    in.steps = sight->start;
    side = (first_x[c] - sight->near[0][c]) * sight->inverse[0][c], in.steps = side > in.steps ? side : in.steps;
    side = (first_y[c] - sight->near[1][c]) * sight->inverse[1][c], in.steps = side > in.steps ? side : in.steps;
    side = (first_z[c] - sight->near[2][c]) * sight->inverse[2][c], in.steps = side > in.steps ? side : in.steps;
    side = (last_x[c] - sight->far[0][c]) * sight->inverse[0][c], out = side < out ? side : out;
    side = (last_y[c] - sight->far[1][c]) * sight->inverse[1][c], out = side < out ? side : out;
    side = (last_z[c] - sight->far[2][c]) * sight->inverse[2][c], out = side < out ? side : out;
    const int32_t miss = in.steps <= out ? 0 : -1;
    found[c] = (bs_waiting)((uint64_t)(uint32_t)(in.bits | miss) << 32 | (uint32_t)node->parts[c]);
    missed += miss;
  }
  bs_nearer_last(found, found + 1), bs_nearer_last(found + 2, found + 3);
  bs_nearer_last(found, found + 2), bs_nearer_last(found + 1, found + 3);
  bs_nearer_last(found + 1, found + 2);
  BS_UNROLL
  for (int c = 0; c < BS_PARTS; c++) waiting[count + c] = found[c];
  return count + BS_PARTS + missed;
}
#endif

/* Ask one row. */
BS_INLINE void FN(scene_ask_item)(FN(search) *search, const bs_scene *scene, const FN(ray) *ray, ptrdiff_t item)
{
  search->kind = scene->tree.items[2 * item], search->index = scene->tree.items[2 * item + 1];
#define BS_EACH(number, name, given, size) \
  if (search->kind == number) FN(name##_hits)(search, BS_ROW(scene, number, size, search->index), ray);
  BS_SCENE_KINDS(BS_EACH)
#undef BS_EACH
  FN(scene_asked)(search, scene, ray);
}

BS_INLINE float FN(tree_end)(const bs_sight *sight, const FN(search) *search)
{
  const double steps = ((double)search->t_max - sight->begin) * sight->steps;
  return (float)(steps + BS_TREE_MARGIN * (1 + fabs(steps)));
}

/* The ray as nodes see it; 0 where it passes the whole by. */
BS_INLINE int FN(tree_sight)(bs_sight *sight, const bs_tree *tree, const FN(ray) *ray, const FN(search) *search)
{
  const S reach = (S)tree->reach, bounds[2] = {search->t_min, search->t_max};
  S near[3], far[3], inverse[3], first[3], last[3], span[2];
  double fastest = 0;
  FN(cga3d_box_ray)(near, far, inverse, ray->origin, ray->direction, &reach);
  BS_UNROLL
  for (int i = 0; i < 3; i++) {
    const int low = ray->direction[i] < 0 ? 3 + i : i, high = ray->direction[i] < 0 ? i : 3 + i;
    first[i] = (S)tree->whole[low], last[i] = (S)tree->whole[high];
    sight->first[i] = low * BS_PARTS, sight->last[i] = high * BS_PARTS;
    fastest = ABS(ray->direction[i]) > fastest ? ABS(ray->direction[i]) : fastest;
  }
  FN(cga3d_box_span)(span, near, far, inverse, first, last, bounds);
  if (!(span[0] <= span[1])) return 0;
  sight->begin = span[0], sight->steps = fastest * tree->unit;
  BS_UNROLL
  for (int i = 0; i < 3; i++) {
    const double moved = sight->begin * ray->direction[i] - tree->center[i];
    const double margin = inverse[i] < 0 ? -BS_TREE_MARGIN : BS_TREE_MARGIN;
    const float before = (float)((near[i] + moved) * tree->unit + margin);
    const float behind = (float)((far[i] + moved) * tree->unit - margin);
    const float inverted = (float)(inverse[i] * fastest);
#pragma omp simd
    for (int c = 0; c < BS_PARTS; c++)
      sight->near[i][c] = before, sight->far[i][c] = behind, sight->inverse[i][c] = inverted;
  }
  sight->start = 0, sight->end = FN(tree_end)(sight, search);
  return 1;
}

/* A ray on its way through the tree. */
typedef struct {
  bs_sight sight;
  int count; /* of parts that wait */
  bs_waiting waiting[BS_TREE_WAITING];
} FN(walk);

/* Ask what has no box, and the root. */
BS_INLINE void FN(walk_begin)(FN(walk) *walk, FN(search) *search, const bs_scene *scene, const FN(ray) *ray, int any)
{
  const bs_tree *const tree = &scene->tree;
  walk->count = 0;
  for (ptrdiff_t item = tree->loose; item < tree->item_count; item++) {
    if (any && search->count) return;
    FN(scene_ask_item)(search, scene, ray, item);
  }
  if (!tree->node_count || (any && search->count) || !FN(tree_sight)(&walk->sight, tree, ray, search)) return;
  walk->count = bs_tree_enter(walk->waiting, 0, tree->nodes, &walk->sight);
  search->cost += BS_PARTS;
}

/* Ask the nearest part that waits. */
BS_INLINE void FN(walk_step)(FN(walk) *walk, FN(search) *search, const bs_scene *scene, const FN(ray) *ray)
{
  const bs_waiting next = walk->waiting[--walk->count];
  const int32_t part = (int32_t)next;
  if (bs_waiting_steps(next) > walk->sight.end) return;
  if (part >= 0) {
    walk->count = bs_tree_enter(walk->waiting, walk->count, scene->tree.nodes + part, &walk->sight);
    search->cost += BS_PARTS;
  } else if (part != BS_NO_PART) { /* rays from where numbers of 32 bits end enter every box, even of none */
    FN(scene_ask_item)(search, scene, ray, ~part);
    walk->sight.end = FN(tree_end)(&walk->sight, search);
  }
}

/* Ask every row that the ray may meet, the nearest boxes first; where any hit will do, until there is one. */
BS_INLINE void FN(scene_ask)(FN(search) *search, const bs_scene *scene, const FN(ray) *ray, int any)
{
  FN(walk) walk;
  FN(walk_begin)(&walk, search, scene, ray, any);
  while (walk.count > 0 && !(any && search->count)) FN(walk_step)(&walk, search, scene, ray);
}
