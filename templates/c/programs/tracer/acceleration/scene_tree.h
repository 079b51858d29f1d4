/* bladesmith: a ray against a tree over the boxes of rows. What is found does not depend on the tree in any bit: boxes
   hold all that a kind's functions may say, rounding included (codegen/formulas/rays/boxes.py).

   Nodes are asked with numbers of 32 bits, four boxes at once, seen from the tree's centre in its unit. A ray is taken
   there from where it enters the whole, and steps of about one unit are counted from there instead of t: so all
   numbers are about 1, and BS_TREE_MARGIN holds their roundings. */
#ifndef BS_TREE
#define BS_TREE

typedef struct { /* a node of a tree, 128 bytes: its four parts' boxes, seen from the tree's centre in its unit */
  float boxes[24]; /* x, y, z of the low corners, then of the high ones; inside out where there is no part */
  int32_t parts[4]; /* the number of a node, ~item of a row, or BS_NO_PART */
  int32_t unused[4];
} bs_node;

typedef struct { /* among a scene's integers, before the nodes and as long as one of them */
  double whole[6]; /* box around all */
  double center[3], unit; /* a point x of the world is (x - center) * unit for nodes */
  double unused[6];
} bs_tree;

/* A ray as the boxes of nodes see it; numbers are the same for each part. */
typedef struct {
  float near[3][BS_PARTS], far[3][BS_PARTS], inverse[3][BS_PARTS];
  float start, end; /* 0, and the steps to t_max, or a few more */
  ptrdiff_t first[3], last[3]; /* places of the sides, of a node's boxes, that the ray meets first and last */
  double begin, steps; /* t where the ray enters the whole, and steps in one of t */
} bs_box_ray;

/* A part that waits: above its number, the bits of the steps to its box, which are no negative number and so have its
   order; less than 0 is no part. */
typedef int64_t bs_stack_entry;

BS_INLINE float bs_entry_steps(bs_stack_entry entry)
{
  union {
    int32_t bits;
    float steps;
  } both;
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
    union {
      float steps;
      int32_t bits;
    } in;
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

/* A ray on its way through the tree. */
typedef struct {
  bs_box_ray box_ray;
  int count; /* of parts that wait */
  bs_stack_entry stack[BS_TREE_STACK];
} BS_MAY_ALIAS bs_traversal;

/* Take the nearest part that waits: an item to ask, else -1. */
BS_INLINE ptrdiff_t bs_traversal_step(bs_traversal *traversal, const ptrdiff_t *layout, ptrdiff_t *state)
{
  const bs_node *const nodes = (const bs_node *)(layout + layout[BS_LAYOUT_TREE_AT]) + 1;
  const bs_stack_entry next = traversal->stack[--traversal->count];
  const int32_t part = (int32_t)next;
  if (bs_entry_steps(next) > traversal->box_ray.end) return -1;
  if (part < 0) return part == BS_NO_PART ? -1 : ~part; /* rays from where numbers of 32 bits end enter every box */
  traversal->count = bs_tree_enter(traversal->stack, traversal->count, nodes + part, &traversal->box_ray);
  state[BS_STATE_COST] += BS_PARTS;
  return -1;
}
#endif

BS_INLINE float FN(tree_end)(const bs_box_ray *box_ray, const S *search)
{
  const double steps = ((double)search[BS_SEARCH_T_MAX] - box_ray->begin) * box_ray->steps;
  return (float)(steps + BS_TREE_MARGIN * (1 + fabs(steps)));
}

/* The ray as nodes see it; 0 where it passes the whole by. */
BS_INLINE int FN(tree_ray)(bs_box_ray *box_ray, const bs_tree *tree, const S *reals, const S *ray, const S *search)
{
  const S *const direction = ray + BS_RAY_DIRECTION;
  const S bounds[2] = {search[BS_SEARCH_T_MIN], search[BS_SEARCH_T_MAX]};
  S near[3], far[3], inverse[3], first[3], last[3], span[2];
  double fastest = 0;
  FN(cga3d_box_ray)(near, far, inverse, ray + BS_RAY_ORIGIN, direction, reals + BS_BOUNDS_REACH);
  BS_UNROLL
  for (int i = 0; i < 3; i++) {
    const int low = direction[i] < 0 ? 3 + i : i, high = direction[i] < 0 ? i : 3 + i;
    first[i] = (S)tree->whole[low], last[i] = (S)tree->whole[high];
    box_ray->first[i] = low * BS_PARTS, box_ray->last[i] = high * BS_PARTS;
    fastest = ABS(direction[i]) > fastest ? ABS(direction[i]) : fastest;
  }
  FN(cga3d_box_span)(span, near, far, inverse, first, last, bounds);
  if (!(span[0] <= span[1])) return 0;
  box_ray->begin = span[0], box_ray->steps = fastest * tree->unit;
  BS_UNROLL
  for (int i = 0; i < 3; i++) {
    const double moved = box_ray->begin * direction[i] - tree->center[i];
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

/* Begin with the root; see codegen/programs/tracer/tree/tree_search.py. */
BS_INLINE void FN(traversal_begin)(
    bs_traversal *traversal, const ptrdiff_t *layout, const S *reals, const S *ray, const S *search, ptrdiff_t *state)
{
  const bs_tree *const tree = (const bs_tree *)(layout + layout[BS_LAYOUT_TREE_AT]);
  traversal->count = 0;
  if (!layout[BS_LAYOUT_NODES] || !FN(tree_ray)(&traversal->box_ray, tree, reals, ray, search)) return;
  traversal->count = bs_tree_enter(traversal->stack, 0, (const bs_node *)tree + 1, &traversal->box_ray);
  state[BS_STATE_COST] += BS_PARTS;
}

/* After hits that bring the end of the search nearer. */
BS_INLINE void FN(traversal_narrow)(bs_traversal *traversal, const S *search)
{
  traversal->box_ray.end = FN(tree_end)(&traversal->box_ray, search);
}

/* The same as algorithms call them, with room for the ray's way among their own numbers. */
BS_INLINE void FN(begin_tree)(const ptrdiff_t *scene, const ptrdiff_t *integers, const S *reals, const S *ray,
    const S *search, ptrdiff_t *state, S *progress, ptrdiff_t *traversal)
{
  (void)integers, (void)progress;
  FN(traversal_begin)((bs_traversal *)traversal, scene, reals, ray, search, state);
}

BS_INLINE ptrdiff_t FN(next_in_tree)(const ptrdiff_t *scene, const ptrdiff_t *integers, const S *reals, const S *ray,
    const S *search, ptrdiff_t *state, S *progress, ptrdiff_t *traversal)
{
  bs_traversal *const way = (bs_traversal *)traversal;
  (void)integers, (void)reals, (void)ray, (void)progress;
  if (way->count > 0) FN(traversal_narrow)(way, search);
  while (way->count > 0) {
    const ptrdiff_t item = bs_traversal_step(way, scene, state);
    if (item >= 0) return item;
  }
  return -1;
}
