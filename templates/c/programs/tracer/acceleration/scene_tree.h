/* bladesmith: a ray against a tree over the boxes of rows. What is found does not depend on the tree in any bit: boxes
   hold all that a kind's functions may say, rounding included (codegen/formulas/rays/boxes.py).

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
} bs_box_ray;

/* A part that waits: above its number, the bits of the steps to its box, which are no negative number and so have its
   order; less than 0 is no part. */
typedef int64_t bs_stack_entry;

BS_INLINE float bs_entry_steps(bs_stack_entry entry)
{
  union { int32_t bits; float steps; } both;
  both.bits = (int32_t)(entry >> 32);
  return both.steps;
}

BS_INLINE void bs_nearer_last(bs_stack_entry *first, bs_stack_entry *last)
{
  const bs_stack_entry a = *first, b = *last;
  *first = a < b ? b : a, *last = a < b ? a : b;
}

/* The parts of a node that the ray enters in time, after those that wait: the nearest last. Nothing branches: which
   parts are entered no processor can tell beforehand, and to be wrong costs as much as a node. */
BS_INLINE int bs_tree_enter(bs_stack_entry *stack, int count, const bs_node *node, const bs_box_ray *box_ray)
{
  const float *const first_x = node->boxes + box_ray->first[0], *const last_x = node->boxes + box_ray->last[0];
  const float *const first_y = node->boxes + box_ray->first[1], *const last_y = node->boxes + box_ray->last[1];
  const float *const first_z = node->boxes + box_ray->first[2], *const last_z = node->boxes + box_ray->last[2];
  bs_stack_entry found[BS_PARTS];
  int missed = 0;
#pragma omp simd reduction(+ : missed)
  for (int c = 0; c < BS_PARTS; c++) { /* boxes.box_span; where a side is no number, it says nothing */
    union { float steps; int32_t bits; } in;
    float out = box_ray->end, side;
    in.steps = box_ray->start;
    side = (first_x[c] - box_ray->near[0][c]) * box_ray->inverse[0][c], in.steps = side > in.steps ? side : in.steps;
    side = (first_y[c] - box_ray->near[1][c]) * box_ray->inverse[1][c], in.steps = side > in.steps ? side : in.steps;
    side = (first_z[c] - box_ray->near[2][c]) * box_ray->inverse[2][c], in.steps = side > in.steps ? side : in.steps;
    side = (last_x[c] - box_ray->far[0][c]) * box_ray->inverse[0][c], out = side < out ? side : out;
    side = (last_y[c] - box_ray->far[1][c]) * box_ray->inverse[1][c], out = side < out ? side : out;
    side = (last_z[c] - box_ray->far[2][c]) * box_ray->inverse[2][c], out = side < out ? side : out;
    const int32_t miss = in.steps <= out ? 0 : -1;
    found[c] = (bs_stack_entry)((uint64_t)(uint32_t)(in.bits | miss) << 32 | (uint32_t)node->parts[c]);
    missed += miss;
  }
  bs_nearer_last(found, found + 1), bs_nearer_last(found + 2, found + 3);
  bs_nearer_last(found, found + 2), bs_nearer_last(found + 1, found + 3);
  bs_nearer_last(found + 1, found + 2);
  BS_UNROLL
  for (int c = 0; c < BS_PARTS; c++) stack[count + c] = found[c];
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

BS_INLINE float FN(tree_end)(const bs_box_ray *box_ray, const FN(search) *search)
{
  const double steps = ((double)search->t_max - box_ray->begin) * box_ray->steps;
  return (float)(steps + BS_TREE_MARGIN * (1 + fabs(steps)));
}

/* The ray as nodes see it; 0 where it passes the whole by. */
BS_INLINE int FN(tree_ray)(bs_box_ray *box_ray, const bs_tree *tree, const FN(ray) *ray, const FN(search) *search)
{
  const S reach = (S)tree->reach, bounds[2] = {search->t_min, search->t_max};
  S near[3], far[3], inverse[3], first[3], last[3], span[2];
  double fastest = 0;
  FN(cga3d_box_ray)(near, far, inverse, ray->origin, ray->direction, &reach);
  BS_UNROLL
  for (int i = 0; i < 3; i++) {
    const int low = ray->direction[i] < 0 ? 3 + i : i, high = ray->direction[i] < 0 ? i : 3 + i;
    first[i] = (S)tree->whole[low], last[i] = (S)tree->whole[high];
    box_ray->first[i] = low * BS_PARTS, box_ray->last[i] = high * BS_PARTS;
    fastest = ABS(ray->direction[i]) > fastest ? ABS(ray->direction[i]) : fastest;
  }
  FN(cga3d_box_span)(span, near, far, inverse, first, last, bounds);
  if (!(span[0] <= span[1])) return 0;
  box_ray->begin = span[0], box_ray->steps = fastest * tree->unit;
  BS_UNROLL
  for (int i = 0; i < 3; i++) {
    const double moved = box_ray->begin * ray->direction[i] - tree->center[i];
    const double margin = inverse[i] < 0 ? -BS_TREE_MARGIN : BS_TREE_MARGIN;
    const float before = (float)((near[i] + moved) * tree->unit + margin);
    const float behind = (float)((far[i] + moved) * tree->unit - margin);
    const float inverted = (float)(inverse[i] * fastest);
#pragma omp simd
    for (int c = 0; c < BS_PARTS; c++)
      box_ray->near[i][c] = before, box_ray->far[i][c] = behind, box_ray->inverse[i][c] = inverted;
  }
  box_ray->start = 0, box_ray->end = FN(tree_end)(box_ray, search);
  return 1;
}

/* A ray on its way through the tree. */
typedef struct {
  bs_box_ray box_ray;
  int count; /* of parts that wait */
  bs_stack_entry stack[BS_TREE_STACK];
} FN(traversal);

/* Ask what has no box, and the root. */
BS_INLINE void FN(traversal_begin)(FN(traversal) *traversal, FN(search) *search, const bs_scene *scene, const FN(ray) *ray,
                                   int any)
{
  const bs_tree *const tree = &scene->tree;
  traversal->count = 0;
  for (ptrdiff_t item = tree->unbounded; item < tree->item_count; item++) {
    if (any && search->count) return;
    FN(scene_ask_item)(search, scene, ray, item);
  }
  if (!tree->node_count || (any && search->count) || !FN(tree_ray)(&traversal->box_ray, tree, ray, search)) return;
  traversal->count = bs_tree_enter(traversal->stack, 0, tree->nodes, &traversal->box_ray);
  search->cost += BS_PARTS;
}

/* Ask the nearest part that waits. */
BS_INLINE void FN(traversal_step)(FN(traversal) *traversal, FN(search) *search, const bs_scene *scene, const FN(ray) *ray)
{
  const bs_stack_entry next = traversal->stack[--traversal->count];
  const int32_t part = (int32_t)next;
  if (bs_entry_steps(next) > traversal->box_ray.end) return;
  if (part >= 0) {
    traversal->count = bs_tree_enter(traversal->stack, traversal->count, scene->tree.nodes + part, &traversal->box_ray);
    search->cost += BS_PARTS;
  } else if (part != BS_NO_PART) { /* rays from where numbers of 32 bits end enter every box, even of none */
    FN(scene_ask_item)(search, scene, ray, ~part);
    traversal->box_ray.end = FN(tree_end)(&traversal->box_ray, search);
  }
}

/* Ask every row that the ray may meet, the nearest boxes first; where any hit will do, until there is one. */
BS_INLINE void FN(scene_ask)(FN(search) *search, const bs_scene *scene, const FN(ray) *ray, int any)
{
  FN(traversal) traversal;
  FN(traversal_begin)(&traversal, search, scene, ray, any);
  while (traversal.count > 0 && !(any && search->count)) FN(traversal_step)(&traversal, search, scene, ray);
}
