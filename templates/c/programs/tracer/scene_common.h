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

enum {
  BS_ROOTS_MOST = BS_SCENE_ROOTS, /* of one ray and one row */
  BS_HITS_MOST = 2 * BS_ROOTS_MOST, /* a root that only touches may have two points */
  BS_CAMERA_LENS = 8 /* after the motor */
};

/* Two to that many rays share a checksum: they are one range of the loop. */
enum { BS_CHECKSUM_BITS = 12 };

/* The codes of bladesmith.Status that a ray can meet. */
enum { BS_STATUS_OK = 0, BS_STATUS_SINGULAR = 1, BS_STATUS_INVALID = 6 };

/* The tree: parts of a node, what stands where there is none, and room for the nodes that wait while others are
   searched: all but one of each level's, and all of one more. scene_build.h keeps to it. */
enum {
  BS_PARTS = 4,
  BS_NO_PART = -2147483647 - 1,
  BS_TREE_LEVELS = 48,
  BS_TREE_STACK = (BS_TREE_LEVELS + 1) * BS_PARTS
};

/* Rays that one thread takes through the tree at the same time: more gain nothing. */
#if defined(__CUDACC__)
enum { BS_RAYS_IN_WORK = 1 };
#else
enum { BS_RAYS_IN_WORK = 4 };
#endif

/* Roundings of numbers of 32 bits about 1, more than nodes are asked with. */
#define BS_TREE_MARGIN (32 * 5.9604644775390625e-8)

/* Rows of surfaces along curves: where a piece begins on the curve, and then how long it is there. */
enum { BS_ROW_START = 5 };

/* Two pieces of a curve find a point of their joint at parameters that differ by roundings, a thousand times as many
   where the ray grazes, and at places that may lose half of the digits where it touches. */
#define BS_JOINT_ALPHA(T) ((T)(sizeof(T) == 4 ? 1024 * 5.9604644775390625e-8 : 65536 * 1.1102230246251565e-16))
#define BS_JOINT_PLACE(T) ((T)(sizeof(T) == 4 ? 3.4526698300124393e-4 : 1.4901161193847656e-8))

/* What a camera sees is at least so far away, in roundings of the numbers that the point was made of: one that stands
   on a surface looks through it. Less in single precision, where a camera may be near the ground of a large scene. */
#define BS_LEAST(T) ((T)(sizeof(T) == 4 ? 256 * 5.9604644775390625e-8 : 65536 * 1.1102230246251565e-16))

/* Rays that leave a surface start this many units in the last place off it, relative to the numbers that the
   point was made of: more than the error of a hit, less than anything that can be seen. */
#define BS_OFFSET(T) ((T)(sizeof(T) == 4 ? 4096 * 5.9604644775390625e-8 : 65536 * 1.1102230246251565e-16))

#endif
