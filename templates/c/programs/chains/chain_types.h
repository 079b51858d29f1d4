/* bladesmith: the structures and functions of the driver of serial chains, as C and cffi read them. Python owns all
   arrays. A motor is 8 numbers, a twist 6; places are seen from the chain's base. */

typedef struct {
  const double *joints;      /* (joints, 8): way from the joint before, axis, turn and advance for a unit of x */
  const double *links;       /* (joints, 7): of each link's frame the place as seen from the joint, and the rotor */
  const double *tool;        /* 7 */
  const double *base;        /* 3 */
  ptrdiff_t count;
} bs_chain;

/* How poses are sought. */
typedef struct {
  const double *lower, *upper; /* (joints) */
  const double *kicks;       /* (attempts, joints): where the next attempt starts, after the first */
  int32_t attempts, iterations; /* iterations of each attempt */
  double tolerance;          /* of the turn in radians, and of the place in units of length */
  double length;             /* of the chain: what a radian is worth */
  double reach;              /* from the base; infinite if it is not known */
  int32_t nearest;           /* what is out of reach is approached all the same */
} bs_search;

typedef struct {
  double *x;                 /* (items, joints) */
  int32_t *status;           /* (items): of bladesmith.Status */
  double *errors;            /* (items, 2): what is left, a turn and a length */
  int32_t *steps;            /* (items) */
  int32_t *rank;             /* (items): directions in which the joints can move the tool there */
} bs_found;

/* Which instance runs, 0 the one without vectors; how many there are. */
int32_t bs_chain_instances(void);
int32_t bs_chain_runs(int32_t instance);
/* Motors (items, 8) of the tool, or (items, joints, 8) of all links. */
void bs_chain_forward(const bs_chain *chain, int32_t instance, const double *x, int32_t all, double *motors,
                      ptrdiff_t begin, ptrdiff_t end);
/* Matrices (items, 6, joints): turns and velocities along the world's axes (frame 0: of what is at the world's origin, 1:
   at a point of the tool) or the tool's (2: at the point). Points (items, 3), or one for all with stride 0. */
void bs_chain_jacobian(const bs_chain *chain, int32_t instance, const double *x, int32_t frame, const double *points,
                       ptrdiff_t stride, double *matrices, ptrdiff_t begin, ptrdiff_t end);
/* Twists of the world and their rates (items, 6), or of all links (items, joints, 6). */
void bs_chain_twists(const bs_chain *chain, int32_t instance, const double *x, const double *speeds,
                     const double *pushes, int32_t all, double *twists, double *rates, ptrdiff_t begin, ptrdiff_t end);
/* Joints that bring the tool to motors (items, 8), from starts (items, joints). */
void bs_chain_inverse(const bs_chain *chain, const bs_search *search, const double *motors, const double *starts,
                      const bs_found *found, ptrdiff_t begin, ptrdiff_t end);
const char *bs_source_hash(void);
