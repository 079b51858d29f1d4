/* bladesmith: the structure and functions of the merging driver, as C and cffi read them. Python owns all arrays. */

typedef struct {
  /* objects by slot; a mean takes the slot of the first of its two objects */
  ptrdiff_t count;          /* slots */
  ptrdiff_t live;           /* objects that are left */
  int32_t kind;             /* number of the kind, in the order of the program */
  int32_t align;            /* objects without an orientation: X and -X are one */
  double threshold;         /* the greatest cost of a pair that is merged */
  double *rows;             /* coefficients */
  double *weights;          /* what each counts for in a mean */
  int32_t marks;            /* numbers of a landmark: bs_merge_marks() */
  double *landmarks;        /* as merge_tree.h says */
  int32_t *versions;        /* how often a slot's object has changed; -1: it is gone */
  /* what was found for each: its nearest other object within the threshold */
  int32_t *nearest;         /* slot, -1 for none */
  int32_t *seen;            /* version of that object when it was found */
  double *costs;
  /* slots that have a neighbour, the cheapest pair first */
  int32_t *heap, *heap_place;
  ptrdiff_t heap_size;
  /* a balanced tree over the slots that lived when it was built: nodes 1 .. 2^(levels + 1) - 1 */
  ptrdiff_t built;
  int32_t levels;
  int32_t *order;           /* slots, leaf by leaf; -1: the object is gone */
  int32_t *tree_place;      /* by slot: its place in that */
  double *leaves;           /* landmarks in that order: what is read together lies together */
  int32_t *alive;           /* by node: objects that are left */
  double *boxes;            /* by node: least and greatest landmark */
  double slack;             /* rounding of landmarks, as a length */
  /* what was merged, in order */
  ptrdiff_t merges;
  double *merged_costs;
  int32_t *kept, *gone;
  int64_t evaluations;      /* costs that were computed */
} bs_merge;

const char *bs_source_hash(void);
const char *bs_merge_kind(int number);
int bs_merge_marks(int number);
void bs_merge_begin(bs_merge *state);
int64_t bs_merge_find(const bs_merge *state, ptrdiff_t begin, ptrdiff_t end);
void bs_merge_queue(bs_merge *state);
ptrdiff_t bs_merge_step(bs_merge *state, ptrdiff_t most);
double bs_merge_bound(const bs_merge *state, ptrdiff_t first, ptrdiff_t second);
