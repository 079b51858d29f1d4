/* bladesmith: the structures and functions of the registration driver, as C and cffi read them. Python owns all arrays.
   Kinds are numbered point, point pair, line, circle, plane, sphere in every program, whichever of them it has. */

typedef struct {
  ptrdiff_t counts[6];       /* objects of each kind */
  const double *rows[6];     /* their coefficients */
} bs_model;

/* Elements (position, direction, radius) of the reference objects of one kind, in the cells of a grid of positions.
   What lies beyond the grid is in its outermost cells. */
typedef struct {
  double corner[3], scale;   /* where cell 0, 0, 0 begins, and cells per length */
  int32_t sides[3];          /* cells along each axis */
  const int32_t *starts;     /* (cells + 1): where the objects of a cell stand in what follows */
  const int32_t *order;      /* (count): their rows, rising within a cell */
  const double *elements;    /* (count, 7) */
} bs_grid;

typedef struct {
  bs_model query, reference;
  bs_grid grids[6];
  ptrdiff_t asked;           /* query objects that are looked at, in this order */
  const int32_t *asked_kinds, *asked_rows;
  double weights[3];         /* of squared differences of positions, directions and radii */
  double limit;              /* the sum of them up to which two objects may be one */
  double least;              /* share of objects with a counterpart below which a motor is given up early */
  int32_t align;             /* objects have no orientation: x and -x are one */
} bs_reform;

typedef struct {
  ptrdiff_t size;            /* pairs of a sample */
  const int32_t *kinds, *query, *reference; /* (samples, size): which objects are one, by their rows of a kind */
  const double *signs;       /* (samples, size): +1, or -1 for a reference object turned round */
  double residual;           /* mean of |R X - Y R|^2 up to which a sample is consistent */
  double *motors;            /* (samples, 8) */
  double *scores;            /* (samples): sum of 1 - (distance^2/limit) of the objects with a counterpart; -1: none */
  int32_t *hits, *tested;    /* (samples): objects with a counterpart, of how many */
} bs_samples;

typedef struct {
  ptrdiff_t size;            /* objects of a set */
  const int32_t *kinds, *query; /* (sets, size): query objects; kind -1 leaves one out */
  double *stiffness;         /* (sets): least pivot of the twists' form |B X - X B|^2, 0 where a motion is free */
} bs_sets;

typedef struct {
  ptrdiff_t rounds;          /* at most */
  double settled;            /* |change of the motor|^2 that ends it */
  double *motors;            /* (candidates, 8): where to start, and the result */
  double *scores;            /* (candidates) */
  int32_t *hits, *taken;     /* (candidates): objects with a counterpart; rounds that it took, -1: it came to nothing */
} bs_refined;

typedef struct {
  const double *motor;       /* 8 */
  int32_t *indices;          /* (asked): row of the counterpart, -1 for none */
  double *distances;         /* (asked): the weighted square; the limit for none */
  double *signs;             /* (asked): -1 where the counterpart is turned round */
} bs_matching;

typedef struct {
  ptrdiff_t count;           /* matches */
  int32_t kind;
  const int32_t *query, *reference; /* (count): rows */
  const double *motor;       /* 8 */
  double *rates;             /* (count, 28): cost, its gradient (6) and Gauss-Newton matrix (21) by the twist */
} bs_rates;

typedef struct {
  ptrdiff_t count;           /* matches */
  const int32_t *kinds, *query, *reference; /* (count): which objects are one, by their rows of a kind */
  const int32_t *partners;   /* (count): another match of the kind, which gives points and spheres an axis; -1: none */
  const double *signs;       /* (count): +1, or -1 for a reference object turned round */
  ptrdiff_t rounds;          /* at most */
  double tolerance;          /* change of the motor in a round that ends it */
  double *motor;             /* 8: where to start, and where the last round ends */
  double *mean;              /* 8: the middle of all motors of the last round */
  double *changes;           /* (rounds) */
  int32_t taken, skipped;    /* results: rounds, and steps of the last one that were not finite */
} bs_direct;

typedef struct {
  ptrdiff_t count;           /* objects */
  const int32_t *kinds;      /* (count) */
  const double *elements;    /* (count, 7) */
  ptrdiff_t rounds;          /* of leaving out far ones, at most */
  ptrdiff_t place;           /* the object that many are nearer than is as far as is usual */
  double far;                /* times as far: too far */
  double rounding;           /* of distances, relative to the largest coordinate */
  double rank_tolerance;              /* directions of which objects say less, relative to the most, are left */
  double *point;             /* 3: result */
  double *squares, *ordered; /* (count): room to work */
  int32_t *near;             /* (count): 1 for objects that count */
} bs_center;

const char *bs_source_hash(void);
/* Elements (count, 7) of objects; weighted squares of how far two of a kind are apart (weights of squared differences of
   positions, directions and radii; other: -1 where x and -x are one, else 1); objects as they are seen from an origin (3); the point nearest to objects; motors
   (count, 8) between frames about two positions, and twists (count, 6) of one, as the world sees them. Invariants
   (count, 4) of pairs of objects by their rows, kinds in order; the motor next to (1 + b) R. */
void bs_reform_elements(int kind, const double *rows, double *elements, ptrdiff_t count);
void bs_reform_to_frame(int kind, const double *rows, const double *origin, double *found, ptrdiff_t count);
void bs_reform_squared_distances(int kind, const double *a, const double *b, const double *weights, double other, double *squares,
                     ptrdiff_t begin, ptrdiff_t end);
void bs_reform_robust_center(const bs_center *middle);
void bs_reform_motors_to_world(const double *motors, const double *to, const double *back, double *found, ptrdiff_t count);
void bs_reform_twists_to_world(const double *twists, const double *origin, double *found, ptrdiff_t count);
void bs_reform_invariants(int first_kind, const double *first_rows, const int32_t *first, int second_kind,
                          const double *second_rows, const int32_t *second, double *invariants, ptrdiff_t begin,
                          ptrdiff_t end);
void bs_reform_step(const double *motor, const double *twist, double *out);
void bs_reform_rates(const bs_reform *state, const bs_rates *rates, ptrdiff_t begin, ptrdiff_t end);
void bs_reform_samples(const bs_reform *state, const bs_samples *samples, ptrdiff_t begin, ptrdiff_t end);
void bs_reform_stiffness(const bs_reform *state, const bs_sets *sets, ptrdiff_t begin, ptrdiff_t end);
void bs_reform_refine(const bs_reform *state, const bs_refined *refined, ptrdiff_t begin, ptrdiff_t end);
void bs_reform_direct(const bs_reform *state, bs_direct *direct);
void bs_reform_match(const bs_reform *state, const bs_matching *matching, ptrdiff_t begin, ptrdiff_t end);
