/* bladesmith: joints that bring a chain's tool to a pose, by damped Newton steps on the turn and the way that are missing.
   One pose at a time. A length of the chain's own counts as a radian, so that metres or microns make no difference. */

/* Of bladesmith.Status. */
enum { BS_REACHED = 0, BS_UNREACHABLE = 4, BS_NOT_CONVERGED = 5, BS_INVALID = 6 };

#define BS_DAMPING 1e-2        /* at first, as a share of the square of what is missing, */
#define BS_MOST_MISSING 16.0   /* or of this: slides bring far goals near in steps that are exact */
#define BS_LEAST_DAMPING 1e-6
#define BS_MOST_DAMPING 1e12   /* where no step helps */
#define BS_FLOOR 1e-16         /* damping of what no joint moves: less is rounding */
#define BS_POOR 0.25           /* of what a step was to gain: more damping below, */
#define BS_GOOD 0.75           /* less above, */
#define BS_ENOUGH 1e-4         /* and it is not taken below */
#define BS_REST 1e-9           /* a step that gains no more than this share comes to nothing */
#define BS_LONGEST_TURN 1.5    /* of a joint that turns in one step, radians or lengths of the chain */
#define BS_ROUNDING 4.4e-16    /* for each joint: nothing is known better */
#define BS_DEPENDENT 1e-7      /* a direction with less of its own is lost: next to one, joints are known to half the digits */

typedef struct {
  const bs_chain *chain;
  const bs_search *search;
  double goal[4], goal_place[3];
  double x[BS_JOINTS], trial[BS_JOINTS], step[BS_JOINTS];
  double units[BS_JOINTS];       /* of the joints: with them all move alike, by radians or lengths of the chain */
  double rows[6][BS_JOINTS + 6]; /* of the Jacobian, for these units, and of the damping behind it */
  double axes[3 * BS_JOINTS], places[3 * BS_JOINTS];
  double wanted[6], error;       /* what is missing, and its square */
  FN(pose) tool;
} FN(sought);

/* What is missing at x, a length worth a radian; axes and places for `chain_rows`. */
static void FN(chain_look)(FN(sought) *s, const double *x)
{
  FN(chain_axes)(s->chain, x, 1, &s->tool, s->axes, s->places);
  KERNEL(pose_error)(s->wanted, s->tool.turn, s->tool.place, s->goal, s->goal_place);
  s->error = 0;
  for (int r = 0; r < 6; r++) {
    if (r >= 3) s->wanted[r] /= s->search->length;
    s->error += s->wanted[r] * s->wanted[r];
  }
}

/* The Jacobian at the tool, without joints that stand at a limit and would go beyond. */
static void FN(chain_rows)(FN(sought) *s)
{
  const ptrdiff_t n = s->chain->count;
  for (ptrdiff_t j = 0; j < n; j++) {
    const double *const joint = s->chain->joints + BS_JOINT * j;
    const double lower = s->search->lower[j], upper = s->search->upper[j];
    double column[6], pull = 0;
    KERNEL(column)(column, s->axes + 3 * j, s->places + 3 * j, s->tool.place, joint + BS_TURN, joint + BS_ADVANCE);
    for (int r = 0; r < 6; r++) {
      column[r] *= r >= 3 ? s->units[j] / s->search->length : s->units[j];
      pull += column[r] * s->wanted[r];
    }
    const int held = (pull > 0 && s->x[j] >= upper) || (pull < 0 && s->x[j] <= lower);
    for (int r = 0; r < 6; r++) s->rows[r][j] = held ? 0 : column[r];
  }
}

/* The step of least squares, damped: directions of the rows with the damping behind them, one after the other. What of
   the missing square it leaves by first order. */
static double FN(chain_solve)(FN(sought) *s, double damping)
{
  const ptrdiff_t n = s->chain->count, all = n + 6;
  double direction[6][BS_JOINTS + 6], share[6], left = 0;
  for (int r = 0; r < 6; r++) {
    double value = s->wanted[r], square = 0, *const own = direction[r];
    for (ptrdiff_t j = 0; j < n; j++) own[j] = s->rows[r][j];
    for (int k = 0; k < 6; k++) own[n + k] = k == r ? damping : 0;
    for (int k = 0; k < r; k++) {
      double c = 0;
      for (ptrdiff_t j = 0; j < all; j++) c += direction[k][j] * own[j];
      for (ptrdiff_t j = 0; j < all; j++) own[j] -= c * direction[k][j];
      value -= c * share[k];
    }
    for (ptrdiff_t j = 0; j < all; j++) square += own[j] * own[j];
    const double length = sqrt(square);
    for (ptrdiff_t j = 0; j < all; j++) own[j] /= length;
    share[r] = value / length;
  }
  for (ptrdiff_t j = 0; j < n; j++) {
    s->step[j] = 0;
    for (int r = 0; r < 6; r++) s->step[j] += direction[r][j] * share[r];
  }
  for (int r = 0; r < 6; r++) {
    double rest = s->wanted[r];
    for (ptrdiff_t j = 0; j < n; j++) rest -= s->rows[r][j] * s->step[j];
    left += rest * rest;
  }
  return left;
}

/* Where the step leads, within the limits. Slides may go any way: what they move is linear. */
static void FN(chain_try)(FN(sought) *s)
{
  const ptrdiff_t n = s->chain->count;
  double most = 0;
  for (ptrdiff_t j = 0; j < n; j++)
    if (s->chain->joints[BS_JOINT * j + BS_TURN] != 0) most = fmax(most, fabs(s->step[j]));
  const double share = most > BS_LONGEST_TURN ? BS_LONGEST_TURN / most : 1;
  for (ptrdiff_t j = 0; j < n; j++) {
    const double part = s->chain->joints[BS_JOINT * j + BS_TURN] != 0 ? share : 1;
    s->trial[j] = fmin(fmax(s->x[j] + part * s->units[j] * s->step[j], s->search->lower[j]), s->search->upper[j]);
  }
}

/* Both parts of what is missing, a turn and a length. */
static void FN(chain_parts)(const FN(sought) *s, double *parts)
{
  const double *const e = s->wanted;
  parts[0] = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
  parts[1] = sqrt(e[3] * e[3] + e[4] * e[4] + e[5] * e[5]) * s->search->length;
}

static int FN(chain_arrived)(const FN(sought) *s)
{
  double parts[2], square = 0;
  const double rounding = BS_ROUNDING * (double)s->chain->count, most = fmax(s->search->tolerance, rounding);
  for (int k = 0; k < 3; k++) square += s->goal_place[k] * s->goal_place[k];
  FN(chain_parts)(s, parts);
  return parts[0] <= most && parts[1] <= fmax(most * s->search->length, rounding * sqrt(square));
}

/* One step more from where it has arrived: what is missing is squared by it, down to rounding. */
static void FN(chain_polish)(FN(sought) *s)
{
  const double before = s->error;
  FN(chain_rows)(s);
  FN(chain_solve)(s, sqrt(BS_FLOOR));
  FN(chain_try)(s);
  FN(chain_look)(s, s->trial);
  if (s->error < before)
    for (ptrdiff_t j = 0; j < s->chain->count; j++) s->x[j] = s->trial[j];
  else FN(chain_look)(s, s->x);
}

/* Steps from x until it is there, at rest, or out of iterations: its status. Rest proves nothing about the goal. */
static int FN(chain_attempt)(FN(sought) *s, int32_t *steps)
{
  const ptrdiff_t n = s->chain->count;
  double damping = BS_DAMPING;
  FN(chain_look)(s, s->x);
  for (int i = 0; i < s->search->iterations; i++) {
    if (!(s->error < HUGE_VAL)) return BS_INVALID;
    if (FN(chain_arrived)(s)) return BS_REACHED;
    FN(chain_rows)(s);
    const double before = s->error;
    for (;;) {
      const double left = FN(chain_solve)(s, sqrt(fmax(damping * fmin(before, BS_MOST_MISSING), BS_FLOOR)));
      double wanted[6];
      if (!(before - left > BS_REST * before)) return BS_NOT_CONVERGED;
      for (int r = 0; r < 6; r++) wanted[r] = s->wanted[r];
      FN(chain_try)(s);
      FN(chain_look)(s, s->trial);
      *steps += 1;
      const double gain = (before - s->error) / (before - left);
      if (!(gain >= BS_POOR)) damping *= gain >= BS_ENOUGH ? 4 : 16;
      else if (gain > BS_GOOD) damping = fmax(damping / 4, BS_LEAST_DAMPING);
      if (gain >= BS_ENOUGH) break;
      for (int r = 0; r < 6; r++) s->wanted[r] = wanted[r];
      s->error = before;
      if (damping > BS_MOST_DAMPING) return BS_NOT_CONVERGED;
    }
    for (ptrdiff_t j = 0; j < n; j++) s->x[j] = s->trial[j];
  }
  return FN(chain_arrived)(s) ? BS_REACHED : BS_NOT_CONVERGED;
}

/* Directions in which the joints can move the tool, at x, those at limits too. */
static int FN(chain_rank)(FN(sought) *s)
{
  const ptrdiff_t n = s->chain->count;
  double most = 0, norms[6];
  int rank = 0;
  for (int r = 0; r < 6; r++) s->wanted[r] = 0;
  FN(chain_rows)(s); /* nothing is wanted: no joint is held */
  for (int r = 0; r < 6; r++) {
    norms[r] = 0;
    for (ptrdiff_t j = 0; j < n; j++) norms[r] += s->rows[r][j] * s->rows[r][j];
    most = fmax(most, norms[r]);
  }
  for (int taken = 0; taken < 6; taken++) { /* the largest that is left, off all others */
    int best = 0;
    for (int r = 1; r < 6; r++)
      if (norms[r] > norms[best]) best = r;
    if (!(norms[best] > BS_DEPENDENT * BS_DEPENDENT * most)) break;
    rank++;
    for (int r = 0; r < 6; r++) {
      double c = 0;
      if (r == best || norms[r] < 0) continue;
      for (ptrdiff_t j = 0; j < n; j++) c += s->rows[r][j] * s->rows[best][j];
      c /= norms[best], norms[r] = 0;
      for (ptrdiff_t j = 0; j < n; j++) {
        s->rows[r][j] -= c * s->rows[best][j];
        norms[r] += s->rows[r][j] * s->rows[r][j];
      }
    }
    norms[best] = -1;
  }
  return rank;
}

static void FN(chain_seek)(FN(sought) *s, const double *start, const bs_found *found, ptrdiff_t i)
{
  const bs_search *const search = s->search;
  const ptrdiff_t n = s->chain->count;
  double best = HUGE_VAL;
  found->status[i] = BS_INVALID;
  for (int a = 0; a < search->attempts && found->status[i] != BS_REACHED; a++) {
    const double *const from = a ? search->kicks + n * (a - 1) : start;
    for (ptrdiff_t j = 0; j < n; j++) s->x[j] = fmin(fmax(from[j], search->lower[j]), search->upper[j]);
    const int outcome = FN(chain_attempt)(s, found->steps + i);
    if (outcome == BS_INVALID || !(s->error < best || outcome == BS_REACHED)) continue;
    found->status[i] = outcome;
    best = s->error;
    if (outcome == BS_REACHED) FN(chain_polish)(s);
    for (ptrdiff_t j = 0; j < n; j++) found->x[n * i + j] = s->x[j];
    FN(chain_parts)(s, found->errors + 2 * i);
    if (outcome == BS_REACHED) found->rank[i] = FN(chain_rank)(s);
  }
}

static void FN(chain_inverse)(const bs_chain *chain, const bs_search *search, const double *motors, const double *starts,
                              const bs_found *found, ptrdiff_t begin, ptrdiff_t end)
{
  const ptrdiff_t n = chain->count;
  FN(sought) sought;
  sought.chain = chain, sought.search = search;
  for (ptrdiff_t j = 0; j < n; j++) {
    const double *const joint = chain->joints + BS_JOINT * j;
    sought.units[j] = 1 / fmax(fabs(joint[BS_TURN]), fabs(joint[BS_ADVANCE]) / search->length);
  }
  for (ptrdiff_t i = begin; i < end; i++) {
    double square = 0, finite = 0;
    KERNEL(decompose)(sought.goal, sought.goal_place, motors + 8 * i, chain->base);
    for (int k = 0; k < 3; k++) square += sought.goal_place[k] * sought.goal_place[k];
    for (int k = 0; k < 8; k++) finite += fabs(motors[8 * i + k]);
    for (ptrdiff_t j = 0; j < n; j++) finite += fabs(starts[n * i + j]);
    for (ptrdiff_t j = 0; j < n; j++) found->x[n * i + j] = NAN;
    found->errors[2 * i] = found->errors[2 * i + 1] = NAN;
    found->steps[i] = found->rank[i] = 0;
    const int beyond = sqrt(square) > search->reach;
    if (!(finite < HUGE_VAL)) found->status[i] = BS_INVALID;
    else if (!beyond || search->nearest) FN(chain_seek)(&sought, starts + n * i, found, i);
    if (beyond && finite < HUGE_VAL) found->status[i] = BS_UNREACHABLE;
  }
}
