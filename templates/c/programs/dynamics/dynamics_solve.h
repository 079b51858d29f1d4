/* bladesmith: least squares for constraints. A system of rows is brought to orthonormal directions, the newest
   row first; rows that say nothing new are left out. Directions are measured by kinetic energy, so that one unit of
   mass or length is as good as another. */

/* Columns of twists from which on it is worth to look where rows are zero; sums without zeros are the same bits. */
#ifndef BS_SPARSE
#define BS_SPARSE 96
#endif

typedef struct {
  int rows, rank, excess;            /* whether rows are left that say something new, beyond the most directions */
  double matrix[BS_ROWS][BS_SIZE];   /* on twists */
  double right[BS_ROWS], errors[BS_ROWS], rates[BS_ROWS];
  double sizes[BS_ROWS];             /* of what errors are made of */
  double rounding[BS_ROWS];          /* of errors */
  double noise[BS_ROWS];             /* rounding of each row, by energy */
  int bodies[BS_ROWS];               /* which body a row is of */
  int powers[BS_ROWS];               /* whether it is of rates alone */
  double unknown[BS_ROWS];           /* by how much errors may be off, for what they are made of */
  double scale[BS_ROWS];             /* of each row, by energy */
  double largest, made_of;           /* of scale and of sizes */
  double direction[BS_RANK][BS_SIZE];
  double upper[BS_RANK][BS_RANK];
  int order[BS_RANK];                /* which row each direction came from */
  double left[BS_ROWS][BS_SIZE];     /* of each row, by energy and of length one, off the directions so far */
  double share[BS_ROWS][BS_RANK];    /* of each row, what the directions took */
  double norms[BS_ROWS], least[BS_ROWS]; /* squares of what is left; roots of what counts as nothing */
  double solution[BS_RANK];          /* along the directions */
  double squares[BS_ROWS];           /* sums of what is left */
  int first[BS_ROWS], last[BS_ROWS]; /* columns of what is left: others are zero */
  int from[BS_RANK], to[BS_RANK];    /* and of directions */
  const int32_t *stop;               /* not 0: give up; 0: never */
} FN(system);

/* Directions of the rows, `limit` at most unless that is zero; weights are roots of the metric's inverse. Stages of a step
   are a little off the constraints, where rows that say the same begin to differ: no more directions than there were.
   Rows of which much is rounding come last, and what is left of them is none. */
static void FN(factor)(FN(system) *s, const double *weights, double tolerance, int limit)
{
  static const int most = BS_SIZE < BS_ROWS ? BS_SIZE : BS_ROWS;
  static const int sparse = BS_SIZE > BS_SPARSE;
  double (*const left)[BS_SIZE] = s->left, (*const share)[BS_RANK] = s->share;
  double *const norms = s->norms, *const least = s->least;
  s->largest = s->made_of = 0;
  for (int i = 0; i < s->rows; i++) {
    double square = 0;
    for (int j = 0; j < BS_SIZE; j++) {
      left[i][j] = s->matrix[i][j] * weights[j];
      square += left[i][j] * left[i][j];
    }
    s->scale[i] = sqrt(square);
    s->largest = fmax(s->largest, s->scale[i]);
    s->made_of = fmax(s->made_of, s->sizes[i]);
  }
  for (int i = 0; i < s->rows; i++) { /* what is left of a row by rounding is none */
    const double rounding = BS_ROUNDINGS * s->noise[i];
    norms[i] = s->scale[i] > fmax(BS_NO_MOTION * s->largest, rounding);
    least[i] = norms[i] > 0 ? fmax(tolerance, rounding / s->scale[i]) : 1;
    for (int j = 0; norms[i] > 0 && j < BS_SIZE; j++) left[i][j] /= s->scale[i];
    if (!sparse) continue;
    s->first[i] = BS_SIZE;
    s->last[i] = 0;
    s->squares[i] = 0;
    for (int j = 0; j < BS_SIZE; j++) {
      if (left[i][j] == 0) continue;
      s->first[i] = s->last[i] ? s->first[i] : j;
      s->last[i] = j + 1;
      s->squares[i] += left[i][j] * left[i][j];
    }
  }
  s->rank = s->excess = 0;
  while (s->rank < most) {
    int best = -1;
    double clearest = 1;
    const int k = s->rank;
    for (int i = 0; i < s->rows; i++) {
      const double clear = norms[i] / (least[i] * least[i]); /* of rounding */
      if (!(clear > clearest)) continue;
      best = i;
      clearest = clear;
    }
    if (best < 0 || (s->stop && *(const volatile int32_t *)s->stop)) break;
    double *const q = s->direction[k], square = 0;
    for (int j = 0; j < BS_SIZE; j++) q[j] = left[best][j];
    if (sparse) {
      s->from[k] = s->first[best];
      s->to[k] = s->last[best];
    }
    for (int i = 0; i < k; i++) { /* once more: what rounding left */
      const int from = sparse ? s->from[i] : 0, to = sparse ? s->to[i] : BS_SIZE;
      double c = 0;
      for (int j = from; j < to; j++) c += s->direction[i][j] * q[j];
      for (int j = from; j < to; j++) q[j] -= c * s->direction[i][j];
      if (sparse && c != 0) {
        s->from[k] = from < s->from[k] ? from : s->from[k];
        s->to[k] = to > s->to[k] ? to : s->to[k];
      }
      s->upper[i][k] = share[best][i] + c;
    }
    for (int j = 0; j < BS_SIZE; j++) square += q[j] * q[j];
    s->upper[k][k] = sqrt(square);
    if (!(s->upper[k][k] > least[best])) {
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
      if (sparse && (s->last[i] <= s->from[k] || s->to[k] <= s->first[i])) rest = s->squares[i];
      else {
        if (sparse) {
          s->first[i] = s->from[k] < s->first[i] ? s->from[k] : s->first[i];
          s->last[i] = s->to[k] > s->last[i] ? s->to[k] : s->last[i];
        }
        const int from = sparse ? s->from[k] : 0, to = sparse ? s->to[k] : BS_SIZE;
        for (int j = from; j < to; j++) c += q[j] * left[i][j];
        for (int j = from; j < to; j++) left[i][j] -= c * q[j];
        for (int j = sparse ? s->first[i] : 0; j < (sparse ? s->last[i] : BS_SIZE); j++) rest += left[i][j] * left[i][j];
        s->squares[i] = rest;
      }
      share[i][k] = c;
      norms[i] = rest;
    }
  }
}

/* The least change, by energy, of a motion x (twists) that gives the rows the values asked for; the change by itself
   goes to change, times the roots of the metric: the rows of the force behind it are that times the roots again. */
static BS_UNUSED void FN(solve)(FN(system) *s, const double *weights, const double *wanted, double *x, double *change)
{
  double *const y = s->solution;
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
