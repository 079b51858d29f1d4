/* bladesmith: a ray against a tree over the boxes of rows. What is found does not depend on the tree in any bit: boxes
   hold all that a kind's functions may say, rounding included (codegen/formulas/boxes.py). */

typedef struct {
  S near;       /* where the ray enters its box */
  int32_t part; /* a node, or ~item */
} FN(waiting);

/* A ray as boxes see it. */
typedef struct {
  S near[3], far[3], inverse[3];
  int first[3], last[3]; /* places of the sides, of a node's boxes, that the ray meets first and last */
} FN(sight);

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

BS_INLINE void FN(tree_sight)(FN(sight) *sight, const bs_scene *scene, const FN(ray) *ray)
{
  const S reach = (S)scene->tree.reach;
  FN(cga3d_box_ray)(sight->near, sight->far, sight->inverse, ray->origin, ray->direction, &reach);
  for (int i = 0; i < 3; i++) {
    const int backward = ray->direction[i] < 0;
    sight->first[i] = (backward ? 3 + i : i) * BS_PARTS;
    sight->last[i] = (backward ? i : 3 + i) * BS_PARTS;
  }
}

/* The parts of a node that the ray enters before t_max, added to those that wait: the nearest last. */
BS_INLINE int FN(tree_enter)(FN(waiting) *waiting, int count, const bs_scene *scene, ptrdiff_t node, FN(search) *search,
                             const FN(sight) *sight)
{
  const S *const boxes = (const S *)scene->tree.boxes + 6 * BS_PARTS * node;
  const int32_t *const parts = scene->tree.parts + BS_PARTS * node;
  const S bounds[2] = {search->t_min, search->t_max};
  const int before = count;
  for (int c = 0; c < BS_PARTS && parts[c] != BS_NO_PART; c++) {
    S first[3], last[3], span[2];
    BS_UNROLL
    for (int i = 0; i < 3; i++) first[i] = boxes[sight->first[i] + c], last[i] = boxes[sight->last[i] + c];
    FN(cga3d_box_span)(span, sight->near, sight->far, sight->inverse, first, last, bounds);
    search->cost++;
    if (!(span[0] <= span[1])) continue;
    int place = count++;
    for (; place > before && waiting[place - 1].near < span[0]; place--) waiting[place] = waiting[place - 1];
    waiting[place].near = span[0], waiting[place].part = parts[c];
  }
  return count;
}

/* Ask every row that the ray may meet, the nearest boxes first; where any hit will do, until there is one. */
BS_INLINE void FN(scene_ask)(FN(search) *search, const bs_scene *scene, const FN(ray) *ray, int any)
{
  const bs_tree *const tree = &scene->tree;
  FN(waiting) waiting[BS_TREE_WAITING];
  FN(sight) sight;
  int count = 0;
  for (ptrdiff_t item = tree->loose; item < tree->item_count; item++) {
    if (any && search->count) return;
    FN(scene_ask_item)(search, scene, ray, item);
  }
  if (!tree->nodes || (any && search->count)) return;
  FN(tree_sight)(&sight, scene, ray);
  count = FN(tree_enter)(waiting, 0, scene, 0, search, &sight);
  while (count > 0) {
    const FN(waiting) next = waiting[--count];
    if (next.near > search->t_max) continue;
    if (next.part >= 0) {
      count = FN(tree_enter)(waiting, count, scene, next.part, search, &sight);
    } else {
      FN(scene_ask_item)(search, scene, ray, ~next.part);
      if (any && search->count) return;
    }
  }
}
