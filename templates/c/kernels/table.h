/* bladesmith: what units of kernels and the extension that calls them know of each other. */
#ifndef BLADESMITH_TABLE_H
#define BLADESMITH_TABLE_H

#include "platform.h"

#ifndef BS_SOURCE_HASH
#define BS_SOURCE_HASH ""
#endif

/* Items [begin, end) of a kernel: results, operands, strides of operands. */
typedef void (*bs_batch)(ptrdiff_t, ptrdiff_t, void *const *, const void *const *, const ptrdiff_t *);

/* Kernels of one module of formulas, compiled for one instance. */
typedef struct {
  const char *module, *instance, *hash;
  int count;
  const bs_batch *loops;
} bs_unit;

#if defined(__GNUC__)
#define BS_HIDDEN __attribute__((visibility("hidden"))) /* of the extension that it is linked into */
#else
#define BS_HIDDEN
#endif

#define BS_STRING_(x) #x
#define BS_STRING(x) BS_STRING_(x)
#define BS_INSTANCE BS_STRING(BS_TAG)

#endif
