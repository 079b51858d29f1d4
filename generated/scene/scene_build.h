/* The extent of no items. */
BS_INLINE void FN(clear)(S extent[BS_LENGTH(12)])
{
  for (ptrdiff_t i = 0; i < 3; i++) {
    extent[i] = K(BS_HUGE_VALUE);
    extent[6 + i] = K(BS_HUGE_VALUE);
    extent[3 + i] = -K(BS_HUGE_VALUE);
    extent[6 + (3 + i)] = -K(BS_HUGE_VALUE);
  }
}

/* Coordinate of a box's centre. */
BS_INLINE S FN(center)(const S box[BS_LENGTH(6)], ptrdiff_t axis)
{
  return K(0.5) * box[axis] + K(0.5) * box[3 + axis];
}

/* Enlarge an extent by an item. */
BS_INLINE void FN(add_item)(S extent[BS_LENGTH(12)], const S box[BS_LENGTH(6)])
{
  for (ptrdiff_t i = 0; i < 3; i++) {
    const S result = FN(center)(box, i);
    const S middle = result;
    extent[i] = FN(bs_min)(extent[i], box[i]);
    extent[3 + i] = FN(bs_max)(extent[3 + i], box[3 + i]);
    extent[6 + i] = FN(bs_min)(extent[6 + i], middle);
    extent[6 + (3 + i)] = FN(bs_max)(extent[6 + (3 + i)], middle);
  }
}

/* Half the surface of a box. */
BS_INLINE S FN(half_area)(const S box[BS_LENGTH(6)])
{
  const S x = box[3] - box[0];
  const S y = box[4] - box[1];
  const S z = box[5] - box[2];
  return x * y + y * z + z * x;
}

/* Enlarge an extent by another. */
BS_INLINE void FN(add_extent)(S extent[BS_LENGTH(12)], const S other[BS_LENGTH(12)])
{
  for (ptrdiff_t i = 0; i < 3; i++) {
    extent[i] = FN(bs_min)(extent[i], other[i]);
    extent[3 + i] = FN(bs_max)(extent[3 + i], other[3 + i]);
    extent[6 + i] = FN(bs_min)(extent[6 + i], other[6 + i]);
    extent[6 + (3 + i)] = FN(bs_max)(extent[6 + (3 + i)], other[6 + (3 + i)]);
  }
}

/* Work of rays on some items, in nodes, which cost the same with any number of parts. */
BS_INLINE S FN(expected_work)(const S extent[BS_LENGTH(12)], ptrdiff_t items)
{
  const ptrdiff_t nodes = bs_quotient(items + 4 - 1, 4);
  const S result = FN(half_area)(extent);
  const S area = result;
  return nodes > 0 ? (S)(nodes) * area : K(BS_HUGE_VALUE);
}

/* The place in a row of extents before which the least work is expected of both parts, and the items before it. */
BS_OUTLINED void FN(best_cut)(const S *row, const ptrdiff_t *counts, ptrdiff_t count, S low[BS_LENGTH(12)],
    S high[BS_LENGTH(12)], ptrdiff_t *result0_, ptrdiff_t *result1_)
{
  S after[16];
  S extent[12];
  FN(clear)(extent);
  ptrdiff_t items = 0;
  for (ptrdiff_t b = count - 1; b > 0; b--) {
    FN(add_extent)(extent, row + 12 * b);
    items = items + counts[b];
    const S result = FN(expected_work)(extent, items);
    after[b] = result;
  }
  FN(clear)(extent);
  items = 0;
  S least = K(BS_HUGE_VALUE);
  ptrdiff_t best = 0;
  ptrdiff_t before = 0;
  for (ptrdiff_t b = 1; b < count; b++) {
    FN(add_extent)(extent, row + 12 * (b - 1));
    items = items + counts[b - 1];
    const S result1 = FN(expected_work)(extent, items);
    const S work = result1 + after[b];
    if (work < least) {
      least = work;
      best = b;
      before = items;
      for (ptrdiff_t k = 0; k < 12; k++) {
        low[k] = extent[k];
      }
    }
  }
  FN(clear)(high);
  for (ptrdiff_t b = best; b < count; b++) {
    FN(add_extent)(high, row + 12 * b);
  }
  *result0_ = best;
  *result1_ = before;
  return;
}

/* Part a few items between any two of them, in the order of their centres; see `best_cut`. */
BS_OUTLINED void FN(cut_few)(S *boxes, ptrdiff_t *numbers, ptrdiff_t first, ptrdiff_t items, ptrdiff_t axis,
    S low[BS_LENGTH(12)], S high[BS_LENGTH(12)], ptrdiff_t *result0_, ptrdiff_t *result1_)
{
  S row[144];
  ptrdiff_t counts[12];
  S box[6];
  for (ptrdiff_t i = first + 1; i < first + items; i++) {
    for (ptrdiff_t k1 = 0; k1 < 6; k1++) {
      box[k1] = boxes[6 * i + k1];
    }
    const ptrdiff_t number = numbers[i];
    const S result = FN(center)(box, axis);
    const S middle = result;
    ptrdiff_t place = i;
    while (place > first) {
      const S result1 = FN(center)(boxes + 6 * (place - 1), axis);
      if (!(result1 > middle)) {
        break;
      }
      for (ptrdiff_t k = 0; k < 6; k++) {
        boxes[6 * place + k] = boxes[6 * (place - 1) + k];
      }
      numbers[place] = numbers[place - 1];
      place = place - 1;
    }
    for (ptrdiff_t k2 = 0; k2 < 6; k2++) {
      boxes[6 * place + k2] = box[k2];
    }
    numbers[place] = number;
  }
  for (ptrdiff_t i = 0; i < items; i++) {
    FN(clear)(row + 12 * i);
    FN(add_item)(row + 12 * i, boxes + 6 * (first + i));
    counts[i] = 1;
  }
  ptrdiff_t result2;
  ptrdiff_t result3;
  FN(best_cut)(row, counts, items, low, high, &result2, &result3);
  const ptrdiff_t best = result2;
  const ptrdiff_t before = result3;
  *result0_ = best;
  *result1_ = before;
  return;
}

/* The bin of an item. */
BS_INLINE ptrdiff_t FN(bin_of)(const S box[BS_LENGTH(6)], ptrdiff_t axis, S start, S scale)
{
  const S result = FN(center)(box, axis);
  const ptrdiff_t found = (ptrdiff_t)((result - start) * scale);
  return found < 0 ? 0 : (found < 16 ? found : 15);
}

/* Part items at one of a few places along an axis; see `best_cut`. */
BS_OUTLINED void FN(cut_many)(S *boxes, ptrdiff_t *numbers, ptrdiff_t first, ptrdiff_t items, ptrdiff_t axis,
    S start, S length, S low[BS_LENGTH(12)], S high[BS_LENGTH(12)], ptrdiff_t *result0_, ptrdiff_t *result1_)
{
  const S scale = K(16.0) / length;
  S bins[192];
  ptrdiff_t counts[16];
  if (!(scale > K(0.0) && scale < K(BS_HUGE_VALUE))) {
    *result0_ = 0;
    *result1_ = 0;
    return;
  }
  for (ptrdiff_t b = 0; b < 16; b++) {
    FN(clear)(bins + 12 * b);
    counts[b] = 0;
  }
  for (ptrdiff_t i = first; i < first + items; i++) {
    const ptrdiff_t result = FN(bin_of)(boxes + 6 * i, axis, start, scale);
    const ptrdiff_t found = result;
    FN(add_item)(bins + 12 * found, boxes + 6 * i);
    counts[found] = counts[found] + 1;
  }
  ptrdiff_t result1;
  ptrdiff_t result2;
  FN(best_cut)(bins, counts, 16, low, high, &result1, &result2);
  const ptrdiff_t cut = result1;
  const ptrdiff_t before = result2;
  if (cut == 0) {
    *result0_ = 0;
    *result1_ = 0;
    return;
  }
  ptrdiff_t i_low = first;
  ptrdiff_t i_high = first + items;
  S box[6];
  while (1) {
    while (i_low < i_high) {
      const ptrdiff_t result3 = FN(bin_of)(boxes + 6 * i_low, axis, start, scale);
      if (result3 >= cut) {
        break;
      }
      i_low = i_low + 1;
    }
    while (i_low < i_high) {
      const ptrdiff_t result4 = FN(bin_of)(boxes + 6 * (i_high - 1), axis, start, scale);
      if (result4 < cut) {
        break;
      }
      i_high = i_high - 1;
    }
    if (i_low >= i_high) {
      *result0_ = cut;
      *result1_ = before;
      return;
    }
    i_high = i_high - 1;
    for (ptrdiff_t k1 = 0; k1 < 6; k1++) {
      box[k1] = boxes[6 * i_low + k1];
    }
    for (ptrdiff_t k = 0; k < 6; k++) {
      boxes[6 * i_low + k] = boxes[6 * i_high + k];
    }
    for (ptrdiff_t k2 = 0; k2 < 6; k2++) {
      boxes[6 * i_high + k2] = box[k2];
    }
    const ptrdiff_t value = numbers[i_high];
    const ptrdiff_t value1 = numbers[i_low];
    numbers[i_low] = value;
    numbers[i_high] = value1;
    i_low = i_low + 1;
  }
}

/* Part a range in two; the items of the first part. Both have some. */
BS_OUTLINED ptrdiff_t FN(cut_range)(S *boxes, ptrdiff_t *numbers, ptrdiff_t first, ptrdiff_t items, int is_halved,
    const S extent[BS_LENGTH(12)], S low[BS_LENGTH(12)], S high[BS_LENGTH(12)])
{
  ptrdiff_t axis = 0;
  for (ptrdiff_t i = 1; i < 3; i++) {
    if (extent[6 + (3 + i)] - extent[6 + i] > extent[6 + (3 + axis)] - extent[6 + axis]) {
      axis = i;
    }
  }
  ptrdiff_t cut = 0;
  ptrdiff_t before = 0;
  if (!is_halved) {
    if (items <= 12) {
      ptrdiff_t result;
      ptrdiff_t result1;
      FN(cut_few)(boxes, numbers, first, items, axis, low, high, &result, &result1);
      cut = result;
      before = result1;
    } else {
      const S start = extent[6 + axis];
      const S length = extent[6 + (3 + axis)] - start;
      ptrdiff_t result2;
      ptrdiff_t result3;
      FN(cut_many)(boxes, numbers, first, items, axis, start, length, low, high, &result2, &result3);
      cut = result2;
      before = result3;
    }
  }
  if (cut == 0) {
    before = bs_quotient(items, 2);
    FN(clear)(low);
    FN(clear)(high);
    for (ptrdiff_t i = 0; i < items; i++) {
      if (i < before) {
        FN(add_item)(low, boxes + 6 * (first + i));
      } else {
        FN(add_item)(high, boxes + 6 * (first + i));
      }
    }
  }
  return before;
}

/* Up to four parts of a range, which is the first at the start; their number. */
BS_OUTLINED ptrdiff_t FN(part_range)(S *boxes, ptrdiff_t *numbers, int is_halved, S *extents, ptrdiff_t *ranges)
{
  S whole[12];
  ptrdiff_t found = 1;
  while (found < 4) {
    ptrdiff_t chosen = -1;
    S most = K(-1.0);
    for (ptrdiff_t i = 0; i < found; i++) {
      const ptrdiff_t items = ranges[2 * i + 1];
      const S result = FN(half_area)(extents + 12 * i);
      const S area = result;
      S size = (S)(items) * (is_halved ? K(1.0) : area);
      if (!is_halved && !(area < K(BS_HUGE_VALUE))) {
        size = (S)(items);
      }
      if (items > 1 && size > most) {
        most = size;
        chosen = i;
      }
    }
    if (chosen < 0) {
      return found;
    }
    const ptrdiff_t first = ranges[2 * chosen];
    const ptrdiff_t count = ranges[2 * chosen + 1];
    for (ptrdiff_t k = 0; k < 12; k++) {
      whole[k] = extents[12 * chosen + k];
    }
    const ptrdiff_t result1 = FN(cut_range)(boxes, numbers, first, count, is_halved, whole, extents + 12 * chosen,
        extents + 12 * found);
    const ptrdiff_t before = result1;
    ranges[2 * chosen + 1] = before;
    ranges[2 * found] = first + before;
    ranges[2 * found + 1] = count - before;
    found = found + 1;
  }
  return found;
}

/* The tree over boxes, nodes in the order in which they were made, their root first; the number of nodes. */
BS_OUTLINED ptrdiff_t FN(build_tree)(S *boxes, ptrdiff_t boxes_count_, ptrdiff_t *numbers, S *nodes, int32_t *parts)
{
  ptrdiff_t waiting[580];
  S extents_waiting[1740];
  S extents[48];
  ptrdiff_t ranges[8];
  const ptrdiff_t count = boxes_count_;
  if (count < 1) {
    return 0;
  }
  FN(clear)(extents_waiting);
  for (ptrdiff_t i = 0; i < count; i++) {
    numbers[i] = i;
    FN(add_item)(extents_waiting, boxes + 6 * i);
  }
  waiting[0] = 0;
  waiting[1] = count;
  waiting[2] = 0;
  waiting[3] = 0;
  ptrdiff_t unbuilt = 1;
  ptrdiff_t built = 1;
  while (unbuilt > 0) {
    unbuilt = unbuilt - 1;
    const ptrdiff_t first = waiting[4 * unbuilt];
    const ptrdiff_t items = waiting[4 * unbuilt + 1];
    const ptrdiff_t node = waiting[4 * unbuilt + 2];
    const ptrdiff_t level = waiting[4 * unbuilt + 3];
    ptrdiff_t found = items;
    if (items <= 4) {
      for (ptrdiff_t c = 0; c < items; c++) {
        FN(clear)(extents + 12 * c);
        FN(add_item)(extents + 12 * c, boxes + 6 * (first + c));
        ranges[2 * c] = first + c;
        ranges[2 * c + 1] = 1;
      }
    } else {
      for (ptrdiff_t k1 = 0; k1 < 12; k1++) {
        extents[k1] = extents_waiting[12 * unbuilt + k1];
      }
      ranges[0] = first;
      ranges[1] = items;
      const ptrdiff_t result = FN(part_range)(boxes, numbers, level >= 28, extents, ranges);
      found = result;
    }
    for (ptrdiff_t c = 0; c < 4; c++) {
      const ptrdiff_t inside = c < found ? ranges[2 * c + 1] : 0;
      for (ptrdiff_t k = 0; k < 6; k++) {
        nodes[24 * node + (4 * k + c)] = inside > 0 ? extents[12 * c + k] : K(0.0);
      }
      if (inside == 0) {
        parts[4 * node + c] = (int32_t)(-2147483648);
      } else {
        if (inside == 1) {
          parts[4 * node + c] = (int32_t)(-1 - numbers[ranges[2 * c]]);
        } else {
          parts[4 * node + c] = (int32_t)(built);
          waiting[4 * unbuilt] = ranges[2 * c];
          waiting[4 * unbuilt + 1] = inside;
          waiting[4 * unbuilt + 2] = built;
          waiting[4 * unbuilt + 3] = level + 1;
          for (ptrdiff_t k2 = 0; k2 < 12; k2++) {
            extents_waiting[12 * unbuilt + k2] = extents[12 * c + k2];
          }
          unbuilt = unbuilt + 1;
          built = built + 1;
        }
      }
    }
  }
  return built;
}
