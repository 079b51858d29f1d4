/* bladesmith: arrays and structures of functions. Where a program has about BS_NUMBERS numbers and these are few, they are
   the function's own, on the stack, where the compiler keeps them in registers; else they are a part of a workspace that
   the caller allocates for each thread: threads of pools have stacks of 512 KiB and less. */

#ifndef BS_MOST_ON_STACK
#define BS_MOST_ON_STACK 8192
#endif

#if BS_NUMBERS <= BS_MOST_ON_STACK
#define BS_ARRAY(part, type, name, count) type name[count]
#define BS_MATRIX(part, type, name, rows, count) type name[rows][count]
#define BS_STRUCTURE(part, type, name) type name##_own, *const name = &name##_own
#define BS_STEPS_AT_ONCE 256 /* between two looks at whether to give up */
_Static_assert(sizeof(FN(workspace)) <= 16 * BS_MOST_ON_STACK, "the workspace is too large for the stack");
#else
#define BS_ARRAY(part, type, name, count) type (*const name##_all)[count] = &(part).name, *const name = *name##_all
#define BS_MATRIX(part, type, name, rows, count) type (*const name##_all)[rows][count] = &(part).name, (*const name)[count] = *name##_all
#define BS_STRUCTURE(part, type, name) type *const name = &(part).name
#define BS_STEPS_AT_ONCE 1
#endif
