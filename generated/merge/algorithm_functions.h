/* Least and greatest landmark of some places of the tree; of none: infinite and minus infinite. */
BS_OUTLINED void FN(fill_box_14_nx7)(S box[BS_LENGTH(14)], ptrdiff_t begin, ptrdiff_t end, const ptrdiff_t *order,
    const S *leaves)
{
  for (ptrdiff_t i = 0; i < 7; i++) {
    box[i] = K(BS_HUGE_VALUE);
    box[7 + i] = -K(BS_HUGE_VALUE);
  }
  for (ptrdiff_t place = begin; place < end; place++) {
    if (order[place] < 0) {
      continue;
    }
    const ptrdiff_t x_at = 7 * place;
    for (ptrdiff_t i = 0; i < 7; i++) {
      box[i] = FN(bs_min)(box[i], leaves[x_at + i]);
      box[7 + i] = FN(bs_max)(box[7 + i], leaves[x_at + i]);
    }
  }
}

/* The widest of some parts of landmarks in units of the cost's root, and its width, if that is more than before. */
BS_OUTLINED void FN(wider_7_7_0_3)(const S least[BS_LENGTH(7)], const S most[BS_LENGTH(7)], S unit, ptrdiff_t axis,
    S width, ptrdiff_t *result0_, S *result1_)
{
  for (ptrdiff_t i = 0; i < 3; i++) {
    const S w = unit * (most[i] - least[i]);
    if (w > width) {
      width = w;
      axis = i;
    }
  }
  *result0_ = axis;
  *result1_ = width;
  return;
}

/* The widest of some parts of landmarks in units of the cost's root, and its width, if that is more than before. */
BS_OUTLINED void FN(wider_7_7_3_6)(const S least[BS_LENGTH(7)], const S most[BS_LENGTH(7)], S unit, ptrdiff_t axis,
    S width, ptrdiff_t *result0_, S *result1_)
{
  for (ptrdiff_t i = 3; i < 6; i++) {
    const S w = unit * (most[i] - least[i]);
    if (w > width) {
      width = w;
      axis = i;
    }
  }
  *result0_ = axis;
  *result1_ = width;
  return;
}

/* The part of the landmarks by which to part the objects of a box. */
BS_OUTLINED ptrdiff_t FN(widest_7_7)(const S least[BS_LENGTH(7)], const S most[BS_LENGTH(7)])
{
  ptrdiff_t axis = 0;
  if (most[6] > K(8.0) * least[6]) {
    return 6;
  }
  S width = K(0.0);
  if (most[6] == K(0.0)) {
    ptrdiff_t result;
    S result1;
    FN(wider_7_7_0_3)(least, most, SQRT(K(0.75)), axis, width, &result, &result1);
    axis = result;
    width = result1;
    ptrdiff_t result2;
    S result3;
    FN(wider_7_7_3_6)(least, most, SQRT(K(0.25)), axis, width, &result2, &result3);
    axis = result2;
    width = result3;
    return axis;
  }
  return axis;
}

/* Part some places so that what comes before the middle along an axis stands before it (Hoare's FIND). */
BS_OUTLINED void FN(part_at_nx7)(ptrdiff_t middle, ptrdiff_t begin, ptrdiff_t end, ptrdiff_t axis,
    const S *landmarks, ptrdiff_t *order)
{
  ptrdiff_t low = begin;
  ptrdiff_t high = end - 1;
  while (low < high) {
    const ptrdiff_t pivot = order[low + bs_quotient(high - low, 2)];
    const S x = landmarks[7 * pivot + axis];
    ptrdiff_t i = low;
    ptrdiff_t j = high;
    while (i <= j) {
      while ((landmarks[7 * order[i] + axis] < x) || (landmarks[7 * order[i] + axis] == x && order[i] < pivot)) {
        i = i + 1;
      }
      while ((x < landmarks[7 * order[j] + axis]) || (x == landmarks[7 * order[j] + axis] && pivot < order[j])) {
        j = j - 1;
      }
      if (i <= j) {
        const ptrdiff_t value = order[j];
        const ptrdiff_t value1 = order[i];
        order[i] = value;
        order[j] = value1;
        i = i + 1;
        j = j - 1;
      }
    }
    if (middle <= j) {
      high = j;
    } else {
      if (middle >= i) {
        low = i;
      } else {
        return;
      }
    }
  }
}

/* The tree over all objects that are left; the rounding of their positions, as a length. */
BS_OUTLINED S FN(build_tree_nx7_nx7_nx14)(ptrdiff_t tree[BS_LENGTH(2)], const S *landmarks, ptrdiff_t *slots,
    ptrdiff_t slots_count_, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes)
{
  ptrdiff_t built = 0;
  S size = K(0.0);
  for (ptrdiff_t slot = 0; slot < slots_count_; slot++) {
    if (slots[6 * slot] < 0) {
      continue;
    }
    order[built] = slot;
    built = built + 1;
    for (ptrdiff_t i = 0; i < 3; i++) {
      size = FN(bs_max)(size, ABS(landmarks[7 * slot + i]));
    }
  }
  ptrdiff_t first_leaf = 1;
  while (bs_quotient(built, first_leaf) > 12) {
    first_leaf = first_leaf * 2;
  }
  tree[0] = built;
  tree[1] = first_leaf;
  nodes[4] = 0;
  nodes[5] = built;
  ptrdiff_t waiting[40] = {0};
  waiting[0] = 1;
  ptrdiff_t depth = 1;
  while (depth > 0) {
    depth = depth - 1;
    const ptrdiff_t node = waiting[depth];
    const ptrdiff_t begin = nodes[3 * node + 1];
    const ptrdiff_t end = nodes[3 * node + 2];
    for (ptrdiff_t place = begin; place < end; place++) {
      for (ptrdiff_t k = 0; k < 7; k++) {
        leaves[7 * place + k] = landmarks[7 * order[place] + k];
      }
    }
    FN(fill_box_14_nx7)(boxes + 14 * node, begin, end, order, leaves);
    nodes[3 * node] = end - begin;
    if (node >= first_leaf) {
      for (ptrdiff_t place = begin; place < end; place++) {
        slots[6 * order[place] + 1] = place;
        slots[6 * order[place] + 2] = node;
      }
      continue;
    }
    ptrdiff_t first = 1;
    while (2 * first <= node) {
      first = first * 2;
    }
    const ptrdiff_t middle = bs_quotient(built * (2 * (node - first) + 1), 2 * first);
    const ptrdiff_t result = FN(widest_7_7)(boxes + 14 * node, boxes + 14 * node + 7);
    FN(part_at_nx7)(middle, begin, end, result, landmarks, order);
    nodes[3 * (2 * node) + 1] = begin;
    nodes[3 * (2 * node) + 2] = middle;
    nodes[3 * (2 * node + 1) + 1] = middle;
    nodes[3 * (2 * node + 1) + 2] = end;
    waiting[depth] = 2 * node + 1;
    waiting[depth + 1] = 2 * node;
    depth = depth + 2;
  }
  return K(1.4210854715202004e-14) * size;
}

/* Landmarks of all objects whose version is not negative, and the tree over them. */
BS_OUTLINED void FN(begin_point_nx5_nx7_nx7_nx14)(ptrdiff_t counts[BS_LENGTH(6)], S limits[BS_LENGTH(2)],
    const S *rows, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, ptrdiff_t *order, S *leaves,
    ptrdiff_t *nodes, S *boxes)
{
  for (ptrdiff_t slot = 0; slot < slots_count_; slot++) {
    if (slots[6 * slot] >= 0) {
      FN(cga3d_landmark_point)(landmarks + 7 * slot, rows + 5 * slot);
    }
  }
  const S result = FN(build_tree_nx7_nx7_nx14)(counts, landmarks, slots, slots_count_, order, leaves, nodes, boxes);
  limits[1] = result;
}

/* A cost of this object that may be all rounding: of a motor at its distance, of products of its coefficients. */
BS_OUTLINED S FN(rounding_cost_7)(const S x[BS_LENGTH(7)])
{
  const S size = K(1.0) + x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
  return K(2.0194839173657902e-28) * size;
}

/* Square of the distance of sign * x from a box. */
BS_OUTLINED S FN(gap_squared_3_3_3)(const S x[BS_LENGTH(3)], S sign, const S least[BS_LENGTH(3)],
    const S most[BS_LENGTH(3)])
{
  S total = K(0.0);
  for (ptrdiff_t i = 0; i < 3; i++) {
    const S gap = FN(bs_max)(K(0.0), FN(bs_max)(sign * x[i] - most[i], least[i] - sign * x[i]));
    total = total + gap * gap;
  }
  return total;
}

/* `gap_squared` of whichever of x and -x is nearer. */
BS_OUTLINED S FN(gap_of_axis_3_3_3)(const S x[BS_LENGTH(3)], const S least[BS_LENGTH(3)], const S most[BS_LENGTH(3)])
{
  const S result = FN(gap_squared_3_3_3)(x, K(1.0), least, most);
  const S same = result;
  const S result1 = FN(gap_squared_3_3_3)(x, K(-1.0), least, most);
  const S turned = result1;
  return FN(bs_min)(turned, same);
}

/* `least_cost` of flats and points. */
BS_OUTLINED S FN(least_flat_cost_7_7_7)(const S x[BS_LENGTH(7)], const S least[BS_LENGTH(7)],
    const S most[BS_LENGTH(7)], S slack)
{
  const S result = FN(gap_squared_3_3_3)(x, K(1.0), least, most);
  const S distance = FN(bs_max)(K(0.0), SQRT(result) - slack);
  const S result1 = FN(gap_of_axis_3_3_3)(x + 3, least + 3, most + 3);
  const S directions = result1;
  return K(0.75) * distance * distance + K(0.25) * directions;
}

/* No object whose landmark is in a box can have a lower cost with the object of landmark x. */
BS_OUTLINED S FN(least_cost_7_7_7)(const S x[BS_LENGTH(7)], const S least[BS_LENGTH(7)], const S most[BS_LENGTH(7)],
    S slack)
{
  const S result = FN(least_flat_cost_7_7_7)(x, least, most, slack);
  return K(0.999999999) * result;
}

/* The second of two objects, turned like the first where objects have no orientation. */
BS_OUTLINED void FN(turn_point_5_5_5)(int align, S turned[BS_LENGTH(5)], const S first[BS_LENGTH(5)],
    const S second[BS_LENGTH(5)])
{
  if (align) {
    FN(cga3d_align_point)(turned, second, first);
  } else {
    for (ptrdiff_t k = 0; k < 5; k++) {
      turned[k] = second[k];
    }
  }
}

/* The nearest object when some places of the tree have been looked at, too; its cost, and costs computed. */
BS_OUTLINED void FN(visit_leaf_point_nx5_nx7_nx7)(int align, ptrdiff_t slot, ptrdiff_t begin, ptrdiff_t end,
    S enough, ptrdiff_t nearest, S least, S slack, const S *rows, const S *weights, const S *landmarks,
    const ptrdiff_t *order, const S *leaves, ptrdiff_t *result0_, S *result1_, ptrdiff_t *result2_)
{
  ptrdiff_t evaluations = 0;
  const ptrdiff_t own_at = 7 * slot;
  S turned[5];
  for (ptrdiff_t place = begin; place < end; place++) {
    const ptrdiff_t other = order[place];
    if (other < 0 || other == slot) {
      continue;
    }
    const S result = FN(least_cost_7_7_7)(landmarks + own_at, leaves + 7 * place, leaves + 7 * place, slack);
    if (result > least) {
      continue;
    }
    const ptrdiff_t first = bs_min(slot, other);
    const ptrdiff_t second = bs_max(slot, other);
    FN(turn_point_5_5_5)(align, turned, rows + 5 * first, rows + 5 * second);
    S row[1];
    FN(cga3d_cost_point)(row, rows + 5 * first, turned);
    const S cost = row[0];
    evaluations = evaluations + 1;
    if (!((cost < least) || ((cost == least) && (nearest < 0 || other < nearest)))) {
      continue;
    }
    S row1[1];
    row1[0] = weights[first];
    S row2[1];
    row2[0] = weights[second];
    S mean[5];
    S row3[1];
    FN(cga3d_mean_point)(mean, row3, rows + 5 * first, turned, row1, row2);
    const S status = row3[0];
    if (status != K(0.0)) {
      continue;
    }
    least = cost;
    nearest = other;
    if (cost <= enough) {
      break;
    }
  }
  *result0_ = nearest;
  *result1_ = least;
  *result2_ = evaluations;
  return;
}

/* The other object of least cost within the threshold, of equal ones that of the lowest slot; costs computed. */
BS_OUTLINED void FN(find_nearest_point_nx5_nx7_nx7_nx14)(int align, ptrdiff_t slot, const S limits[BS_LENGTH(2)],
    const ptrdiff_t tree[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, const ptrdiff_t *slots,
    const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes, ptrdiff_t *result0_,
    S *result1_, ptrdiff_t *result2_)
{
  const ptrdiff_t own_at = 7 * slot;
  const S result = FN(rounding_cost_7)(landmarks + own_at);
  const S enough = result;
  const S slack = limits[1];
  ptrdiff_t nearest = -1;
  S least = limits[0];
  ptrdiff_t evaluations = 0;
  ptrdiff_t waiting[40] = {0};
  S bounds[40] = {0};
  waiting[0] = 1;
  ptrdiff_t depth = 1;
  while (depth > 0 && !(nearest >= 0 && least <= enough)) {
    depth = depth - 1;
    const ptrdiff_t node = waiting[depth];
    if (bounds[depth] > least) {
      continue;
    }
    if (node >= tree[1]) {
      ptrdiff_t result1;
      S result2;
      ptrdiff_t result3;
      FN(visit_leaf_point_nx5_nx7_nx7)(align, slot, nodes[3 * node + 1], nodes[3 * node + 2], enough, nearest, least,
          slack, rows, weights, landmarks, order, leaves, &result1, &result2, &result3);
      nearest = result1;
      least = result2;
      const ptrdiff_t count = result3;
      evaluations = evaluations + count;
      continue;
    }
    const ptrdiff_t left = 2 * node;
    const ptrdiff_t right = 2 * node + 1;
    S left_bound = K(BS_HUGE_VALUE);
    S right_bound = K(BS_HUGE_VALUE);
    if (nodes[3 * left] > 0) {
      const S result4 = FN(least_cost_7_7_7)(landmarks + own_at, boxes + 14 * left, boxes + 14 * left + 7, slack);
      left_bound = result4;
    }
    if (nodes[3 * right] > 0) {
      const S result5 = FN(least_cost_7_7_7)(landmarks + own_at, boxes + 14 * right, boxes + 14 * right + 7, slack);
      right_bound = result5;
    }
    int is_left_near = left_bound < right_bound;
    if (left_bound == right_bound) {
      ptrdiff_t home = slots[6 * slot + 2];
      while (home > right) {
        home = bs_quotient(home, 2);
      }
      is_left_near = home != right;
    }
    ptrdiff_t near = right;
    S near_bound = right_bound;
    ptrdiff_t far = left;
    S far_bound = left_bound;
    if (is_left_near) {
      near = left;
      near_bound = left_bound;
      far = right;
      far_bound = right_bound;
    }
    if (nodes[3 * far] > 0 && far_bound <= least) {
      waiting[depth] = far;
      bounds[depth] = far_bound;
      depth = depth + 1;
    }
    if (nodes[3 * near] > 0 && near_bound <= least) {
      waiting[depth] = near;
      bounds[depth] = near_bound;
      depth = depth + 1;
    }
  }
  *result0_ = nearest;
  *result1_ = least;
  *result2_ = evaluations;
  return;
}

/* Note a slot's nearest object; costs that were computed. */
BS_OUTLINED ptrdiff_t FN(look_point_nx5_nx7_nx7_nx14)(int align, ptrdiff_t slot, const S limits[BS_LENGTH(2)],
    const ptrdiff_t tree[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, ptrdiff_t *slots,
    S *costs, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes)
{
  ptrdiff_t result;
  S result1;
  ptrdiff_t result2;
  FN(find_nearest_point_nx5_nx7_nx7_nx14)(align, slot, limits, tree, rows, weights, landmarks, slots, order, leaves,
      nodes, boxes, &result, &result1, &result2);
  const ptrdiff_t nearest = result;
  const S cost = result1;
  const ptrdiff_t evaluations = result2;
  slots[6 * slot + 3] = nearest;
  slots[6 * slot + 4] = nearest < 0 ? 0 : slots[6 * nearest];
  costs[slot] = cost;
  return evaluations;
}

/* Nearest objects of those at some places of the new tree; costs that were computed. */
BS_OUTLINED ptrdiff_t FN(find_point_nx5_nx7_nx7_nx14)(int align, ptrdiff_t begin, ptrdiff_t end,
    const ptrdiff_t counts[BS_LENGTH(6)], const S limits[BS_LENGTH(2)], const S *rows, const S *weights,
    const S *landmarks, ptrdiff_t *slots, S *costs, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes,
    const S *boxes)
{
  ptrdiff_t evaluations = 0;
  for (ptrdiff_t place = begin; place < end; place++) {
    const ptrdiff_t slot = order[place];
    const ptrdiff_t result = FN(look_point_nx5_nx7_nx7_nx14)(align, slot, limits, counts, rows, weights, landmarks,
        slots, costs, order, leaves, nodes, boxes);
    const ptrdiff_t count = result;
    evaluations = evaluations + count;
  }
  return evaluations;
}

/* Whether slot a is cheaper than slot b. */
BS_OUTLINED int FN(comes_first)(ptrdiff_t a, ptrdiff_t b, const S *costs)
{
  return (costs[a] < costs[b]) || (costs[a] == costs[b] && a < b);
}

/* Bring a slot, whose place in the heap is free for others, to where its cost belongs. */
BS_OUTLINED void FN(settle)(ptrdiff_t place, ptrdiff_t slot, ptrdiff_t size, const S *costs, ptrdiff_t *heap,
    ptrdiff_t *slots)
{
  while (place > 0) {
    const ptrdiff_t parent = heap[bs_quotient(place - 1, 2)];
    const int result = FN(comes_first)(slot, parent, costs);
    if (!result) {
      break;
    }
    heap[place] = parent;
    slots[6 * parent + 5] = place;
    place = bs_quotient(place - 1, 2);
  }
  while (2 * place + 1 < size) {
    ptrdiff_t below = 2 * place + 1;
    const ptrdiff_t beside = bs_min(below + 1, size - 1);
    const int result1 = FN(comes_first)(heap[beside], heap[below], costs);
    if (result1) {
      below = beside;
    }
    const ptrdiff_t child = heap[below];
    const int result2 = FN(comes_first)(child, slot, costs);
    if (!result2) {
      break;
    }
    heap[place] = child;
    slots[6 * child + 5] = place;
    place = below;
  }
  heap[place] = slot;
  slots[6 * slot + 5] = place;
}

/* Queue all objects that have a nearest one. */
BS_OUTLINED void FN(queue)(ptrdiff_t counts[BS_LENGTH(6)], ptrdiff_t *slots, ptrdiff_t slots_count_, const S *costs,
    ptrdiff_t *heap)
{
  for (ptrdiff_t slot = 0; slot < slots_count_; slot++) {
    if (slots[6 * slot] >= 0 && slots[6 * slot + 3] >= 0) {
      counts[3] = counts[3] + 1;
      FN(settle)(counts[3] - 1, slot, counts[3], costs, heap, slots);
    }
  }
}

/* Take a slot out of the heap, if it is there; the size that is left. */
BS_OUTLINED ptrdiff_t FN(leave)(ptrdiff_t slot, ptrdiff_t size, const S *costs, ptrdiff_t *heap, ptrdiff_t *slots)
{
  const ptrdiff_t place = slots[6 * slot + 5];
  if (place < 0) {
    return size;
  }
  slots[6 * slot + 5] = -1;
  const ptrdiff_t last = heap[size - 1];
  if (last != slot) {
    FN(settle)(place, last, size - 1, costs, heap, slots);
  }
  return size - 1;
}

/* Look for a slot's nearest object, and queue it with that. */
BS_OUTLINED void FN(look_again_point_nx5_nx7_nx7_nx14)(int align, ptrdiff_t slot, ptrdiff_t counts[BS_LENGTH(6)],
    const S limits[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, ptrdiff_t *slots, S *costs,
    ptrdiff_t *heap, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes)
{
  const ptrdiff_t result = FN(look_point_nx5_nx7_nx7_nx14)(align, slot, limits, counts, rows, weights, landmarks,
      slots, costs, order, leaves, nodes, boxes);
  const ptrdiff_t evaluations = result;
  counts[5] = counts[5] + evaluations;
  if (slots[6 * slot + 3] < 0) {
    const ptrdiff_t result1 = FN(leave)(slot, counts[3], costs, heap, slots);
    counts[3] = result1;
    return;
  }
  ptrdiff_t place = slots[6 * slot + 5];
  if (place < 0) {
    place = counts[3];
    counts[3] = counts[3] + 1;
  }
  FN(settle)(place, slot, counts[3], costs, heap, slots);
}

/* Draw the boxes anew from an object's leaf to the root: it has moved (change 0), or gone (-1). */
BS_OUTLINED void FN(refit_nx7_nx7_nx14)(ptrdiff_t slot, ptrdiff_t change, const S *landmarks, const ptrdiff_t *slots,
    ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes)
{
  const ptrdiff_t place = slots[6 * slot + 1];
  ptrdiff_t node = slots[6 * slot + 2];
  if (change < 0) {
    order[place] = -1;
  } else {
    for (ptrdiff_t k = 0; k < 7; k++) {
      leaves[7 * place + k] = landmarks[7 * slot + k];
    }
  }
  FN(fill_box_14_nx7)(boxes + 14 * node, nodes[3 * node + 1], nodes[3 * node + 2], order, leaves);
  nodes[3 * node] = nodes[3 * node] + change;
  node = bs_quotient(node, 2);
  while (node > 0) {
    const ptrdiff_t box_at = 14 * node;
    const ptrdiff_t one_at = 14 * (2 * node);
    const ptrdiff_t other_at = 14 * (2 * node + 1);
    nodes[3 * node] = nodes[3 * node] + change;
    for (ptrdiff_t i = 0; i < 7; i++) {
      boxes[box_at + i] = FN(bs_min)(boxes[other_at + i], boxes[one_at + i]);
      boxes[box_at + (7 + i)] = FN(bs_max)(boxes[other_at + (7 + i)], boxes[one_at + (7 + i)]);
    }
    node = bs_quotient(node, 2);
  }
}

/* Replace an object and its nearest one by their mean. */
BS_OUTLINED void FN(merge_pair_point_nx5_nx7_nx7_nx14)(int align, ptrdiff_t slot, ptrdiff_t counts[BS_LENGTH(6)],
    S limits[BS_LENGTH(2)], S *rows, S *weights, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, S *costs,
    ptrdiff_t *heap, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes, S *merge_costs, ptrdiff_t *pairs)
{
  const ptrdiff_t kept = bs_min(slot, slots[6 * slot + 3]);
  const ptrdiff_t gone = bs_max(slot, slots[6 * slot + 3]);
  S turned[5];
  FN(turn_point_5_5_5)(align, turned, rows + 5 * kept, rows + 5 * gone);
  S row[1];
  row[0] = weights[kept];
  S row1[1];
  row1[0] = weights[gone];
  S mean[5];
  S row2[1];
  FN(cga3d_mean_point)(mean, row2, rows + 5 * kept, turned, row, row1);
  const S status = row2[0];
  if (status == K(0.0)) {
    for (ptrdiff_t k = 0; k < 5; k++) {
      rows[5 * kept + k] = mean[k];
    }
  }
  weights[kept] = weights[kept] + weights[gone];
  FN(cga3d_landmark_point)(landmarks + 7 * kept, rows + 5 * kept);
  slots[6 * kept] = slots[6 * kept] + 1;
  slots[6 * gone] = -1;
  counts[2] = counts[2] - 1;
  merge_costs[counts[4]] = costs[slot];
  pairs[2 * counts[4]] = kept;
  pairs[2 * counts[4] + 1] = gone;
  counts[4] = counts[4] + 1;
  const ptrdiff_t result = FN(leave)(gone, counts[3], costs, heap, slots);
  counts[3] = result;
  if (counts[2] * 4 < counts[0]) {
    const S result1 = FN(build_tree_nx7_nx7_nx14)(counts, landmarks, slots, slots_count_, order, leaves, nodes, boxes);
    limits[1] = result1;
  } else {
    FN(refit_nx7_nx7_nx14)(gone, -1, landmarks, slots, order, leaves, nodes, boxes);
    FN(refit_nx7_nx7_nx14)(kept, 0, landmarks, slots, order, leaves, nodes, boxes);
  }
  FN(look_again_point_nx5_nx7_nx7_nx14)(align, kept, counts, limits, rows, weights, landmarks, slots, costs, heap,
      order, leaves, nodes, boxes);
}

/* At most so many merges; fewer were done only if no pair is left. */
BS_OUTLINED ptrdiff_t FN(step_point_nx5_nx7_nx7_nx14)(int align, ptrdiff_t most, ptrdiff_t counts[BS_LENGTH(6)],
    S limits[BS_LENGTH(2)], S *rows, S *weights, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, S *costs,
    ptrdiff_t *heap, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes, S *merge_costs, ptrdiff_t *pairs)
{
  const ptrdiff_t before = counts[4];
  while (counts[3] > 0 && counts[4] - before < most) {
    const ptrdiff_t slot = heap[0];
    if (slots[6 * slots[6 * slot + 3]] != slots[6 * slot + 4]) {
      FN(look_again_point_nx5_nx7_nx7_nx14)(align, slot, counts, limits, rows, weights, landmarks, slots, costs, heap,
          order, leaves, nodes, boxes);
    } else {
      FN(merge_pair_point_nx5_nx7_nx7_nx14)(align, slot, counts, limits, rows, weights, landmarks, slots, slots_count_,
          costs, heap, order, leaves, nodes, boxes, merge_costs, pairs);
    }
  }
  return counts[4] - before;
}

/* Least and greatest landmark of some places of the tree; of none: infinite and minus infinite. */
BS_OUTLINED void FN(fill_box_44_nx22)(S box[BS_LENGTH(44)], ptrdiff_t begin, ptrdiff_t end, const ptrdiff_t *order,
    const S *leaves)
{
  for (ptrdiff_t i = 0; i < 22; i++) {
    box[i] = K(BS_HUGE_VALUE);
    box[22 + i] = -K(BS_HUGE_VALUE);
  }
  for (ptrdiff_t place = begin; place < end; place++) {
    if (order[place] < 0) {
      continue;
    }
    const ptrdiff_t x_at = 22 * place;
    for (ptrdiff_t i = 0; i < 22; i++) {
      box[i] = FN(bs_min)(box[i], leaves[x_at + i]);
      box[22 + i] = FN(bs_max)(box[22 + i], leaves[x_at + i]);
    }
  }
}

/* The widest of some parts of landmarks in units of the cost's root, and its width, if that is more than before. */
BS_OUTLINED void FN(wider_22_22_0_3)(const S least[BS_LENGTH(22)], const S most[BS_LENGTH(22)], S unit,
    ptrdiff_t axis, S width, ptrdiff_t *result0_, S *result1_)
{
  for (ptrdiff_t i = 0; i < 3; i++) {
    const S w = unit * (most[i] - least[i]);
    if (w > width) {
      width = w;
      axis = i;
    }
  }
  *result0_ = axis;
  *result1_ = width;
  return;
}

/* The widest of some parts of landmarks in units of the cost's root, and its width, if that is more than before. */
BS_OUTLINED void FN(wider_22_22_3_6)(const S least[BS_LENGTH(22)], const S most[BS_LENGTH(22)], S unit,
    ptrdiff_t axis, S width, ptrdiff_t *result0_, S *result1_)
{
  for (ptrdiff_t i = 3; i < 6; i++) {
    const S w = unit * (most[i] - least[i]);
    if (w > width) {
      width = w;
      axis = i;
    }
  }
  *result0_ = axis;
  *result1_ = width;
  return;
}

/* The widest of some parts of landmarks in units of the cost's root, and its width, if that is more than before. */
BS_OUTLINED void FN(wider_22_22_7_10)(const S least[BS_LENGTH(22)], const S most[BS_LENGTH(22)], S unit,
    ptrdiff_t axis, S width, ptrdiff_t *result0_, S *result1_)
{
  for (ptrdiff_t i = 7; i < 10; i++) {
    const S w = unit * (most[i] - least[i]);
    if (w > width) {
      width = w;
      axis = i;
    }
  }
  *result0_ = axis;
  *result1_ = width;
  return;
}

/* The widest of some parts of landmarks in units of the cost's root, and its width, if that is more than before. */
BS_OUTLINED void FN(wider_22_22_12_22)(const S least[BS_LENGTH(22)], const S most[BS_LENGTH(22)], S unit,
    ptrdiff_t axis, S width, ptrdiff_t *result0_, S *result1_)
{
  for (ptrdiff_t i = 12; i < 22; i++) {
    const S w = unit * (most[i] - least[i]);
    if (w > width) {
      width = w;
      axis = i;
    }
  }
  *result0_ = axis;
  *result1_ = width;
  return;
}

/* The part of the landmarks by which to part the objects of a box. */
BS_OUTLINED ptrdiff_t FN(widest_22_22)(const S least[BS_LENGTH(22)], const S most[BS_LENGTH(22)])
{
  ptrdiff_t axis = 0;
  if (most[6] > K(8.0) * least[6]) {
    return 6;
  }
  S width = K(0.0);
  if (most[6] == K(0.0)) {
    ptrdiff_t result;
    S result1;
    FN(wider_22_22_0_3)(least, most, SQRT(K(0.75)), axis, width, &result, &result1);
    axis = result;
    width = result1;
    ptrdiff_t result2;
    S result3;
    FN(wider_22_22_3_6)(least, most, SQRT(K(0.25)), axis, width, &result2, &result3);
    axis = result2;
    width = result3;
    return axis;
  }
  const S curved = least[6] * most[6];
  const S inverse = least[10] * most[10];
  ptrdiff_t result4;
  S result5;
  FN(wider_22_22_0_3)(least, most, SQRT(K(0.125)) * curved, axis, width, &result4, &result5);
  axis = result4;
  width = result5;
  ptrdiff_t result6;
  S result7;
  FN(wider_22_22_7_10)(least, most, SQRT(K(0.125)) * inverse, axis, width, &result6, &result7);
  axis = result6;
  width = result7;
  ptrdiff_t result8;
  S result9;
  FN(wider_22_22_12_22)(least, most, K(0.5) / most[11], axis, width, &result8, &result9);
  axis = result8;
  width = result9;
  return axis;
}

/* Part some places so that what comes before the middle along an axis stands before it (Hoare's FIND). */
BS_OUTLINED void FN(part_at_nx22)(ptrdiff_t middle, ptrdiff_t begin, ptrdiff_t end, ptrdiff_t axis,
    const S *landmarks, ptrdiff_t *order)
{
  ptrdiff_t low = begin;
  ptrdiff_t high = end - 1;
  while (low < high) {
    const ptrdiff_t pivot = order[low + bs_quotient(high - low, 2)];
    const S x = landmarks[22 * pivot + axis];
    ptrdiff_t i = low;
    ptrdiff_t j = high;
    while (i <= j) {
      while ((landmarks[22 * order[i] + axis] < x) || (landmarks[22 * order[i] + axis] == x && order[i] < pivot)) {
        i = i + 1;
      }
      while ((x < landmarks[22 * order[j] + axis]) || (x == landmarks[22 * order[j] + axis] && pivot < order[j])) {
        j = j - 1;
      }
      if (i <= j) {
        const ptrdiff_t value = order[j];
        const ptrdiff_t value1 = order[i];
        order[i] = value;
        order[j] = value1;
        i = i + 1;
        j = j - 1;
      }
    }
    if (middle <= j) {
      high = j;
    } else {
      if (middle >= i) {
        low = i;
      } else {
        return;
      }
    }
  }
}

/* The tree over all objects that are left; the rounding of their positions, as a length. */
BS_OUTLINED S FN(build_tree_nx22_nx22_nx44)(ptrdiff_t tree[BS_LENGTH(2)], const S *landmarks, ptrdiff_t *slots,
    ptrdiff_t slots_count_, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes)
{
  ptrdiff_t built = 0;
  S size = K(0.0);
  for (ptrdiff_t slot = 0; slot < slots_count_; slot++) {
    if (slots[6 * slot] < 0) {
      continue;
    }
    order[built] = slot;
    built = built + 1;
    for (ptrdiff_t i = 0; i < 3; i++) {
      size = FN(bs_max)(size, ABS(landmarks[22 * slot + i]));
    }
  }
  ptrdiff_t first_leaf = 1;
  while (bs_quotient(built, first_leaf) > 12) {
    first_leaf = first_leaf * 2;
  }
  tree[0] = built;
  tree[1] = first_leaf;
  nodes[4] = 0;
  nodes[5] = built;
  ptrdiff_t waiting[40] = {0};
  waiting[0] = 1;
  ptrdiff_t depth = 1;
  while (depth > 0) {
    depth = depth - 1;
    const ptrdiff_t node = waiting[depth];
    const ptrdiff_t begin = nodes[3 * node + 1];
    const ptrdiff_t end = nodes[3 * node + 2];
    for (ptrdiff_t place = begin; place < end; place++) {
      for (ptrdiff_t k = 0; k < 22; k++) {
        leaves[22 * place + k] = landmarks[22 * order[place] + k];
      }
    }
    FN(fill_box_44_nx22)(boxes + 44 * node, begin, end, order, leaves);
    nodes[3 * node] = end - begin;
    if (node >= first_leaf) {
      for (ptrdiff_t place = begin; place < end; place++) {
        slots[6 * order[place] + 1] = place;
        slots[6 * order[place] + 2] = node;
      }
      continue;
    }
    ptrdiff_t first = 1;
    while (2 * first <= node) {
      first = first * 2;
    }
    const ptrdiff_t middle = bs_quotient(built * (2 * (node - first) + 1), 2 * first);
    const ptrdiff_t result = FN(widest_22_22)(boxes + 44 * node, boxes + 44 * node + 22);
    FN(part_at_nx22)(middle, begin, end, result, landmarks, order);
    nodes[3 * (2 * node) + 1] = begin;
    nodes[3 * (2 * node) + 2] = middle;
    nodes[3 * (2 * node + 1) + 1] = middle;
    nodes[3 * (2 * node + 1) + 2] = end;
    waiting[depth] = 2 * node + 1;
    waiting[depth + 1] = 2 * node;
    depth = depth + 2;
  }
  return K(1.4210854715202004e-14) * size;
}

/* Landmarks of all objects whose version is not negative, and the tree over them. */
BS_OUTLINED void FN(begin_point_pair_nx10_nx22_nx22_nx44)(ptrdiff_t counts[BS_LENGTH(6)], S limits[BS_LENGTH(2)],
    const S *rows, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, ptrdiff_t *order, S *leaves,
    ptrdiff_t *nodes, S *boxes)
{
  for (ptrdiff_t slot = 0; slot < slots_count_; slot++) {
    if (slots[6 * slot] >= 0) {
      FN(cga3d_landmark_point_pair)(landmarks + 22 * slot, rows + 10 * slot);
    }
  }
  const S result = FN(build_tree_nx22_nx22_nx44)(counts, landmarks, slots, slots_count_, order, leaves, nodes, boxes);
  limits[1] = result;
}

/* A cost of this object that may be all rounding: of a motor at its distance, of products of its coefficients. */
BS_OUTLINED S FN(rounding_cost_22)(const S x[BS_LENGTH(22)])
{
  S size = K(1.0) + x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
  if (x[11] > K(1.0)) {
    size = x[11] * x[11] * x[11] * x[11];
  }
  return K(2.0194839173657902e-28) * size;
}

/* Square of the distance of sign * x from a box. */
BS_OUTLINED S FN(gap_squared_10_10_10)(const S x[BS_LENGTH(10)], S sign, const S least[BS_LENGTH(10)],
    const S most[BS_LENGTH(10)])
{
  S total = K(0.0);
  for (ptrdiff_t i = 0; i < 10; i++) {
    const S gap = FN(bs_max)(K(0.0), FN(bs_max)(sign * x[i] - most[i], least[i] - sign * x[i]));
    total = total + gap * gap;
  }
  return total;
}

/* `gap_squared` of whichever of x and -x is nearer. */
BS_OUTLINED S FN(gap_of_axis_10_10_10)(const S x[BS_LENGTH(10)], const S least[BS_LENGTH(10)],
    const S most[BS_LENGTH(10)])
{
  const S result = FN(gap_squared_10_10_10)(x, K(1.0), least, most);
  const S same = result;
  const S result1 = FN(gap_squared_10_10_10)(x, K(-1.0), least, most);
  const S turned = result1;
  return FN(bs_min)(turned, same);
}

/* `least_cost` of rounds and flats among them. */
BS_OUTLINED S FN(least_round_cost_22_22_22)(const S x[BS_LENGTH(22)], const S least[BS_LENGTH(22)],
    const S most[BS_LENGTH(22)])
{
  const S own = x[6];
  const S flattest = least[6];
  const S roundest = most[6];
  const S norms = x[11] * most[11];
  S defect = K(0.0);
  if (own > K(0.0) && flattest > K(0.0)) {
    const S result = FN(gap_squared_3_3_3)(x, K(1.0), least, most);
    defect = SQRT(result) * own * flattest;
  } else {
    if (own == K(0.0)) {
      defect = flattest;
    } else {
      if (roundest == K(0.0)) {
        defect = own;
      }
    }
  }
  const S product = x[10] * least[10];
  if (product > K(0.0)) {
    const S result1 = FN(gap_squared_3_3_3)(x + 7, K(1.0), least + 7, most + 7);
    const S inverse = result1;
    defect = FN(bs_max)(defect, product * SQRT(inverse));
  }
  defect = FN(bs_max)(K(0.0), SQRT(K(0.5)) * defect - K(1.4210854715202004e-14) * norms);
  const S by_place = (SQRT(K(1.0) + K(2.0) * defect) - K(1.0)) / K(2.0);
  const S result2 = FN(gap_of_axis_10_10_10)(x + 12, least + 12, most + 12);
  const S apart = SQRT(result2);
  const S by_coefficients = FN(bs_max)(K(0.0), apart / (x[11] + most[11]) - K(1.4210854715202004e-14));
  const S d = FN(bs_max)(by_coefficients, by_place);
  return d * d;
}

/* No object whose landmark is in a box can have a lower cost with the object of landmark x. */
BS_OUTLINED S FN(least_cost_22_22_22)(const S x[BS_LENGTH(22)], const S least[BS_LENGTH(22)],
    const S most[BS_LENGTH(22)], S slack)
{
  if (x[6] == K(0.0) && most[6] == K(0.0)) {
    const S result = FN(least_flat_cost_7_7_7)(x, least, most, slack);
    return K(0.999999999) * result;
  }
  const S result1 = FN(least_round_cost_22_22_22)(x, least, most);
  return K(0.999999999) * result1;
}

/* The second of two objects, turned like the first where objects have no orientation. */
BS_OUTLINED void FN(turn_point_pair_10_10_10)(int align, S turned[BS_LENGTH(10)], const S first[BS_LENGTH(10)],
    const S second[BS_LENGTH(10)])
{
  if (align) {
    FN(cga3d_align_point_pair)(turned, second, first);
  } else {
    for (ptrdiff_t k = 0; k < 10; k++) {
      turned[k] = second[k];
    }
  }
}

/* The nearest object when some places of the tree have been looked at, too; its cost, and costs computed. */
BS_OUTLINED void FN(visit_leaf_point_pair_nx10_nx22_nx22)(int align, ptrdiff_t slot, ptrdiff_t begin, ptrdiff_t end,
    S enough, ptrdiff_t nearest, S least, S slack, const S *rows, const S *weights, const S *landmarks,
    const ptrdiff_t *order, const S *leaves, ptrdiff_t *result0_, S *result1_, ptrdiff_t *result2_)
{
  ptrdiff_t evaluations = 0;
  const ptrdiff_t own_at = 22 * slot;
  S turned[10];
  for (ptrdiff_t place = begin; place < end; place++) {
    const ptrdiff_t other = order[place];
    if (other < 0 || other == slot) {
      continue;
    }
    const S result = FN(least_cost_22_22_22)(landmarks + own_at, leaves + 22 * place, leaves + 22 * place, slack);
    if (result > least) {
      continue;
    }
    const ptrdiff_t first = bs_min(slot, other);
    const ptrdiff_t second = bs_max(slot, other);
    FN(turn_point_pair_10_10_10)(align, turned, rows + 10 * first, rows + 10 * second);
    S row[1];
    FN(cga3d_cost_point_pair)(row, rows + 10 * first, turned);
    const S cost = row[0];
    evaluations = evaluations + 1;
    if (!((cost < least) || ((cost == least) && (nearest < 0 || other < nearest)))) {
      continue;
    }
    S row1[1];
    row1[0] = weights[first];
    S row2[1];
    row2[0] = weights[second];
    S mean[10];
    S row3[1];
    FN(cga3d_mean_point_pair)(mean, row3, rows + 10 * first, turned, row1, row2);
    const S status = row3[0];
    if (status != K(0.0)) {
      continue;
    }
    least = cost;
    nearest = other;
    if (cost <= enough) {
      break;
    }
  }
  *result0_ = nearest;
  *result1_ = least;
  *result2_ = evaluations;
  return;
}

/* The other object of least cost within the threshold, of equal ones that of the lowest slot; costs computed. */
BS_OUTLINED void FN(find_nearest_point_pair_nx10_nx22_nx22_nx44)(int align, ptrdiff_t slot,
    const S limits[BS_LENGTH(2)], const ptrdiff_t tree[BS_LENGTH(2)], const S *rows, const S *weights,
    const S *landmarks, const ptrdiff_t *slots, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes,
    const S *boxes, ptrdiff_t *result0_, S *result1_, ptrdiff_t *result2_)
{
  const ptrdiff_t own_at = 22 * slot;
  const S result = FN(rounding_cost_22)(landmarks + own_at);
  const S enough = result;
  const S slack = limits[1];
  ptrdiff_t nearest = -1;
  S least = limits[0];
  ptrdiff_t evaluations = 0;
  ptrdiff_t waiting[40] = {0};
  S bounds[40] = {0};
  waiting[0] = 1;
  ptrdiff_t depth = 1;
  while (depth > 0 && !(nearest >= 0 && least <= enough)) {
    depth = depth - 1;
    const ptrdiff_t node = waiting[depth];
    if (bounds[depth] > least) {
      continue;
    }
    if (node >= tree[1]) {
      ptrdiff_t result1;
      S result2;
      ptrdiff_t result3;
      FN(visit_leaf_point_pair_nx10_nx22_nx22)(align, slot, nodes[3 * node + 1], nodes[3 * node + 2], enough, nearest,
          least, slack, rows, weights, landmarks, order, leaves, &result1, &result2, &result3);
      nearest = result1;
      least = result2;
      const ptrdiff_t count = result3;
      evaluations = evaluations + count;
      continue;
    }
    const ptrdiff_t left = 2 * node;
    const ptrdiff_t right = 2 * node + 1;
    S left_bound = K(BS_HUGE_VALUE);
    S right_bound = K(BS_HUGE_VALUE);
    if (nodes[3 * left] > 0) {
      const S result4 = FN(least_cost_22_22_22)(landmarks + own_at, boxes + 44 * left, boxes + 44 * left + 22, slack);
      left_bound = result4;
    }
    if (nodes[3 * right] > 0) {
      const S result5 = FN(least_cost_22_22_22)(landmarks + own_at, boxes + 44 * right, boxes + 44 * right + 22, slack);
      right_bound = result5;
    }
    int is_left_near = left_bound < right_bound;
    if (left_bound == right_bound) {
      ptrdiff_t home = slots[6 * slot + 2];
      while (home > right) {
        home = bs_quotient(home, 2);
      }
      is_left_near = home != right;
    }
    ptrdiff_t near = right;
    S near_bound = right_bound;
    ptrdiff_t far = left;
    S far_bound = left_bound;
    if (is_left_near) {
      near = left;
      near_bound = left_bound;
      far = right;
      far_bound = right_bound;
    }
    if (nodes[3 * far] > 0 && far_bound <= least) {
      waiting[depth] = far;
      bounds[depth] = far_bound;
      depth = depth + 1;
    }
    if (nodes[3 * near] > 0 && near_bound <= least) {
      waiting[depth] = near;
      bounds[depth] = near_bound;
      depth = depth + 1;
    }
  }
  *result0_ = nearest;
  *result1_ = least;
  *result2_ = evaluations;
  return;
}

/* Note a slot's nearest object; costs that were computed. */
BS_OUTLINED ptrdiff_t FN(look_point_pair_nx10_nx22_nx22_nx44)(int align, ptrdiff_t slot,
    const S limits[BS_LENGTH(2)], const ptrdiff_t tree[BS_LENGTH(2)], const S *rows, const S *weights,
    const S *landmarks, ptrdiff_t *slots, S *costs, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes,
    const S *boxes)
{
  ptrdiff_t result;
  S result1;
  ptrdiff_t result2;
  FN(find_nearest_point_pair_nx10_nx22_nx22_nx44)(align, slot, limits, tree, rows, weights, landmarks, slots, order,
      leaves, nodes, boxes, &result, &result1, &result2);
  const ptrdiff_t nearest = result;
  const S cost = result1;
  const ptrdiff_t evaluations = result2;
  slots[6 * slot + 3] = nearest;
  slots[6 * slot + 4] = nearest < 0 ? 0 : slots[6 * nearest];
  costs[slot] = cost;
  return evaluations;
}

/* Nearest objects of those at some places of the new tree; costs that were computed. */
BS_OUTLINED ptrdiff_t FN(find_point_pair_nx10_nx22_nx22_nx44)(int align, ptrdiff_t begin, ptrdiff_t end,
    const ptrdiff_t counts[BS_LENGTH(6)], const S limits[BS_LENGTH(2)], const S *rows, const S *weights,
    const S *landmarks, ptrdiff_t *slots, S *costs, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes,
    const S *boxes)
{
  ptrdiff_t evaluations = 0;
  for (ptrdiff_t place = begin; place < end; place++) {
    const ptrdiff_t slot = order[place];
    const ptrdiff_t result = FN(look_point_pair_nx10_nx22_nx22_nx44)(align, slot, limits, counts, rows, weights,
        landmarks, slots, costs, order, leaves, nodes, boxes);
    const ptrdiff_t count = result;
    evaluations = evaluations + count;
  }
  return evaluations;
}

/* Look for a slot's nearest object, and queue it with that. */
BS_OUTLINED void FN(look_again_point_pair_nx10_nx22_nx22_nx44)(int align, ptrdiff_t slot,
    ptrdiff_t counts[BS_LENGTH(6)], const S limits[BS_LENGTH(2)], const S *rows, const S *weights,
    const S *landmarks, ptrdiff_t *slots, S *costs, ptrdiff_t *heap, const ptrdiff_t *order, const S *leaves,
    const ptrdiff_t *nodes, const S *boxes)
{
  const ptrdiff_t result = FN(look_point_pair_nx10_nx22_nx22_nx44)(align, slot, limits, counts, rows, weights,
      landmarks, slots, costs, order, leaves, nodes, boxes);
  const ptrdiff_t evaluations = result;
  counts[5] = counts[5] + evaluations;
  if (slots[6 * slot + 3] < 0) {
    const ptrdiff_t result1 = FN(leave)(slot, counts[3], costs, heap, slots);
    counts[3] = result1;
    return;
  }
  ptrdiff_t place = slots[6 * slot + 5];
  if (place < 0) {
    place = counts[3];
    counts[3] = counts[3] + 1;
  }
  FN(settle)(place, slot, counts[3], costs, heap, slots);
}

/* Draw the boxes anew from an object's leaf to the root: it has moved (change 0), or gone (-1). */
BS_OUTLINED void FN(refit_nx22_nx22_nx44)(ptrdiff_t slot, ptrdiff_t change, const S *landmarks,
    const ptrdiff_t *slots, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes)
{
  const ptrdiff_t place = slots[6 * slot + 1];
  ptrdiff_t node = slots[6 * slot + 2];
  if (change < 0) {
    order[place] = -1;
  } else {
    for (ptrdiff_t k = 0; k < 22; k++) {
      leaves[22 * place + k] = landmarks[22 * slot + k];
    }
  }
  FN(fill_box_44_nx22)(boxes + 44 * node, nodes[3 * node + 1], nodes[3 * node + 2], order, leaves);
  nodes[3 * node] = nodes[3 * node] + change;
  node = bs_quotient(node, 2);
  while (node > 0) {
    const ptrdiff_t box_at = 44 * node;
    const ptrdiff_t one_at = 44 * (2 * node);
    const ptrdiff_t other_at = 44 * (2 * node + 1);
    nodes[3 * node] = nodes[3 * node] + change;
    for (ptrdiff_t i = 0; i < 22; i++) {
      boxes[box_at + i] = FN(bs_min)(boxes[other_at + i], boxes[one_at + i]);
      boxes[box_at + (22 + i)] = FN(bs_max)(boxes[other_at + (22 + i)], boxes[one_at + (22 + i)]);
    }
    node = bs_quotient(node, 2);
  }
}

/* Replace an object and its nearest one by their mean. */
BS_OUTLINED void FN(merge_pair_point_pair_nx10_nx22_nx22_nx44)(int align, ptrdiff_t slot,
    ptrdiff_t counts[BS_LENGTH(6)], S limits[BS_LENGTH(2)], S *rows, S *weights, S *landmarks, ptrdiff_t *slots,
    ptrdiff_t slots_count_, S *costs, ptrdiff_t *heap, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes,
    S *merge_costs, ptrdiff_t *pairs)
{
  const ptrdiff_t kept = bs_min(slot, slots[6 * slot + 3]);
  const ptrdiff_t gone = bs_max(slot, slots[6 * slot + 3]);
  S turned[10];
  FN(turn_point_pair_10_10_10)(align, turned, rows + 10 * kept, rows + 10 * gone);
  S row[1];
  row[0] = weights[kept];
  S row1[1];
  row1[0] = weights[gone];
  S mean[10];
  S row2[1];
  FN(cga3d_mean_point_pair)(mean, row2, rows + 10 * kept, turned, row, row1);
  const S status = row2[0];
  if (status == K(0.0)) {
    for (ptrdiff_t k = 0; k < 10; k++) {
      rows[10 * kept + k] = mean[k];
    }
  }
  weights[kept] = weights[kept] + weights[gone];
  FN(cga3d_landmark_point_pair)(landmarks + 22 * kept, rows + 10 * kept);
  slots[6 * kept] = slots[6 * kept] + 1;
  slots[6 * gone] = -1;
  counts[2] = counts[2] - 1;
  merge_costs[counts[4]] = costs[slot];
  pairs[2 * counts[4]] = kept;
  pairs[2 * counts[4] + 1] = gone;
  counts[4] = counts[4] + 1;
  const ptrdiff_t result = FN(leave)(gone, counts[3], costs, heap, slots);
  counts[3] = result;
  if (counts[2] * 4 < counts[0]) {
    const S result1 = FN(build_tree_nx22_nx22_nx44)(counts, landmarks, slots, slots_count_, order, leaves, nodes, boxes);
    limits[1] = result1;
  } else {
    FN(refit_nx22_nx22_nx44)(gone, -1, landmarks, slots, order, leaves, nodes, boxes);
    FN(refit_nx22_nx22_nx44)(kept, 0, landmarks, slots, order, leaves, nodes, boxes);
  }
  FN(look_again_point_pair_nx10_nx22_nx22_nx44)(align, kept, counts, limits, rows, weights, landmarks, slots, costs,
      heap, order, leaves, nodes, boxes);
}

/* At most so many merges; fewer were done only if no pair is left. */
BS_OUTLINED ptrdiff_t FN(step_point_pair_nx10_nx22_nx22_nx44)(int align, ptrdiff_t most,
    ptrdiff_t counts[BS_LENGTH(6)], S limits[BS_LENGTH(2)], S *rows, S *weights, S *landmarks, ptrdiff_t *slots,
    ptrdiff_t slots_count_, S *costs, ptrdiff_t *heap, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes,
    S *merge_costs, ptrdiff_t *pairs)
{
  const ptrdiff_t before = counts[4];
  while (counts[3] > 0 && counts[4] - before < most) {
    const ptrdiff_t slot = heap[0];
    if (slots[6 * slots[6 * slot + 3]] != slots[6 * slot + 4]) {
      FN(look_again_point_pair_nx10_nx22_nx22_nx44)(align, slot, counts, limits, rows, weights, landmarks, slots, costs,
          heap, order, leaves, nodes, boxes);
    } else {
      FN(merge_pair_point_pair_nx10_nx22_nx22_nx44)(align, slot, counts, limits, rows, weights, landmarks, slots,
          slots_count_, costs, heap, order, leaves, nodes, boxes, merge_costs, pairs);
    }
  }
  return counts[4] - before;
}

/* Landmarks of all objects whose version is not negative, and the tree over them. */
BS_OUTLINED void FN(begin_line_nx6_nx7_nx7_nx14)(ptrdiff_t counts[BS_LENGTH(6)], S limits[BS_LENGTH(2)],
    const S *rows, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, ptrdiff_t *order, S *leaves,
    ptrdiff_t *nodes, S *boxes)
{
  for (ptrdiff_t slot = 0; slot < slots_count_; slot++) {
    if (slots[6 * slot] >= 0) {
      FN(cga3d_landmark_line)(landmarks + 7 * slot, rows + 6 * slot);
    }
  }
  const S result = FN(build_tree_nx7_nx7_nx14)(counts, landmarks, slots, slots_count_, order, leaves, nodes, boxes);
  limits[1] = result;
}

/* The second of two objects, turned like the first where objects have no orientation. */
BS_OUTLINED void FN(turn_line_6_6_6)(int align, S turned[BS_LENGTH(6)], const S first[BS_LENGTH(6)],
    const S second[BS_LENGTH(6)])
{
  if (align) {
    FN(cga3d_align_line)(turned, second, first);
  } else {
    for (ptrdiff_t k = 0; k < 6; k++) {
      turned[k] = second[k];
    }
  }
}

/* The nearest object when some places of the tree have been looked at, too; its cost, and costs computed. */
BS_OUTLINED void FN(visit_leaf_line_nx6_nx7_nx7)(int align, ptrdiff_t slot, ptrdiff_t begin, ptrdiff_t end, S enough,
    ptrdiff_t nearest, S least, S slack, const S *rows, const S *weights, const S *landmarks, const ptrdiff_t *order,
    const S *leaves, ptrdiff_t *result0_, S *result1_, ptrdiff_t *result2_)
{
  ptrdiff_t evaluations = 0;
  const ptrdiff_t own_at = 7 * slot;
  S turned[6];
  for (ptrdiff_t place = begin; place < end; place++) {
    const ptrdiff_t other = order[place];
    if (other < 0 || other == slot) {
      continue;
    }
    const S result = FN(least_cost_7_7_7)(landmarks + own_at, leaves + 7 * place, leaves + 7 * place, slack);
    if (result > least) {
      continue;
    }
    const ptrdiff_t first = bs_min(slot, other);
    const ptrdiff_t second = bs_max(slot, other);
    FN(turn_line_6_6_6)(align, turned, rows + 6 * first, rows + 6 * second);
    S row[1];
    FN(cga3d_cost_line)(row, rows + 6 * first, turned);
    const S cost = row[0];
    evaluations = evaluations + 1;
    if (!((cost < least) || ((cost == least) && (nearest < 0 || other < nearest)))) {
      continue;
    }
    S row1[1];
    row1[0] = weights[first];
    S row2[1];
    row2[0] = weights[second];
    S mean[6];
    S row3[1];
    FN(cga3d_mean_line)(mean, row3, rows + 6 * first, turned, row1, row2);
    const S status = row3[0];
    if (status != K(0.0)) {
      continue;
    }
    least = cost;
    nearest = other;
    if (cost <= enough) {
      break;
    }
  }
  *result0_ = nearest;
  *result1_ = least;
  *result2_ = evaluations;
  return;
}

/* The other object of least cost within the threshold, of equal ones that of the lowest slot; costs computed. */
BS_OUTLINED void FN(find_nearest_line_nx6_nx7_nx7_nx14)(int align, ptrdiff_t slot, const S limits[BS_LENGTH(2)],
    const ptrdiff_t tree[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, const ptrdiff_t *slots,
    const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes, ptrdiff_t *result0_,
    S *result1_, ptrdiff_t *result2_)
{
  const ptrdiff_t own_at = 7 * slot;
  const S result = FN(rounding_cost_7)(landmarks + own_at);
  const S enough = result;
  const S slack = limits[1];
  ptrdiff_t nearest = -1;
  S least = limits[0];
  ptrdiff_t evaluations = 0;
  ptrdiff_t waiting[40] = {0};
  S bounds[40] = {0};
  waiting[0] = 1;
  ptrdiff_t depth = 1;
  while (depth > 0 && !(nearest >= 0 && least <= enough)) {
    depth = depth - 1;
    const ptrdiff_t node = waiting[depth];
    if (bounds[depth] > least) {
      continue;
    }
    if (node >= tree[1]) {
      ptrdiff_t result1;
      S result2;
      ptrdiff_t result3;
      FN(visit_leaf_line_nx6_nx7_nx7)(align, slot, nodes[3 * node + 1], nodes[3 * node + 2], enough, nearest, least, slack,
          rows, weights, landmarks, order, leaves, &result1, &result2, &result3);
      nearest = result1;
      least = result2;
      const ptrdiff_t count = result3;
      evaluations = evaluations + count;
      continue;
    }
    const ptrdiff_t left = 2 * node;
    const ptrdiff_t right = 2 * node + 1;
    S left_bound = K(BS_HUGE_VALUE);
    S right_bound = K(BS_HUGE_VALUE);
    if (nodes[3 * left] > 0) {
      const S result4 = FN(least_cost_7_7_7)(landmarks + own_at, boxes + 14 * left, boxes + 14 * left + 7, slack);
      left_bound = result4;
    }
    if (nodes[3 * right] > 0) {
      const S result5 = FN(least_cost_7_7_7)(landmarks + own_at, boxes + 14 * right, boxes + 14 * right + 7, slack);
      right_bound = result5;
    }
    int is_left_near = left_bound < right_bound;
    if (left_bound == right_bound) {
      ptrdiff_t home = slots[6 * slot + 2];
      while (home > right) {
        home = bs_quotient(home, 2);
      }
      is_left_near = home != right;
    }
    ptrdiff_t near = right;
    S near_bound = right_bound;
    ptrdiff_t far = left;
    S far_bound = left_bound;
    if (is_left_near) {
      near = left;
      near_bound = left_bound;
      far = right;
      far_bound = right_bound;
    }
    if (nodes[3 * far] > 0 && far_bound <= least) {
      waiting[depth] = far;
      bounds[depth] = far_bound;
      depth = depth + 1;
    }
    if (nodes[3 * near] > 0 && near_bound <= least) {
      waiting[depth] = near;
      bounds[depth] = near_bound;
      depth = depth + 1;
    }
  }
  *result0_ = nearest;
  *result1_ = least;
  *result2_ = evaluations;
  return;
}

/* Note a slot's nearest object; costs that were computed. */
BS_OUTLINED ptrdiff_t FN(look_line_nx6_nx7_nx7_nx14)(int align, ptrdiff_t slot, const S limits[BS_LENGTH(2)],
    const ptrdiff_t tree[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, ptrdiff_t *slots,
    S *costs, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes)
{
  ptrdiff_t result;
  S result1;
  ptrdiff_t result2;
  FN(find_nearest_line_nx6_nx7_nx7_nx14)(align, slot, limits, tree, rows, weights, landmarks, slots, order, leaves,
      nodes, boxes, &result, &result1, &result2);
  const ptrdiff_t nearest = result;
  const S cost = result1;
  const ptrdiff_t evaluations = result2;
  slots[6 * slot + 3] = nearest;
  slots[6 * slot + 4] = nearest < 0 ? 0 : slots[6 * nearest];
  costs[slot] = cost;
  return evaluations;
}

/* Nearest objects of those at some places of the new tree; costs that were computed. */
BS_OUTLINED ptrdiff_t FN(find_line_nx6_nx7_nx7_nx14)(int align, ptrdiff_t begin, ptrdiff_t end,
    const ptrdiff_t counts[BS_LENGTH(6)], const S limits[BS_LENGTH(2)], const S *rows, const S *weights,
    const S *landmarks, ptrdiff_t *slots, S *costs, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes,
    const S *boxes)
{
  ptrdiff_t evaluations = 0;
  for (ptrdiff_t place = begin; place < end; place++) {
    const ptrdiff_t slot = order[place];
    const ptrdiff_t result = FN(look_line_nx6_nx7_nx7_nx14)(align, slot, limits, counts, rows, weights, landmarks, slots,
        costs, order, leaves, nodes, boxes);
    const ptrdiff_t count = result;
    evaluations = evaluations + count;
  }
  return evaluations;
}

/* Look for a slot's nearest object, and queue it with that. */
BS_OUTLINED void FN(look_again_line_nx6_nx7_nx7_nx14)(int align, ptrdiff_t slot, ptrdiff_t counts[BS_LENGTH(6)],
    const S limits[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, ptrdiff_t *slots, S *costs,
    ptrdiff_t *heap, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes)
{
  const ptrdiff_t result = FN(look_line_nx6_nx7_nx7_nx14)(align, slot, limits, counts, rows, weights, landmarks, slots,
      costs, order, leaves, nodes, boxes);
  const ptrdiff_t evaluations = result;
  counts[5] = counts[5] + evaluations;
  if (slots[6 * slot + 3] < 0) {
    const ptrdiff_t result1 = FN(leave)(slot, counts[3], costs, heap, slots);
    counts[3] = result1;
    return;
  }
  ptrdiff_t place = slots[6 * slot + 5];
  if (place < 0) {
    place = counts[3];
    counts[3] = counts[3] + 1;
  }
  FN(settle)(place, slot, counts[3], costs, heap, slots);
}

/* Replace an object and its nearest one by their mean. */
BS_OUTLINED void FN(merge_pair_line_nx6_nx7_nx7_nx14)(int align, ptrdiff_t slot, ptrdiff_t counts[BS_LENGTH(6)],
    S limits[BS_LENGTH(2)], S *rows, S *weights, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, S *costs,
    ptrdiff_t *heap, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes, S *merge_costs, ptrdiff_t *pairs)
{
  const ptrdiff_t kept = bs_min(slot, slots[6 * slot + 3]);
  const ptrdiff_t gone = bs_max(slot, slots[6 * slot + 3]);
  S turned[6];
  FN(turn_line_6_6_6)(align, turned, rows + 6 * kept, rows + 6 * gone);
  S row[1];
  row[0] = weights[kept];
  S row1[1];
  row1[0] = weights[gone];
  S mean[6];
  S row2[1];
  FN(cga3d_mean_line)(mean, row2, rows + 6 * kept, turned, row, row1);
  const S status = row2[0];
  if (status == K(0.0)) {
    for (ptrdiff_t k = 0; k < 6; k++) {
      rows[6 * kept + k] = mean[k];
    }
  }
  weights[kept] = weights[kept] + weights[gone];
  FN(cga3d_landmark_line)(landmarks + 7 * kept, rows + 6 * kept);
  slots[6 * kept] = slots[6 * kept] + 1;
  slots[6 * gone] = -1;
  counts[2] = counts[2] - 1;
  merge_costs[counts[4]] = costs[slot];
  pairs[2 * counts[4]] = kept;
  pairs[2 * counts[4] + 1] = gone;
  counts[4] = counts[4] + 1;
  const ptrdiff_t result = FN(leave)(gone, counts[3], costs, heap, slots);
  counts[3] = result;
  if (counts[2] * 4 < counts[0]) {
    const S result1 = FN(build_tree_nx7_nx7_nx14)(counts, landmarks, slots, slots_count_, order, leaves, nodes, boxes);
    limits[1] = result1;
  } else {
    FN(refit_nx7_nx7_nx14)(gone, -1, landmarks, slots, order, leaves, nodes, boxes);
    FN(refit_nx7_nx7_nx14)(kept, 0, landmarks, slots, order, leaves, nodes, boxes);
  }
  FN(look_again_line_nx6_nx7_nx7_nx14)(align, kept, counts, limits, rows, weights, landmarks, slots, costs, heap,
      order, leaves, nodes, boxes);
}

/* At most so many merges; fewer were done only if no pair is left. */
BS_OUTLINED ptrdiff_t FN(step_line_nx6_nx7_nx7_nx14)(int align, ptrdiff_t most, ptrdiff_t counts[BS_LENGTH(6)],
    S limits[BS_LENGTH(2)], S *rows, S *weights, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, S *costs,
    ptrdiff_t *heap, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes, S *merge_costs, ptrdiff_t *pairs)
{
  const ptrdiff_t before = counts[4];
  while (counts[3] > 0 && counts[4] - before < most) {
    const ptrdiff_t slot = heap[0];
    if (slots[6 * slots[6 * slot + 3]] != slots[6 * slot + 4]) {
      FN(look_again_line_nx6_nx7_nx7_nx14)(align, slot, counts, limits, rows, weights, landmarks, slots, costs, heap,
          order, leaves, nodes, boxes);
    } else {
      FN(merge_pair_line_nx6_nx7_nx7_nx14)(align, slot, counts, limits, rows, weights, landmarks, slots, slots_count_,
          costs, heap, order, leaves, nodes, boxes, merge_costs, pairs);
    }
  }
  return counts[4] - before;
}

/* Landmarks of all objects whose version is not negative, and the tree over them. */
BS_OUTLINED void FN(begin_circle_nx10_nx22_nx22_nx44)(ptrdiff_t counts[BS_LENGTH(6)], S limits[BS_LENGTH(2)],
    const S *rows, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, ptrdiff_t *order, S *leaves,
    ptrdiff_t *nodes, S *boxes)
{
  for (ptrdiff_t slot = 0; slot < slots_count_; slot++) {
    if (slots[6 * slot] >= 0) {
      FN(cga3d_landmark_circle)(landmarks + 22 * slot, rows + 10 * slot);
    }
  }
  const S result = FN(build_tree_nx22_nx22_nx44)(counts, landmarks, slots, slots_count_, order, leaves, nodes, boxes);
  limits[1] = result;
}

/* The second of two objects, turned like the first where objects have no orientation. */
BS_OUTLINED void FN(turn_circle_10_10_10)(int align, S turned[BS_LENGTH(10)], const S first[BS_LENGTH(10)],
    const S second[BS_LENGTH(10)])
{
  if (align) {
    FN(cga3d_align_circle)(turned, second, first);
  } else {
    for (ptrdiff_t k = 0; k < 10; k++) {
      turned[k] = second[k];
    }
  }
}

/* The nearest object when some places of the tree have been looked at, too; its cost, and costs computed. */
BS_OUTLINED void FN(visit_leaf_circle_nx10_nx22_nx22)(int align, ptrdiff_t slot, ptrdiff_t begin, ptrdiff_t end,
    S enough, ptrdiff_t nearest, S least, S slack, const S *rows, const S *weights, const S *landmarks,
    const ptrdiff_t *order, const S *leaves, ptrdiff_t *result0_, S *result1_, ptrdiff_t *result2_)
{
  ptrdiff_t evaluations = 0;
  const ptrdiff_t own_at = 22 * slot;
  S turned[10];
  for (ptrdiff_t place = begin; place < end; place++) {
    const ptrdiff_t other = order[place];
    if (other < 0 || other == slot) {
      continue;
    }
    const S result = FN(least_cost_22_22_22)(landmarks + own_at, leaves + 22 * place, leaves + 22 * place, slack);
    if (result > least) {
      continue;
    }
    const ptrdiff_t first = bs_min(slot, other);
    const ptrdiff_t second = bs_max(slot, other);
    FN(turn_circle_10_10_10)(align, turned, rows + 10 * first, rows + 10 * second);
    S row[1];
    FN(cga3d_cost_circle)(row, rows + 10 * first, turned);
    const S cost = row[0];
    evaluations = evaluations + 1;
    if (!((cost < least) || ((cost == least) && (nearest < 0 || other < nearest)))) {
      continue;
    }
    S row1[1];
    row1[0] = weights[first];
    S row2[1];
    row2[0] = weights[second];
    S mean[10];
    S row3[1];
    FN(cga3d_mean_circle)(mean, row3, rows + 10 * first, turned, row1, row2);
    const S status = row3[0];
    if (status != K(0.0)) {
      continue;
    }
    least = cost;
    nearest = other;
    if (cost <= enough) {
      break;
    }
  }
  *result0_ = nearest;
  *result1_ = least;
  *result2_ = evaluations;
  return;
}

/* The other object of least cost within the threshold, of equal ones that of the lowest slot; costs computed. */
BS_OUTLINED void FN(find_nearest_circle_nx10_nx22_nx22_nx44)(int align, ptrdiff_t slot, const S limits[BS_LENGTH(2)],
    const ptrdiff_t tree[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, const ptrdiff_t *slots,
    const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes, ptrdiff_t *result0_,
    S *result1_, ptrdiff_t *result2_)
{
  const ptrdiff_t own_at = 22 * slot;
  const S result = FN(rounding_cost_22)(landmarks + own_at);
  const S enough = result;
  const S slack = limits[1];
  ptrdiff_t nearest = -1;
  S least = limits[0];
  ptrdiff_t evaluations = 0;
  ptrdiff_t waiting[40] = {0};
  S bounds[40] = {0};
  waiting[0] = 1;
  ptrdiff_t depth = 1;
  while (depth > 0 && !(nearest >= 0 && least <= enough)) {
    depth = depth - 1;
    const ptrdiff_t node = waiting[depth];
    if (bounds[depth] > least) {
      continue;
    }
    if (node >= tree[1]) {
      ptrdiff_t result1;
      S result2;
      ptrdiff_t result3;
      FN(visit_leaf_circle_nx10_nx22_nx22)(align, slot, nodes[3 * node + 1], nodes[3 * node + 2], enough, nearest, least,
          slack, rows, weights, landmarks, order, leaves, &result1, &result2, &result3);
      nearest = result1;
      least = result2;
      const ptrdiff_t count = result3;
      evaluations = evaluations + count;
      continue;
    }
    const ptrdiff_t left = 2 * node;
    const ptrdiff_t right = 2 * node + 1;
    S left_bound = K(BS_HUGE_VALUE);
    S right_bound = K(BS_HUGE_VALUE);
    if (nodes[3 * left] > 0) {
      const S result4 = FN(least_cost_22_22_22)(landmarks + own_at, boxes + 44 * left, boxes + 44 * left + 22, slack);
      left_bound = result4;
    }
    if (nodes[3 * right] > 0) {
      const S result5 = FN(least_cost_22_22_22)(landmarks + own_at, boxes + 44 * right, boxes + 44 * right + 22, slack);
      right_bound = result5;
    }
    int is_left_near = left_bound < right_bound;
    if (left_bound == right_bound) {
      ptrdiff_t home = slots[6 * slot + 2];
      while (home > right) {
        home = bs_quotient(home, 2);
      }
      is_left_near = home != right;
    }
    ptrdiff_t near = right;
    S near_bound = right_bound;
    ptrdiff_t far = left;
    S far_bound = left_bound;
    if (is_left_near) {
      near = left;
      near_bound = left_bound;
      far = right;
      far_bound = right_bound;
    }
    if (nodes[3 * far] > 0 && far_bound <= least) {
      waiting[depth] = far;
      bounds[depth] = far_bound;
      depth = depth + 1;
    }
    if (nodes[3 * near] > 0 && near_bound <= least) {
      waiting[depth] = near;
      bounds[depth] = near_bound;
      depth = depth + 1;
    }
  }
  *result0_ = nearest;
  *result1_ = least;
  *result2_ = evaluations;
  return;
}

/* Note a slot's nearest object; costs that were computed. */
BS_OUTLINED ptrdiff_t FN(look_circle_nx10_nx22_nx22_nx44)(int align, ptrdiff_t slot, const S limits[BS_LENGTH(2)],
    const ptrdiff_t tree[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, ptrdiff_t *slots,
    S *costs, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes)
{
  ptrdiff_t result;
  S result1;
  ptrdiff_t result2;
  FN(find_nearest_circle_nx10_nx22_nx22_nx44)(align, slot, limits, tree, rows, weights, landmarks, slots, order,
      leaves, nodes, boxes, &result, &result1, &result2);
  const ptrdiff_t nearest = result;
  const S cost = result1;
  const ptrdiff_t evaluations = result2;
  slots[6 * slot + 3] = nearest;
  slots[6 * slot + 4] = nearest < 0 ? 0 : slots[6 * nearest];
  costs[slot] = cost;
  return evaluations;
}

/* Nearest objects of those at some places of the new tree; costs that were computed. */
BS_OUTLINED ptrdiff_t FN(find_circle_nx10_nx22_nx22_nx44)(int align, ptrdiff_t begin, ptrdiff_t end,
    const ptrdiff_t counts[BS_LENGTH(6)], const S limits[BS_LENGTH(2)], const S *rows, const S *weights,
    const S *landmarks, ptrdiff_t *slots, S *costs, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes,
    const S *boxes)
{
  ptrdiff_t evaluations = 0;
  for (ptrdiff_t place = begin; place < end; place++) {
    const ptrdiff_t slot = order[place];
    const ptrdiff_t result = FN(look_circle_nx10_nx22_nx22_nx44)(align, slot, limits, counts, rows, weights, landmarks,
        slots, costs, order, leaves, nodes, boxes);
    const ptrdiff_t count = result;
    evaluations = evaluations + count;
  }
  return evaluations;
}

/* Look for a slot's nearest object, and queue it with that. */
BS_OUTLINED void FN(look_again_circle_nx10_nx22_nx22_nx44)(int align, ptrdiff_t slot, ptrdiff_t counts[BS_LENGTH(6)],
    const S limits[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, ptrdiff_t *slots, S *costs,
    ptrdiff_t *heap, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes)
{
  const ptrdiff_t result = FN(look_circle_nx10_nx22_nx22_nx44)(align, slot, limits, counts, rows, weights, landmarks,
      slots, costs, order, leaves, nodes, boxes);
  const ptrdiff_t evaluations = result;
  counts[5] = counts[5] + evaluations;
  if (slots[6 * slot + 3] < 0) {
    const ptrdiff_t result1 = FN(leave)(slot, counts[3], costs, heap, slots);
    counts[3] = result1;
    return;
  }
  ptrdiff_t place = slots[6 * slot + 5];
  if (place < 0) {
    place = counts[3];
    counts[3] = counts[3] + 1;
  }
  FN(settle)(place, slot, counts[3], costs, heap, slots);
}

/* Replace an object and its nearest one by their mean. */
BS_OUTLINED void FN(merge_pair_circle_nx10_nx22_nx22_nx44)(int align, ptrdiff_t slot, ptrdiff_t counts[BS_LENGTH(6)],
    S limits[BS_LENGTH(2)], S *rows, S *weights, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, S *costs,
    ptrdiff_t *heap, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes, S *merge_costs, ptrdiff_t *pairs)
{
  const ptrdiff_t kept = bs_min(slot, slots[6 * slot + 3]);
  const ptrdiff_t gone = bs_max(slot, slots[6 * slot + 3]);
  S turned[10];
  FN(turn_circle_10_10_10)(align, turned, rows + 10 * kept, rows + 10 * gone);
  S row[1];
  row[0] = weights[kept];
  S row1[1];
  row1[0] = weights[gone];
  S mean[10];
  S row2[1];
  FN(cga3d_mean_circle)(mean, row2, rows + 10 * kept, turned, row, row1);
  const S status = row2[0];
  if (status == K(0.0)) {
    for (ptrdiff_t k = 0; k < 10; k++) {
      rows[10 * kept + k] = mean[k];
    }
  }
  weights[kept] = weights[kept] + weights[gone];
  FN(cga3d_landmark_circle)(landmarks + 22 * kept, rows + 10 * kept);
  slots[6 * kept] = slots[6 * kept] + 1;
  slots[6 * gone] = -1;
  counts[2] = counts[2] - 1;
  merge_costs[counts[4]] = costs[slot];
  pairs[2 * counts[4]] = kept;
  pairs[2 * counts[4] + 1] = gone;
  counts[4] = counts[4] + 1;
  const ptrdiff_t result = FN(leave)(gone, counts[3], costs, heap, slots);
  counts[3] = result;
  if (counts[2] * 4 < counts[0]) {
    const S result1 = FN(build_tree_nx22_nx22_nx44)(counts, landmarks, slots, slots_count_, order, leaves, nodes, boxes);
    limits[1] = result1;
  } else {
    FN(refit_nx22_nx22_nx44)(gone, -1, landmarks, slots, order, leaves, nodes, boxes);
    FN(refit_nx22_nx22_nx44)(kept, 0, landmarks, slots, order, leaves, nodes, boxes);
  }
  FN(look_again_circle_nx10_nx22_nx22_nx44)(align, kept, counts, limits, rows, weights, landmarks, slots, costs, heap,
      order, leaves, nodes, boxes);
}

/* At most so many merges; fewer were done only if no pair is left. */
BS_OUTLINED ptrdiff_t FN(step_circle_nx10_nx22_nx22_nx44)(int align, ptrdiff_t most, ptrdiff_t counts[BS_LENGTH(6)],
    S limits[BS_LENGTH(2)], S *rows, S *weights, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, S *costs,
    ptrdiff_t *heap, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes, S *merge_costs, ptrdiff_t *pairs)
{
  const ptrdiff_t before = counts[4];
  while (counts[3] > 0 && counts[4] - before < most) {
    const ptrdiff_t slot = heap[0];
    if (slots[6 * slots[6 * slot + 3]] != slots[6 * slot + 4]) {
      FN(look_again_circle_nx10_nx22_nx22_nx44)(align, slot, counts, limits, rows, weights, landmarks, slots, costs, heap,
          order, leaves, nodes, boxes);
    } else {
      FN(merge_pair_circle_nx10_nx22_nx22_nx44)(align, slot, counts, limits, rows, weights, landmarks, slots, slots_count_,
          costs, heap, order, leaves, nodes, boxes, merge_costs, pairs);
    }
  }
  return counts[4] - before;
}

/* Landmarks of all objects whose version is not negative, and the tree over them. */
BS_OUTLINED void FN(begin_plane_nx4_nx7_nx7_nx14)(ptrdiff_t counts[BS_LENGTH(6)], S limits[BS_LENGTH(2)],
    const S *rows, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, ptrdiff_t *order, S *leaves,
    ptrdiff_t *nodes, S *boxes)
{
  for (ptrdiff_t slot = 0; slot < slots_count_; slot++) {
    if (slots[6 * slot] >= 0) {
      FN(cga3d_landmark_plane)(landmarks + 7 * slot, rows + 4 * slot);
    }
  }
  const S result = FN(build_tree_nx7_nx7_nx14)(counts, landmarks, slots, slots_count_, order, leaves, nodes, boxes);
  limits[1] = result;
}

/* The second of two objects, turned like the first where objects have no orientation. */
BS_OUTLINED void FN(turn_plane_4_4_4)(int align, S turned[BS_LENGTH(4)], const S first[BS_LENGTH(4)],
    const S second[BS_LENGTH(4)])
{
  if (align) {
    FN(cga3d_align_plane)(turned, second, first);
  } else {
    for (ptrdiff_t k = 0; k < 4; k++) {
      turned[k] = second[k];
    }
  }
}

/* The nearest object when some places of the tree have been looked at, too; its cost, and costs computed. */
BS_OUTLINED void FN(visit_leaf_plane_nx4_nx7_nx7)(int align, ptrdiff_t slot, ptrdiff_t begin, ptrdiff_t end,
    S enough, ptrdiff_t nearest, S least, S slack, const S *rows, const S *weights, const S *landmarks,
    const ptrdiff_t *order, const S *leaves, ptrdiff_t *result0_, S *result1_, ptrdiff_t *result2_)
{
  ptrdiff_t evaluations = 0;
  const ptrdiff_t own_at = 7 * slot;
  S turned[4];
  for (ptrdiff_t place = begin; place < end; place++) {
    const ptrdiff_t other = order[place];
    if (other < 0 || other == slot) {
      continue;
    }
    const S result = FN(least_cost_7_7_7)(landmarks + own_at, leaves + 7 * place, leaves + 7 * place, slack);
    if (result > least) {
      continue;
    }
    const ptrdiff_t first = bs_min(slot, other);
    const ptrdiff_t second = bs_max(slot, other);
    FN(turn_plane_4_4_4)(align, turned, rows + 4 * first, rows + 4 * second);
    S row[1];
    FN(cga3d_cost_plane)(row, rows + 4 * first, turned);
    const S cost = row[0];
    evaluations = evaluations + 1;
    if (!((cost < least) || ((cost == least) && (nearest < 0 || other < nearest)))) {
      continue;
    }
    S row1[1];
    row1[0] = weights[first];
    S row2[1];
    row2[0] = weights[second];
    S mean[4];
    S row3[1];
    FN(cga3d_mean_plane)(mean, row3, rows + 4 * first, turned, row1, row2);
    const S status = row3[0];
    if (status != K(0.0)) {
      continue;
    }
    least = cost;
    nearest = other;
    if (cost <= enough) {
      break;
    }
  }
  *result0_ = nearest;
  *result1_ = least;
  *result2_ = evaluations;
  return;
}

/* The other object of least cost within the threshold, of equal ones that of the lowest slot; costs computed. */
BS_OUTLINED void FN(find_nearest_plane_nx4_nx7_nx7_nx14)(int align, ptrdiff_t slot, const S limits[BS_LENGTH(2)],
    const ptrdiff_t tree[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, const ptrdiff_t *slots,
    const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes, ptrdiff_t *result0_,
    S *result1_, ptrdiff_t *result2_)
{
  const ptrdiff_t own_at = 7 * slot;
  const S result = FN(rounding_cost_7)(landmarks + own_at);
  const S enough = result;
  const S slack = limits[1];
  ptrdiff_t nearest = -1;
  S least = limits[0];
  ptrdiff_t evaluations = 0;
  ptrdiff_t waiting[40] = {0};
  S bounds[40] = {0};
  waiting[0] = 1;
  ptrdiff_t depth = 1;
  while (depth > 0 && !(nearest >= 0 && least <= enough)) {
    depth = depth - 1;
    const ptrdiff_t node = waiting[depth];
    if (bounds[depth] > least) {
      continue;
    }
    if (node >= tree[1]) {
      ptrdiff_t result1;
      S result2;
      ptrdiff_t result3;
      FN(visit_leaf_plane_nx4_nx7_nx7)(align, slot, nodes[3 * node + 1], nodes[3 * node + 2], enough, nearest, least,
          slack, rows, weights, landmarks, order, leaves, &result1, &result2, &result3);
      nearest = result1;
      least = result2;
      const ptrdiff_t count = result3;
      evaluations = evaluations + count;
      continue;
    }
    const ptrdiff_t left = 2 * node;
    const ptrdiff_t right = 2 * node + 1;
    S left_bound = K(BS_HUGE_VALUE);
    S right_bound = K(BS_HUGE_VALUE);
    if (nodes[3 * left] > 0) {
      const S result4 = FN(least_cost_7_7_7)(landmarks + own_at, boxes + 14 * left, boxes + 14 * left + 7, slack);
      left_bound = result4;
    }
    if (nodes[3 * right] > 0) {
      const S result5 = FN(least_cost_7_7_7)(landmarks + own_at, boxes + 14 * right, boxes + 14 * right + 7, slack);
      right_bound = result5;
    }
    int is_left_near = left_bound < right_bound;
    if (left_bound == right_bound) {
      ptrdiff_t home = slots[6 * slot + 2];
      while (home > right) {
        home = bs_quotient(home, 2);
      }
      is_left_near = home != right;
    }
    ptrdiff_t near = right;
    S near_bound = right_bound;
    ptrdiff_t far = left;
    S far_bound = left_bound;
    if (is_left_near) {
      near = left;
      near_bound = left_bound;
      far = right;
      far_bound = right_bound;
    }
    if (nodes[3 * far] > 0 && far_bound <= least) {
      waiting[depth] = far;
      bounds[depth] = far_bound;
      depth = depth + 1;
    }
    if (nodes[3 * near] > 0 && near_bound <= least) {
      waiting[depth] = near;
      bounds[depth] = near_bound;
      depth = depth + 1;
    }
  }
  *result0_ = nearest;
  *result1_ = least;
  *result2_ = evaluations;
  return;
}

/* Note a slot's nearest object; costs that were computed. */
BS_OUTLINED ptrdiff_t FN(look_plane_nx4_nx7_nx7_nx14)(int align, ptrdiff_t slot, const S limits[BS_LENGTH(2)],
    const ptrdiff_t tree[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, ptrdiff_t *slots,
    S *costs, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes)
{
  ptrdiff_t result;
  S result1;
  ptrdiff_t result2;
  FN(find_nearest_plane_nx4_nx7_nx7_nx14)(align, slot, limits, tree, rows, weights, landmarks, slots, order, leaves,
      nodes, boxes, &result, &result1, &result2);
  const ptrdiff_t nearest = result;
  const S cost = result1;
  const ptrdiff_t evaluations = result2;
  slots[6 * slot + 3] = nearest;
  slots[6 * slot + 4] = nearest < 0 ? 0 : slots[6 * nearest];
  costs[slot] = cost;
  return evaluations;
}

/* Nearest objects of those at some places of the new tree; costs that were computed. */
BS_OUTLINED ptrdiff_t FN(find_plane_nx4_nx7_nx7_nx14)(int align, ptrdiff_t begin, ptrdiff_t end,
    const ptrdiff_t counts[BS_LENGTH(6)], const S limits[BS_LENGTH(2)], const S *rows, const S *weights,
    const S *landmarks, ptrdiff_t *slots, S *costs, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes,
    const S *boxes)
{
  ptrdiff_t evaluations = 0;
  for (ptrdiff_t place = begin; place < end; place++) {
    const ptrdiff_t slot = order[place];
    const ptrdiff_t result = FN(look_plane_nx4_nx7_nx7_nx14)(align, slot, limits, counts, rows, weights, landmarks,
        slots, costs, order, leaves, nodes, boxes);
    const ptrdiff_t count = result;
    evaluations = evaluations + count;
  }
  return evaluations;
}

/* Look for a slot's nearest object, and queue it with that. */
BS_OUTLINED void FN(look_again_plane_nx4_nx7_nx7_nx14)(int align, ptrdiff_t slot, ptrdiff_t counts[BS_LENGTH(6)],
    const S limits[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, ptrdiff_t *slots, S *costs,
    ptrdiff_t *heap, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes)
{
  const ptrdiff_t result = FN(look_plane_nx4_nx7_nx7_nx14)(align, slot, limits, counts, rows, weights, landmarks,
      slots, costs, order, leaves, nodes, boxes);
  const ptrdiff_t evaluations = result;
  counts[5] = counts[5] + evaluations;
  if (slots[6 * slot + 3] < 0) {
    const ptrdiff_t result1 = FN(leave)(slot, counts[3], costs, heap, slots);
    counts[3] = result1;
    return;
  }
  ptrdiff_t place = slots[6 * slot + 5];
  if (place < 0) {
    place = counts[3];
    counts[3] = counts[3] + 1;
  }
  FN(settle)(place, slot, counts[3], costs, heap, slots);
}

/* Replace an object and its nearest one by their mean. */
BS_OUTLINED void FN(merge_pair_plane_nx4_nx7_nx7_nx14)(int align, ptrdiff_t slot, ptrdiff_t counts[BS_LENGTH(6)],
    S limits[BS_LENGTH(2)], S *rows, S *weights, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, S *costs,
    ptrdiff_t *heap, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes, S *merge_costs, ptrdiff_t *pairs)
{
  const ptrdiff_t kept = bs_min(slot, slots[6 * slot + 3]);
  const ptrdiff_t gone = bs_max(slot, slots[6 * slot + 3]);
  S turned[4];
  FN(turn_plane_4_4_4)(align, turned, rows + 4 * kept, rows + 4 * gone);
  S row[1];
  row[0] = weights[kept];
  S row1[1];
  row1[0] = weights[gone];
  S mean[4];
  S row2[1];
  FN(cga3d_mean_plane)(mean, row2, rows + 4 * kept, turned, row, row1);
  const S status = row2[0];
  if (status == K(0.0)) {
    for (ptrdiff_t k = 0; k < 4; k++) {
      rows[4 * kept + k] = mean[k];
    }
  }
  weights[kept] = weights[kept] + weights[gone];
  FN(cga3d_landmark_plane)(landmarks + 7 * kept, rows + 4 * kept);
  slots[6 * kept] = slots[6 * kept] + 1;
  slots[6 * gone] = -1;
  counts[2] = counts[2] - 1;
  merge_costs[counts[4]] = costs[slot];
  pairs[2 * counts[4]] = kept;
  pairs[2 * counts[4] + 1] = gone;
  counts[4] = counts[4] + 1;
  const ptrdiff_t result = FN(leave)(gone, counts[3], costs, heap, slots);
  counts[3] = result;
  if (counts[2] * 4 < counts[0]) {
    const S result1 = FN(build_tree_nx7_nx7_nx14)(counts, landmarks, slots, slots_count_, order, leaves, nodes, boxes);
    limits[1] = result1;
  } else {
    FN(refit_nx7_nx7_nx14)(gone, -1, landmarks, slots, order, leaves, nodes, boxes);
    FN(refit_nx7_nx7_nx14)(kept, 0, landmarks, slots, order, leaves, nodes, boxes);
  }
  FN(look_again_plane_nx4_nx7_nx7_nx14)(align, kept, counts, limits, rows, weights, landmarks, slots, costs, heap,
      order, leaves, nodes, boxes);
}

/* At most so many merges; fewer were done only if no pair is left. */
BS_OUTLINED ptrdiff_t FN(step_plane_nx4_nx7_nx7_nx14)(int align, ptrdiff_t most, ptrdiff_t counts[BS_LENGTH(6)],
    S limits[BS_LENGTH(2)], S *rows, S *weights, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, S *costs,
    ptrdiff_t *heap, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes, S *merge_costs, ptrdiff_t *pairs)
{
  const ptrdiff_t before = counts[4];
  while (counts[3] > 0 && counts[4] - before < most) {
    const ptrdiff_t slot = heap[0];
    if (slots[6 * slots[6 * slot + 3]] != slots[6 * slot + 4]) {
      FN(look_again_plane_nx4_nx7_nx7_nx14)(align, slot, counts, limits, rows, weights, landmarks, slots, costs, heap,
          order, leaves, nodes, boxes);
    } else {
      FN(merge_pair_plane_nx4_nx7_nx7_nx14)(align, slot, counts, limits, rows, weights, landmarks, slots, slots_count_,
          costs, heap, order, leaves, nodes, boxes, merge_costs, pairs);
    }
  }
  return counts[4] - before;
}

/* Least and greatest landmark of some places of the tree; of none: infinite and minus infinite. */
BS_OUTLINED void FN(fill_box_34_nx17)(S box[BS_LENGTH(34)], ptrdiff_t begin, ptrdiff_t end, const ptrdiff_t *order,
    const S *leaves)
{
  for (ptrdiff_t i = 0; i < 17; i++) {
    box[i] = K(BS_HUGE_VALUE);
    box[17 + i] = -K(BS_HUGE_VALUE);
  }
  for (ptrdiff_t place = begin; place < end; place++) {
    if (order[place] < 0) {
      continue;
    }
    const ptrdiff_t x_at = 17 * place;
    for (ptrdiff_t i = 0; i < 17; i++) {
      box[i] = FN(bs_min)(box[i], leaves[x_at + i]);
      box[17 + i] = FN(bs_max)(box[17 + i], leaves[x_at + i]);
    }
  }
}

/* The widest of some parts of landmarks in units of the cost's root, and its width, if that is more than before. */
BS_OUTLINED void FN(wider_17_17_0_3)(const S least[BS_LENGTH(17)], const S most[BS_LENGTH(17)], S unit,
    ptrdiff_t axis, S width, ptrdiff_t *result0_, S *result1_)
{
  for (ptrdiff_t i = 0; i < 3; i++) {
    const S w = unit * (most[i] - least[i]);
    if (w > width) {
      width = w;
      axis = i;
    }
  }
  *result0_ = axis;
  *result1_ = width;
  return;
}

/* The widest of some parts of landmarks in units of the cost's root, and its width, if that is more than before. */
BS_OUTLINED void FN(wider_17_17_3_6)(const S least[BS_LENGTH(17)], const S most[BS_LENGTH(17)], S unit,
    ptrdiff_t axis, S width, ptrdiff_t *result0_, S *result1_)
{
  for (ptrdiff_t i = 3; i < 6; i++) {
    const S w = unit * (most[i] - least[i]);
    if (w > width) {
      width = w;
      axis = i;
    }
  }
  *result0_ = axis;
  *result1_ = width;
  return;
}

/* The widest of some parts of landmarks in units of the cost's root, and its width, if that is more than before. */
BS_OUTLINED void FN(wider_17_17_7_10)(const S least[BS_LENGTH(17)], const S most[BS_LENGTH(17)], S unit,
    ptrdiff_t axis, S width, ptrdiff_t *result0_, S *result1_)
{
  for (ptrdiff_t i = 7; i < 10; i++) {
    const S w = unit * (most[i] - least[i]);
    if (w > width) {
      width = w;
      axis = i;
    }
  }
  *result0_ = axis;
  *result1_ = width;
  return;
}

/* The widest of some parts of landmarks in units of the cost's root, and its width, if that is more than before. */
BS_OUTLINED void FN(wider_17_17_12_17)(const S least[BS_LENGTH(17)], const S most[BS_LENGTH(17)], S unit,
    ptrdiff_t axis, S width, ptrdiff_t *result0_, S *result1_)
{
  for (ptrdiff_t i = 12; i < 17; i++) {
    const S w = unit * (most[i] - least[i]);
    if (w > width) {
      width = w;
      axis = i;
    }
  }
  *result0_ = axis;
  *result1_ = width;
  return;
}

/* The part of the landmarks by which to part the objects of a box. */
BS_OUTLINED ptrdiff_t FN(widest_17_17)(const S least[BS_LENGTH(17)], const S most[BS_LENGTH(17)])
{
  ptrdiff_t axis = 0;
  if (most[6] > K(8.0) * least[6]) {
    return 6;
  }
  S width = K(0.0);
  if (most[6] == K(0.0)) {
    ptrdiff_t result;
    S result1;
    FN(wider_17_17_0_3)(least, most, SQRT(K(0.75)), axis, width, &result, &result1);
    axis = result;
    width = result1;
    ptrdiff_t result2;
    S result3;
    FN(wider_17_17_3_6)(least, most, SQRT(K(0.25)), axis, width, &result2, &result3);
    axis = result2;
    width = result3;
    return axis;
  }
  const S curved = least[6] * most[6];
  const S inverse = least[10] * most[10];
  ptrdiff_t result4;
  S result5;
  FN(wider_17_17_0_3)(least, most, SQRT(K(0.125)) * curved, axis, width, &result4, &result5);
  axis = result4;
  width = result5;
  ptrdiff_t result6;
  S result7;
  FN(wider_17_17_7_10)(least, most, SQRT(K(0.125)) * inverse, axis, width, &result6, &result7);
  axis = result6;
  width = result7;
  ptrdiff_t result8;
  S result9;
  FN(wider_17_17_12_17)(least, most, K(0.5) / most[11], axis, width, &result8, &result9);
  axis = result8;
  width = result9;
  return axis;
}

/* Part some places so that what comes before the middle along an axis stands before it (Hoare's FIND). */
BS_OUTLINED void FN(part_at_nx17)(ptrdiff_t middle, ptrdiff_t begin, ptrdiff_t end, ptrdiff_t axis,
    const S *landmarks, ptrdiff_t *order)
{
  ptrdiff_t low = begin;
  ptrdiff_t high = end - 1;
  while (low < high) {
    const ptrdiff_t pivot = order[low + bs_quotient(high - low, 2)];
    const S x = landmarks[17 * pivot + axis];
    ptrdiff_t i = low;
    ptrdiff_t j = high;
    while (i <= j) {
      while ((landmarks[17 * order[i] + axis] < x) || (landmarks[17 * order[i] + axis] == x && order[i] < pivot)) {
        i = i + 1;
      }
      while ((x < landmarks[17 * order[j] + axis]) || (x == landmarks[17 * order[j] + axis] && pivot < order[j])) {
        j = j - 1;
      }
      if (i <= j) {
        const ptrdiff_t value = order[j];
        const ptrdiff_t value1 = order[i];
        order[i] = value;
        order[j] = value1;
        i = i + 1;
        j = j - 1;
      }
    }
    if (middle <= j) {
      high = j;
    } else {
      if (middle >= i) {
        low = i;
      } else {
        return;
      }
    }
  }
}

/* The tree over all objects that are left; the rounding of their positions, as a length. */
BS_OUTLINED S FN(build_tree_nx17_nx17_nx34)(ptrdiff_t tree[BS_LENGTH(2)], const S *landmarks, ptrdiff_t *slots,
    ptrdiff_t slots_count_, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes)
{
  ptrdiff_t built = 0;
  S size = K(0.0);
  for (ptrdiff_t slot = 0; slot < slots_count_; slot++) {
    if (slots[6 * slot] < 0) {
      continue;
    }
    order[built] = slot;
    built = built + 1;
    for (ptrdiff_t i = 0; i < 3; i++) {
      size = FN(bs_max)(size, ABS(landmarks[17 * slot + i]));
    }
  }
  ptrdiff_t first_leaf = 1;
  while (bs_quotient(built, first_leaf) > 12) {
    first_leaf = first_leaf * 2;
  }
  tree[0] = built;
  tree[1] = first_leaf;
  nodes[4] = 0;
  nodes[5] = built;
  ptrdiff_t waiting[40] = {0};
  waiting[0] = 1;
  ptrdiff_t depth = 1;
  while (depth > 0) {
    depth = depth - 1;
    const ptrdiff_t node = waiting[depth];
    const ptrdiff_t begin = nodes[3 * node + 1];
    const ptrdiff_t end = nodes[3 * node + 2];
    for (ptrdiff_t place = begin; place < end; place++) {
      for (ptrdiff_t k = 0; k < 17; k++) {
        leaves[17 * place + k] = landmarks[17 * order[place] + k];
      }
    }
    FN(fill_box_34_nx17)(boxes + 34 * node, begin, end, order, leaves);
    nodes[3 * node] = end - begin;
    if (node >= first_leaf) {
      for (ptrdiff_t place = begin; place < end; place++) {
        slots[6 * order[place] + 1] = place;
        slots[6 * order[place] + 2] = node;
      }
      continue;
    }
    ptrdiff_t first = 1;
    while (2 * first <= node) {
      first = first * 2;
    }
    const ptrdiff_t middle = bs_quotient(built * (2 * (node - first) + 1), 2 * first);
    const ptrdiff_t result = FN(widest_17_17)(boxes + 34 * node, boxes + 34 * node + 17);
    FN(part_at_nx17)(middle, begin, end, result, landmarks, order);
    nodes[3 * (2 * node) + 1] = begin;
    nodes[3 * (2 * node) + 2] = middle;
    nodes[3 * (2 * node + 1) + 1] = middle;
    nodes[3 * (2 * node + 1) + 2] = end;
    waiting[depth] = 2 * node + 1;
    waiting[depth + 1] = 2 * node;
    depth = depth + 2;
  }
  return K(1.4210854715202004e-14) * size;
}

/* Landmarks of all objects whose version is not negative, and the tree over them. */
BS_OUTLINED void FN(begin_sphere_nx5_nx17_nx17_nx34)(ptrdiff_t counts[BS_LENGTH(6)], S limits[BS_LENGTH(2)],
    const S *rows, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, ptrdiff_t *order, S *leaves,
    ptrdiff_t *nodes, S *boxes)
{
  for (ptrdiff_t slot = 0; slot < slots_count_; slot++) {
    if (slots[6 * slot] >= 0) {
      FN(cga3d_landmark_sphere)(landmarks + 17 * slot, rows + 5 * slot);
    }
  }
  const S result = FN(build_tree_nx17_nx17_nx34)(counts, landmarks, slots, slots_count_, order, leaves, nodes, boxes);
  limits[1] = result;
}

/* A cost of this object that may be all rounding: of a motor at its distance, of products of its coefficients. */
BS_OUTLINED S FN(rounding_cost_17)(const S x[BS_LENGTH(17)])
{
  S size = K(1.0) + x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
  if (x[11] > K(1.0)) {
    size = x[11] * x[11] * x[11] * x[11];
  }
  return K(2.0194839173657902e-28) * size;
}

/* Square of the distance of sign * x from a box. */
BS_OUTLINED S FN(gap_squared_5_5_5)(const S x[BS_LENGTH(5)], S sign, const S least[BS_LENGTH(5)],
    const S most[BS_LENGTH(5)])
{
  S total = K(0.0);
  for (ptrdiff_t i = 0; i < 5; i++) {
    const S gap = FN(bs_max)(K(0.0), FN(bs_max)(sign * x[i] - most[i], least[i] - sign * x[i]));
    total = total + gap * gap;
  }
  return total;
}

/* `gap_squared` of whichever of x and -x is nearer. */
BS_OUTLINED S FN(gap_of_axis_5_5_5)(const S x[BS_LENGTH(5)], const S least[BS_LENGTH(5)], const S most[BS_LENGTH(5)])
{
  const S result = FN(gap_squared_5_5_5)(x, K(1.0), least, most);
  const S same = result;
  const S result1 = FN(gap_squared_5_5_5)(x, K(-1.0), least, most);
  const S turned = result1;
  return FN(bs_min)(turned, same);
}

/* `least_cost` of rounds and flats among them. */
BS_OUTLINED S FN(least_round_cost_17_17_17)(const S x[BS_LENGTH(17)], const S least[BS_LENGTH(17)],
    const S most[BS_LENGTH(17)])
{
  const S own = x[6];
  const S flattest = least[6];
  const S roundest = most[6];
  const S norms = x[11] * most[11];
  S defect = K(0.0);
  if (own > K(0.0) && flattest > K(0.0)) {
    const S result = FN(gap_squared_3_3_3)(x, K(1.0), least, most);
    defect = SQRT(result) * own * flattest;
  } else {
    if (own == K(0.0)) {
      defect = flattest;
    } else {
      if (roundest == K(0.0)) {
        defect = own;
      }
    }
  }
  const S product = x[10] * least[10];
  if (product > K(0.0)) {
    const S result1 = FN(gap_squared_3_3_3)(x + 7, K(1.0), least + 7, most + 7);
    const S inverse = result1;
    defect = FN(bs_max)(defect, product * SQRT(inverse));
  }
  defect = FN(bs_max)(K(0.0), SQRT(K(0.5)) * defect - K(1.4210854715202004e-14) * norms);
  const S by_place = (SQRT(K(1.0) + K(2.0) * defect) - K(1.0)) / K(2.0);
  const S result2 = FN(gap_of_axis_5_5_5)(x + 12, least + 12, most + 12);
  const S apart = SQRT(result2);
  const S by_coefficients = FN(bs_max)(K(0.0), apart / (x[11] + most[11]) - K(1.4210854715202004e-14));
  const S d = FN(bs_max)(by_coefficients, by_place);
  return d * d;
}

/* No object whose landmark is in a box can have a lower cost with the object of landmark x. */
BS_OUTLINED S FN(least_cost_17_17_17)(const S x[BS_LENGTH(17)], const S least[BS_LENGTH(17)],
    const S most[BS_LENGTH(17)], S slack)
{
  if (x[6] == K(0.0) && most[6] == K(0.0)) {
    const S result = FN(least_flat_cost_7_7_7)(x, least, most, slack);
    return K(0.999999999) * result;
  }
  const S result1 = FN(least_round_cost_17_17_17)(x, least, most);
  return K(0.999999999) * result1;
}

/* The second of two objects, turned like the first where objects have no orientation. */
BS_OUTLINED void FN(turn_sphere_5_5_5)(int align, S turned[BS_LENGTH(5)], const S first[BS_LENGTH(5)],
    const S second[BS_LENGTH(5)])
{
  if (align) {
    FN(cga3d_align_sphere)(turned, second, first);
  } else {
    for (ptrdiff_t k = 0; k < 5; k++) {
      turned[k] = second[k];
    }
  }
}

/* The nearest object when some places of the tree have been looked at, too; its cost, and costs computed. */
BS_OUTLINED void FN(visit_leaf_sphere_nx5_nx17_nx17)(int align, ptrdiff_t slot, ptrdiff_t begin, ptrdiff_t end,
    S enough, ptrdiff_t nearest, S least, S slack, const S *rows, const S *weights, const S *landmarks,
    const ptrdiff_t *order, const S *leaves, ptrdiff_t *result0_, S *result1_, ptrdiff_t *result2_)
{
  ptrdiff_t evaluations = 0;
  const ptrdiff_t own_at = 17 * slot;
  S turned[5];
  for (ptrdiff_t place = begin; place < end; place++) {
    const ptrdiff_t other = order[place];
    if (other < 0 || other == slot) {
      continue;
    }
    const S result = FN(least_cost_17_17_17)(landmarks + own_at, leaves + 17 * place, leaves + 17 * place, slack);
    if (result > least) {
      continue;
    }
    const ptrdiff_t first = bs_min(slot, other);
    const ptrdiff_t second = bs_max(slot, other);
    FN(turn_sphere_5_5_5)(align, turned, rows + 5 * first, rows + 5 * second);
    S row[1];
    FN(cga3d_cost_sphere)(row, rows + 5 * first, turned);
    const S cost = row[0];
    evaluations = evaluations + 1;
    if (!((cost < least) || ((cost == least) && (nearest < 0 || other < nearest)))) {
      continue;
    }
    S row1[1];
    row1[0] = weights[first];
    S row2[1];
    row2[0] = weights[second];
    S mean[5];
    S row3[1];
    FN(cga3d_mean_sphere)(mean, row3, rows + 5 * first, turned, row1, row2);
    const S status = row3[0];
    if (status != K(0.0)) {
      continue;
    }
    least = cost;
    nearest = other;
    if (cost <= enough) {
      break;
    }
  }
  *result0_ = nearest;
  *result1_ = least;
  *result2_ = evaluations;
  return;
}

/* The other object of least cost within the threshold, of equal ones that of the lowest slot; costs computed. */
BS_OUTLINED void FN(find_nearest_sphere_nx5_nx17_nx17_nx34)(int align, ptrdiff_t slot, const S limits[BS_LENGTH(2)],
    const ptrdiff_t tree[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, const ptrdiff_t *slots,
    const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes, ptrdiff_t *result0_,
    S *result1_, ptrdiff_t *result2_)
{
  const ptrdiff_t own_at = 17 * slot;
  const S result = FN(rounding_cost_17)(landmarks + own_at);
  const S enough = result;
  const S slack = limits[1];
  ptrdiff_t nearest = -1;
  S least = limits[0];
  ptrdiff_t evaluations = 0;
  ptrdiff_t waiting[40] = {0};
  S bounds[40] = {0};
  waiting[0] = 1;
  ptrdiff_t depth = 1;
  while (depth > 0 && !(nearest >= 0 && least <= enough)) {
    depth = depth - 1;
    const ptrdiff_t node = waiting[depth];
    if (bounds[depth] > least) {
      continue;
    }
    if (node >= tree[1]) {
      ptrdiff_t result1;
      S result2;
      ptrdiff_t result3;
      FN(visit_leaf_sphere_nx5_nx17_nx17)(align, slot, nodes[3 * node + 1], nodes[3 * node + 2], enough, nearest, least,
          slack, rows, weights, landmarks, order, leaves, &result1, &result2, &result3);
      nearest = result1;
      least = result2;
      const ptrdiff_t count = result3;
      evaluations = evaluations + count;
      continue;
    }
    const ptrdiff_t left = 2 * node;
    const ptrdiff_t right = 2 * node + 1;
    S left_bound = K(BS_HUGE_VALUE);
    S right_bound = K(BS_HUGE_VALUE);
    if (nodes[3 * left] > 0) {
      const S result4 = FN(least_cost_17_17_17)(landmarks + own_at, boxes + 34 * left, boxes + 34 * left + 17, slack);
      left_bound = result4;
    }
    if (nodes[3 * right] > 0) {
      const S result5 = FN(least_cost_17_17_17)(landmarks + own_at, boxes + 34 * right, boxes + 34 * right + 17, slack);
      right_bound = result5;
    }
    int is_left_near = left_bound < right_bound;
    if (left_bound == right_bound) {
      ptrdiff_t home = slots[6 * slot + 2];
      while (home > right) {
        home = bs_quotient(home, 2);
      }
      is_left_near = home != right;
    }
    ptrdiff_t near = right;
    S near_bound = right_bound;
    ptrdiff_t far = left;
    S far_bound = left_bound;
    if (is_left_near) {
      near = left;
      near_bound = left_bound;
      far = right;
      far_bound = right_bound;
    }
    if (nodes[3 * far] > 0 && far_bound <= least) {
      waiting[depth] = far;
      bounds[depth] = far_bound;
      depth = depth + 1;
    }
    if (nodes[3 * near] > 0 && near_bound <= least) {
      waiting[depth] = near;
      bounds[depth] = near_bound;
      depth = depth + 1;
    }
  }
  *result0_ = nearest;
  *result1_ = least;
  *result2_ = evaluations;
  return;
}

/* Note a slot's nearest object; costs that were computed. */
BS_OUTLINED ptrdiff_t FN(look_sphere_nx5_nx17_nx17_nx34)(int align, ptrdiff_t slot, const S limits[BS_LENGTH(2)],
    const ptrdiff_t tree[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, ptrdiff_t *slots,
    S *costs, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes)
{
  ptrdiff_t result;
  S result1;
  ptrdiff_t result2;
  FN(find_nearest_sphere_nx5_nx17_nx17_nx34)(align, slot, limits, tree, rows, weights, landmarks, slots, order, leaves,
      nodes, boxes, &result, &result1, &result2);
  const ptrdiff_t nearest = result;
  const S cost = result1;
  const ptrdiff_t evaluations = result2;
  slots[6 * slot + 3] = nearest;
  slots[6 * slot + 4] = nearest < 0 ? 0 : slots[6 * nearest];
  costs[slot] = cost;
  return evaluations;
}

/* Nearest objects of those at some places of the new tree; costs that were computed. */
BS_OUTLINED ptrdiff_t FN(find_sphere_nx5_nx17_nx17_nx34)(int align, ptrdiff_t begin, ptrdiff_t end,
    const ptrdiff_t counts[BS_LENGTH(6)], const S limits[BS_LENGTH(2)], const S *rows, const S *weights,
    const S *landmarks, ptrdiff_t *slots, S *costs, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes,
    const S *boxes)
{
  ptrdiff_t evaluations = 0;
  for (ptrdiff_t place = begin; place < end; place++) {
    const ptrdiff_t slot = order[place];
    const ptrdiff_t result = FN(look_sphere_nx5_nx17_nx17_nx34)(align, slot, limits, counts, rows, weights, landmarks,
        slots, costs, order, leaves, nodes, boxes);
    const ptrdiff_t count = result;
    evaluations = evaluations + count;
  }
  return evaluations;
}

/* Look for a slot's nearest object, and queue it with that. */
BS_OUTLINED void FN(look_again_sphere_nx5_nx17_nx17_nx34)(int align, ptrdiff_t slot, ptrdiff_t counts[BS_LENGTH(6)],
    const S limits[BS_LENGTH(2)], const S *rows, const S *weights, const S *landmarks, ptrdiff_t *slots, S *costs,
    ptrdiff_t *heap, const ptrdiff_t *order, const S *leaves, const ptrdiff_t *nodes, const S *boxes)
{
  const ptrdiff_t result = FN(look_sphere_nx5_nx17_nx17_nx34)(align, slot, limits, counts, rows, weights, landmarks,
      slots, costs, order, leaves, nodes, boxes);
  const ptrdiff_t evaluations = result;
  counts[5] = counts[5] + evaluations;
  if (slots[6 * slot + 3] < 0) {
    const ptrdiff_t result1 = FN(leave)(slot, counts[3], costs, heap, slots);
    counts[3] = result1;
    return;
  }
  ptrdiff_t place = slots[6 * slot + 5];
  if (place < 0) {
    place = counts[3];
    counts[3] = counts[3] + 1;
  }
  FN(settle)(place, slot, counts[3], costs, heap, slots);
}

/* Draw the boxes anew from an object's leaf to the root: it has moved (change 0), or gone (-1). */
BS_OUTLINED void FN(refit_nx17_nx17_nx34)(ptrdiff_t slot, ptrdiff_t change, const S *landmarks,
    const ptrdiff_t *slots, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes)
{
  const ptrdiff_t place = slots[6 * slot + 1];
  ptrdiff_t node = slots[6 * slot + 2];
  if (change < 0) {
    order[place] = -1;
  } else {
    for (ptrdiff_t k = 0; k < 17; k++) {
      leaves[17 * place + k] = landmarks[17 * slot + k];
    }
  }
  FN(fill_box_34_nx17)(boxes + 34 * node, nodes[3 * node + 1], nodes[3 * node + 2], order, leaves);
  nodes[3 * node] = nodes[3 * node] + change;
  node = bs_quotient(node, 2);
  while (node > 0) {
    const ptrdiff_t box_at = 34 * node;
    const ptrdiff_t one_at = 34 * (2 * node);
    const ptrdiff_t other_at = 34 * (2 * node + 1);
    nodes[3 * node] = nodes[3 * node] + change;
    for (ptrdiff_t i = 0; i < 17; i++) {
      boxes[box_at + i] = FN(bs_min)(boxes[other_at + i], boxes[one_at + i]);
      boxes[box_at + (17 + i)] = FN(bs_max)(boxes[other_at + (17 + i)], boxes[one_at + (17 + i)]);
    }
    node = bs_quotient(node, 2);
  }
}

/* Replace an object and its nearest one by their mean. */
BS_OUTLINED void FN(merge_pair_sphere_nx5_nx17_nx17_nx34)(int align, ptrdiff_t slot, ptrdiff_t counts[BS_LENGTH(6)],
    S limits[BS_LENGTH(2)], S *rows, S *weights, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, S *costs,
    ptrdiff_t *heap, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes, S *merge_costs, ptrdiff_t *pairs)
{
  const ptrdiff_t kept = bs_min(slot, slots[6 * slot + 3]);
  const ptrdiff_t gone = bs_max(slot, slots[6 * slot + 3]);
  S turned[5];
  FN(turn_sphere_5_5_5)(align, turned, rows + 5 * kept, rows + 5 * gone);
  S row[1];
  row[0] = weights[kept];
  S row1[1];
  row1[0] = weights[gone];
  S mean[5];
  S row2[1];
  FN(cga3d_mean_sphere)(mean, row2, rows + 5 * kept, turned, row, row1);
  const S status = row2[0];
  if (status == K(0.0)) {
    for (ptrdiff_t k = 0; k < 5; k++) {
      rows[5 * kept + k] = mean[k];
    }
  }
  weights[kept] = weights[kept] + weights[gone];
  FN(cga3d_landmark_sphere)(landmarks + 17 * kept, rows + 5 * kept);
  slots[6 * kept] = slots[6 * kept] + 1;
  slots[6 * gone] = -1;
  counts[2] = counts[2] - 1;
  merge_costs[counts[4]] = costs[slot];
  pairs[2 * counts[4]] = kept;
  pairs[2 * counts[4] + 1] = gone;
  counts[4] = counts[4] + 1;
  const ptrdiff_t result = FN(leave)(gone, counts[3], costs, heap, slots);
  counts[3] = result;
  if (counts[2] * 4 < counts[0]) {
    const S result1 = FN(build_tree_nx17_nx17_nx34)(counts, landmarks, slots, slots_count_, order, leaves, nodes, boxes);
    limits[1] = result1;
  } else {
    FN(refit_nx17_nx17_nx34)(gone, -1, landmarks, slots, order, leaves, nodes, boxes);
    FN(refit_nx17_nx17_nx34)(kept, 0, landmarks, slots, order, leaves, nodes, boxes);
  }
  FN(look_again_sphere_nx5_nx17_nx17_nx34)(align, kept, counts, limits, rows, weights, landmarks, slots, costs, heap,
      order, leaves, nodes, boxes);
}

/* At most so many merges; fewer were done only if no pair is left. */
BS_OUTLINED ptrdiff_t FN(step_sphere_nx5_nx17_nx17_nx34)(int align, ptrdiff_t most, ptrdiff_t counts[BS_LENGTH(6)],
    S limits[BS_LENGTH(2)], S *rows, S *weights, S *landmarks, ptrdiff_t *slots, ptrdiff_t slots_count_, S *costs,
    ptrdiff_t *heap, ptrdiff_t *order, S *leaves, ptrdiff_t *nodes, S *boxes, S *merge_costs, ptrdiff_t *pairs)
{
  const ptrdiff_t before = counts[4];
  while (counts[3] > 0 && counts[4] - before < most) {
    const ptrdiff_t slot = heap[0];
    if (slots[6 * slots[6 * slot + 3]] != slots[6 * slot + 4]) {
      FN(look_again_sphere_nx5_nx17_nx17_nx34)(align, slot, counts, limits, rows, weights, landmarks, slots, costs, heap,
          order, leaves, nodes, boxes);
    } else {
      FN(merge_pair_sphere_nx5_nx17_nx17_nx34)(align, slot, counts, limits, rows, weights, landmarks, slots, slots_count_,
          costs, heap, order, leaves, nodes, boxes, merge_costs, pairs);
    }
  }
  return counts[4] - before;
}
