/* bladesmith: the structures and functions of a mechanism's driver, as C and cffi read them. Python owns all arrays.
   Everything is in the mechanism's own frame and unit of length. A motor is 8 numbers, a twist 6. */

typedef struct {
  const double *numbers;     /* of the mechanism: what its joints share, forbid and leave */
  double tolerance;          /* shares of rows below which they say nothing new */
  double open;               /* of a unit speed, what counts as rounding */
  double step;               /* turns, and lengths, that one step of Newton's method takes at most */
  double closed;             /* errors that are none */
  double nearly;             /* errors that are rounding, where they grow no less */
  int32_t rounds;            /* at most */
} bs_mechanism;

/* Poses of some items: links seen from their parents, moved from start until driven coordinates and targets are met.
   Along a path each item starts where the one before it came to. */
typedef struct {
  ptrdiff_t steps;           /* items of a path; ranges are of paths */
  double *links;             /* (items, bodies, 8): in, of paths the first alone, and out */
  double *driven;            /* (items, driven coordinates): how far each is still to go, from the item before */
  const double *targets;     /* (items, numbers of targets): motors, points */
  double *motors;            /* (items, bodies, 8): out */
  double *residual;          /* (items): the largest error that is left */
  int32_t *status;           /* (items): 0 done, 1 errors grow no less, 2 not yet after all rounds, 3 not finite */
} bs_poses;

typedef struct {
  const double *links;       /* (items, bodies, 8) */
  double *jacobian;          /* (items, outputs, inputs) */
  double *residual;          /* (items): the largest error of what joints share */
  int32_t *status;           /* (items): 0 done, 1 outputs are left open, 2 inputs are not allowed, 3 not finite */
  int32_t general;           /* all at once, by orthogonal directions */
} bs_jacobians;

/* Bytes of the workspace that a thread brings along, aligned as doubles are; nothing is kept there between calls. */
size_t bs_mechanism_workspace(void);
void bs_mechanism_poses(const bs_mechanism *m, const bs_poses *p, void *workspace, ptrdiff_t begin, ptrdiff_t end);
void bs_mechanism_jacobians(const bs_mechanism *m, const bs_jacobians *j, void *workspace, ptrdiff_t begin,
                            ptrdiff_t end);
/* Links as parents see them, of motors (items, bodies, 8), and the other way round. */
void bs_mechanism_links(const double *motors, double *links, ptrdiff_t begin, ptrdiff_t end);
