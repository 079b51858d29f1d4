/* bladesmith: small least squares for constraints. A system of rows is brought to orthonormal directions, the newest
   row first; rows that say nothing new are left out. Directions are measured by kinetic energy, so that one unit of
   mass or length is as good as another. */

typedef struct {
  int rows, rank, excess;            /* whether rows are left that say something new, beyond the most directions */
  double matrix[BS_ROWS][BS_SIZE];   /* on twists */
  double right[BS_ROWS], errors[BS_ROWS], rates[BS_ROWS];
  double sizes[BS_ROWS];             /* of what errors are made of */
  int bodies[BS_ROWS];               /* which body a row is of */
  double scale[BS_ROWS];             /* of each row, by energy */
  double direction[BS_RANK][BS_SIZE];
  double upper[BS_RANK][BS_RANK];
  int order[BS_RANK];                /* which row each direction came from */
} FN(system);

/* Directions of the rows, `limit` at most unless that is zero; weights are roots of the metric's inverse. Stages of a step
   are a little off the constraints, where rows that say the same begin to differ: no more directions than there were. */
static void FN(factor)(FN(system) *s, const double *weights, double tolerance, int limit)
{
  static const int most = BS_SIZE < BS_ROWS ? BS_SIZE : BS_ROWS;
  double left[BS_ROWS][BS_SIZE], share[BS_ROWS][BS_RANK], norms[BS_ROWS], most_of_all = 0;
  for (int i = 0; i < s->rows; i++) {
    double square = 0;
    for (int j = 0; j < BS_SIZE; j++) {
      left[i][j] = s->matrix[i][j] * weights[j];
      square += left[i][j] * left[i][j];
    }
    s->scale[i] = sqrt(square);
    most_of_all = fmax(most_of_all, s->scale[i]);
  }
  for (int i = 0; i < s->rows; i++) { /* what is left of a row by rounding is none */
    norms[i] = s->scale[i] > BS_NO_MOTION * most_of_all;
    for (int j = 0; norms[i] > 0 && j < BS_SIZE; j++) left[i][j] /= s->scale[i];
  }
  s->rank = s->excess = 0;
  while (s->rank < most) {
    int best = -1;
    const int k = s->rank;
    for (int i = 0; i < s->rows; i++)
      if (norms[i] > tolerance * tolerance && (best < 0 || norms[i] > norms[best])) best = i;
    if (best < 0) break;
    double *q = s->direction[k], square = 0;
    for (int j = 0; j < BS_SIZE; j++) q[j] = left[best][j];
    for (int i = 0; i < k; i++) { /* once more: what rounding left */
      double c = 0;
      for (int j = 0; j < BS_SIZE; j++) c += s->direction[i][j] * q[j];
      for (int j = 0; j < BS_SIZE; j++) q[j] -= c * s->direction[i][j];
      s->upper[i][k] = share[best][i] + c;
    }
    for (int j = 0; j < BS_SIZE; j++) square += q[j] * q[j];
    s->upper[k][k] = sqrt(square);
    if (!(s->upper[k][k] > tolerance)) {
      norms[best] = 0;
      continue;
    }
    if (limit && k == limit) {
      s->excess = s->upper[k][k] > BS_COARSE; /* a small share is rounding far from the origin */
      break;
    }
    for (int j = 0; j < BS_SIZE; j++) q[j] /= s->upper[k][k];
    s->order[k] = best;
    s->rank++;
    norms[best] = 0;
    for (int i = 0; i < s->rows; i++) {
      if (!(norms[i] > 0)) continue;
      double c = 0, rest = 0;
      for (int j = 0; j < BS_SIZE; j++) c += q[j] * left[i][j];
      for (int j = 0; j < BS_SIZE; j++) {
        left[i][j] -= c * q[j];
        rest += left[i][j] * left[i][j];
      }
      share[i][k] = c;
      norms[i] = rest;
    }
  }
}

/* The least change, by energy, of a motion x (twists) that gives the rows the values asked for; the change by itself
   goes to change, times the roots of the metric: the rows of the force behind it are that times the roots again. */
static void FN(solve)(const FN(system) *s, const double *weights, const double *wanted, double *x, double *change)
{
  double y[BS_RANK];
  for (int k = 0; k < s->rank; k++) {
    const int i = s->order[k];
    double value = wanted[i];
    for (int j = 0; j < BS_SIZE; j++) value -= s->matrix[i][j] * x[j];
    value /= s->scale[i];
    for (int j = 0; j < k; j++) value -= s->upper[j][k] * y[j];
    y[k] = value / s->upper[k][k];
  }
  for (int j = 0; j < BS_SIZE; j++) {
    double sum = 0;
    for (int k = 0; k < s->rank; k++) sum += s->direction[k][j] * y[k];
    if (change) change[j] = sum;
    x[j] += weights[j] * sum;
  }
}
