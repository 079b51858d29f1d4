/* bladesmith: loops over the joints of serial chains, W poses at a time. chain.c.j2 includes this once per instance. */

/* Where a joint's numbers stand. */
#undef BS_OFFSET
#undef BS_AXIS
#undef BS_TURN
#undef BS_ADVANCE
#undef BS_JOINT
#undef BS_FRAME
#define BS_OFFSET 0
#define BS_AXIS 3
#define BS_TURN 6
#define BS_ADVANCE 7
#define BS_JOINT 8
#define BS_FRAME 7 /* place and rotor of a frame */

/* A pose of the frame at hand, as the formulas have it. */
typedef struct {
  V turn[4], place[3];
} FN(pose);

/* One number of each of W rows; beyond the last the last again. */
BS_INLINE V FN(chain_get)(const double *rows, ptrdiff_t stride, int lanes)
{
  V x;
  S *const to = (S *)&x;
  for (int l = 0; l < W; l++) to[l] = rows[(l < lanes ? l : lanes - 1) * stride];
  return x;
}

/* Some numbers of each of W rows, back. */
BS_INLINE void FN(chain_put)(double *rows, ptrdiff_t stride, ptrdiff_t step, const V *x, int size, int lanes)
{
  const S *const from = (const S *)x;
  for (int k = 0; k < size; k++)
    for (int l = 0; l < lanes; l++) rows[l * stride + k * step] = from[k * W + l];
}

BS_INLINE void FN(chain_begin)(FN(pose) *pose)
{
  static const S one[4] = BS_IDENTITY;
  for (int k = 0; k < 4; k++) pose->turn[k] = SPLAT(one[k]);
  for (int k = 0; k < 3; k++) pose->place[k] = SPLAT(0);
}

/* On to the next joint: the pose behind it. */
BS_INLINE void FN(chain_step)(FN(pose) *pose, const double *joint, V x)
{
  V offset[3], axis[3], place[3], turn[4];
  const V way = SPLAT(joint[BS_ADVANCE]) * x, angle = SPLAT(joint[BS_TURN]) * x;
  FN(load_broadcast)(offset, joint + BS_OFFSET, 3);
  FN(load_broadcast)(axis, joint + BS_AXIS, 3);
  KERNEL(joint_position)(place, pose->turn, pose->place, offset, axis, &way);
  for (int k = 0; k < 3; k++) pose->place[k] = place[k];
  if (joint[BS_TURN] == 0) return;
  KERNEL(rotate)(turn, pose->turn, axis, &angle);
  for (int k = 0; k < 4; k++) pose->turn[k] = turn[k];
}

/* The pose of a frame of the link. */
BS_INLINE void FN(chain_frame)(FN(pose) *at, const FN(pose) *pose, const double *frame)
{
  V offset[3], turn[4];
  FN(load_broadcast)(offset, frame, 3);
  FN(load_broadcast)(turn, frame + 3, 4);
  KERNEL(frame_pose)(at->turn, at->place, pose->turn, pose->place, offset, turn);
}

static void FN(chain_forward)(const bs_chain *chain, const double *x, int32_t all, double *motors, ptrdiff_t begin,
                              ptrdiff_t end)
{
  const ptrdiff_t n = chain->count, stride = all ? 8 * n : 8;
  V base[3], motor[8];
  FN(load_broadcast)(base, chain->base, 3);
  for (ptrdiff_t i = begin; i < end; i += W) {
    const int lanes = end - i < W ? (int)(end - i) : W;
    FN(pose) pose, at;
    FN(chain_begin)(&pose);
    for (ptrdiff_t j = 0; j < n; j++) {
      FN(chain_step)(&pose, chain->joints + BS_JOINT * j, FN(chain_get)(x + i * n + j, n, lanes));
      if (!all) continue;
      FN(chain_frame)(&at, &pose, chain->links + BS_FRAME * j);
      KERNEL(compose)(motor, at.turn, at.place, base);
      FN(chain_put)(motors + i * stride + 8 * j, stride, 1, motor, 8, lanes);
    }
    if (all) continue;
    FN(chain_frame)(&at, &pose, chain->tool);
    KERNEL(compose)(motor, at.turn, at.place, base);
    FN(chain_put)(motors + i * stride, stride, 1, motor, 8, lanes);
  }
}

/* The tool's pose, and of each joint its axis and place. */
BS_INLINE void FN(chain_axes)(const bs_chain *chain, const double *x, int lanes, FN(pose) *tool, V *axes, V *places)
{
  FN(pose) pose;
  FN(chain_begin)(&pose);
  for (ptrdiff_t j = 0; j < chain->count; j++) {
    const double *const joint = chain->joints + BS_JOINT * j;
    V axis[3];
    FN(load_broadcast)(axis, joint + BS_AXIS, 3);
    KERNEL(link_direction)(axes + 3 * j, pose.turn, axis);
    FN(chain_step)(&pose, joint, FN(chain_get)(x + j, chain->count, lanes));
    for (int k = 0; k < 3; k++) places[3 * j + k] = pose.place[k];
  }
  FN(chain_frame)(tool, &pose, chain->tool);
}

static void FN(chain_jacobian)(const bs_chain *chain, const double *x, int32_t frame, const double *points,
                               ptrdiff_t stride, double *matrices, ptrdiff_t begin, ptrdiff_t end)
{
  const ptrdiff_t n = chain->count;
  const V none = SPLAT(0);
  V axes[3 * BS_JOINTS], places[3 * BS_JOINTS], from[3], point[3], nowhere[3], column[6];
  for (int k = 0; k < 3; k++) nowhere[k] = none;
  for (ptrdiff_t i = begin; i < end; i += W) {
    const int lanes = end - i < W ? (int)(end - i) : W;
    FN(pose) tool;
    FN(chain_axes)(chain, x + i * n, lanes, &tool, axes, places);
    if (frame) {
      for (int k = 0; k < 3; k++) point[k] = FN(chain_get)(points + i * stride + k, stride, lanes);
      KERNEL(joint_position)(from, tool.turn, tool.place, point, nowhere, &none);
    } else {
      for (int k = 0; k < 3; k++) from[k] = SPLAT(-chain->base[k]); /* the world's origin, as seen from the base */
    }
    for (ptrdiff_t j = 0; j < n; j++) {
      const double *const joint = chain->joints + BS_JOINT * j;
      const V turn = SPLAT(joint[BS_TURN]), advance = SPLAT(joint[BS_ADVANCE]);
      if (frame == 2) KERNEL(body_column)(column, tool.turn, axes + 3 * j, places + 3 * j, from, &turn, &advance);
      else KERNEL(column)(column, axes + 3 * j, places + 3 * j, from, &turn, &advance);
      FN(chain_put)(matrices + 6 * n * i + j, 6 * n, n, column, 6, lanes);
    }
  }
}

static void FN(chain_twists)(const bs_chain *chain, const double *x, const double *speeds, const double *pushes,
                             int32_t all, double *twists, double *rates, ptrdiff_t begin, ptrdiff_t end)
{
  const ptrdiff_t n = chain->count, stride = all ? 6 * n : 6;
  for (ptrdiff_t i = begin; i < end; i += W) {
    const int lanes = end - i < W ? (int)(end - i) : W;
    V twist[6], rate[6];
    FN(pose) pose;
    FN(chain_begin)(&pose);
    for (int k = 0; k < 6; k++) twist[k] = rate[k] = SPLAT(0);
    for (ptrdiff_t j = 0; j < n; j++) {
      const double *const joint = chain->joints + BS_JOINT * j;
      const V turn = SPLAT(joint[BS_TURN]), advance = SPLAT(joint[BS_ADVANCE]);
      const V speed = FN(chain_get)(speeds + i * n + j, n, lanes), push = FN(chain_get)(pushes + i * n + j, n, lanes);
      V axis[3], along[3], place[3], unit[6], next[6], next_rate[6];
      FN(load_broadcast)(axis, joint + BS_AXIS, 3);
      KERNEL(link_direction)(along, pose.turn, axis);
      FN(chain_step)(&pose, joint, FN(chain_get)(x + i * n + j, n, lanes));
      for (int k = 0; k < 3; k++) place[k] = pose.place[k] + SPLAT(chain->base[k]);
      KERNEL(unit_twist)(unit, along, place, &turn, &advance);
      KERNEL(link_twist)(next, next_rate, twist, rate, unit, &speed, &push);
      for (int k = 0; k < 6; k++) twist[k] = next[k], rate[k] = next_rate[k];
      if (!all && j < n - 1) continue;
      const ptrdiff_t to = i * stride + (all ? 6 * j : 0);
      FN(chain_put)(twists + to, stride, 1, twist, 6, lanes);
      FN(chain_put)(rates + to, stride, 1, rate, 6, lanes);
    }
  }
}
