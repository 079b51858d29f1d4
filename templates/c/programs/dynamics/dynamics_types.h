/* bladesmith: the structures and functions of the dynamics driver, as C and cffi read them. Python owns all arrays.
   A motor is 8 numbers, a twist 6; a row of 6 is a linear function of twists: of a wrench its powers on unit twists. */

/* One pinned object: A[~S V S] = H, where S is the motor of the body, or that of it as another body sees it. */
typedef struct {
  int32_t layout;            /* which blades V has; -1: V is a wrench without power on the relative twist */
  int32_t body, other;       /* other: -1 for the world */
  int32_t rows;              /* equations */
  int32_t user;              /* function of time that gives V, dV, ddV, H, dH, ddH, unknown; -1 for none */
  ptrdiff_t v, h, a;         /* where V, H and A (rows by coefficients of V; -1: one) stand in a simulation's numbers */
  double unknown;            /* by how much errors may be off, for what a V without function is made of */
} bs_constraint;

typedef struct {
  int32_t body;
  int32_t world;             /* the function gives a wrench of the world, not of the body */
  int32_t user;              /* which function */
} bs_user_load;

typedef struct {
  const double *numbers;     /* (simulations, stride): constants of a simulation */
  ptrdiff_t stride;          /* 0: all have the same */
  ptrdiff_t bodies;          /* where the bodies stand in them: BS_BODY_SIZE numbers each */
  ptrdiff_t springs;         /* and the springs: two points, stiffness, length at rest, damping */
  int32_t spring_count, constraint_count, load_count;
  const int32_t *spring_bodies; /* (springs, 2): -1 for the world */
  const bs_constraint *constraints;
  const bs_user_load *loads;
  double tolerance;          /* a row of which less than this share is new is redundant */
  double baumgarte;          /* rate at which errors of constraints are made to decay; 0 for none */
  int32_t project;           /* poses and twists are brought back to the constraints after each step */
  void *handle;              /* what the user's functions are called with */
  const double *directions;  /* (simulations, tangents, stride): tangents of the numbers */
} bs_dynamics;

/* How steps are taken: a Runge-Kutta scheme of some stages, or a composition of flows. */
typedef struct {
  int32_t method;            /* see dynamics_run.h */
  int32_t stages, order;     /* order of the error estimate, for steps that adapt themselves */
  const double *a, *b, *c;   /* (all stages, stages), (stages), (all stages) */
  const double *errors;      /* (2, stages + 1): two estimates */
  const double *dense;       /* (rows of the interpolant, all stages) */
  int32_t all_stages, dense_rows;
  const double *composition; /* shares of a step, of flows and their adjoints in turn */
  int32_t parts;
  double step;               /* at most */
  double rtol, atol;
} bs_method;

typedef struct {
  const double *times;       /* (stores) */
  ptrdiff_t stores, last;    /* of them those before last are computed now */
  double *memory;            /* (simulations, what bs_dynamics_memory says) */
  double *motors;            /* (simulations, stores, bodies, 8) */
  double *twists;            /* (simulations, stores, bodies, 6): in the bodies' frames */
  double *reactions;         /* (simulations, stores, bodies, 6): wrenches of the world */
  double *violations;        /* (simulations, stores) */
  int32_t *status;           /* (simulations) */
  double *reached;           /* (simulations): time of the last state */
  int64_t *steps;            /* (simulations) */
  int64_t *stored;           /* (simulations): stores that were written */
  int64_t budget;            /* steps of a simulation in one call: what is left is for the next */
  double *start;             /* (simulations, 2): how far the start is off the constraints: poses, as shares of the bodies'
                                sizes and distances or in radians, and rates, as shares of the bodies' own */
  int32_t *start_rows;       /* (simulations, 2): and of which row */
  double *off;               /* (simulations, 2): how far the last state stays off them, and of which row */
  int32_t project_start;     /* bring the start to the constraints */
  const int32_t *stop;       /* not 0: give up */
  const double *start_tangents; /* (simulations, tangents, 2, bodies, 6): of motors, as twists in their frames; of twists */
  double *tangents;          /* (simulations, stores, tangents, 2, bodies, 6) */
} bs_run;

/* Bytes of the workspace that a thread brings along, aligned as doubles are; nothing is kept there between calls. */
size_t bs_dynamics_workspace(void);
ptrdiff_t bs_dynamics_memory(const bs_method *method);
void bs_dynamics_start(const bs_dynamics *model, const bs_method *method, const bs_run *run, const double *motors,
                       const double *twists, void *workspace, ptrdiff_t begin, ptrdiff_t end);
void bs_dynamics_run(const bs_dynamics *model, const bs_method *method, const bs_run *run, void *workspace,
                     ptrdiff_t begin, ptrdiff_t end);
/* At one state (bodies): accelerations (bodies, 6), rows of the reactions (bodies, 6), the matrix of the constraints
   (rows, bodies, 6), their right sides and errors (rows) and the errors' rates (rows); the rank, or -1. */
int32_t bs_dynamics_evaluate(const bs_dynamics *model, double t, const double *motors, const double *twists,
                         double *accelerations, double *reactions, double *matrix, double *right, double *errors,
                         double *rates, void *workspace);
int32_t bs_dynamics_project(const bs_dynamics *model, double t, double tolerance, double *motors, double *twists,
                            void *workspace);
const char *bs_source_hash(void);
