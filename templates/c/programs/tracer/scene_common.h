/* bladesmith: what the tracer's loops share, whatever the precision. */
#ifndef BLADESMITH_SCENE_COMMON_H
#define BLADESMITH_SCENE_COMMON_H

/* A function of its own: called from several places, and visible in the compiled file under its own name. */
#if defined(__CUDACC__)
#define BS_OUTLINED static __device__ __noinline__
#elif defined(__GNUC__)
#define BS_OUTLINED static __attribute__((noinline, unused))
#else
#define BS_OUTLINED static
#endif

/* A function of a part of a scene that may be a unit by itself: the others of the same library call it, and nobody else. */
#if defined(__GNUC__)
#define BS_SHARED __attribute__((visibility("hidden")))
#else
#define BS_SHARED
#endif
#if BS_SCENE_APART
#define BS_SURFACE BS_SHARED
#else
#define BS_SURFACE BS_OUTLINED
#endif

/* Two to that many rays share a checksum: they are one range of the loop. */
enum { BS_CHECKSUM_BITS = 12 };

/* The codes of bladesmith.Status that a ray can meet. */
enum { BS_STATUS_OK = 0, BS_STATUS_INVALID = 6 };

/* Rays that one thread takes through the tree at the same time: more gain nothing. */
#if defined(__CUDACC__)
enum { BS_RAYS_IN_WORK = 1 };
#else
enum { BS_RAYS_IN_WORK = 4 };
#endif

/* Roundings of numbers of 32 bits about 1, more than nodes are asked with. */
#define BS_TREE_MARGIN (32 * 5.9604644775390625e-8)

/* Memory that is read as a structure, though it was declared as an array. */
#if defined(__GNUC__) && !defined(__CUDACC__)
#define BS_MAY_ALIAS __attribute__((may_alias))
#else
#define BS_MAY_ALIAS
#endif

#endif
