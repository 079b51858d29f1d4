/* bladesmith: what the tracer's loops share, whatever the precision. */
#ifndef BLADESMITH_SCENE_COMMON_H
#define BLADESMITH_SCENE_COMMON_H

/* A function of its own: called from several places, and visible in the compiled file under its own name. */
#if defined(__CUDACC__)
#define BS_OWN static __device__ __noinline__
#elif defined(__GNUC__)
#define BS_OWN static __attribute__((noinline, unused))
#else
#define BS_OWN static
#endif

enum {
  BS_ROOTS_MOST = 8, /* of one ray and one surface */
  BS_HITS_MOST = 2 * BS_ROOTS_MOST, /* a root that only touches may have two points */
  BS_MATERIAL_COLOR = 0,
  BS_MATERIAL_AMBIENT = 3,
  BS_MATERIAL_DIFFUSE = 4,
  BS_MATERIAL_SPECULAR = 5,
  BS_MATERIAL_SHININESS = 6,
  BS_MATERIAL_REFLECTIVITY = 7,
  BS_MATERIAL_SECOND = 8, /* color of the other squares of a checkered surface */
  BS_MATERIAL_ACROSS = 11, /* two vectors that count squares */
  BS_MATERIAL_SIZE = 17,
  BS_LIGHT_SIZE = 6,
  BS_CAMERA_LENS = 8 /* after the motor */
};

/* The codes of bladesmith.Status that a ray can meet. */
enum { BS_STATUS_OK = 0, BS_STATUS_SINGULAR = 1, BS_STATUS_INVALID = 6 };

/* Rays that leave a surface start this many units in the last place off it, relative to the numbers that the
   point was made of: more than the error of a hit, less than anything that can be seen. */
#define BS_OFFSET(T) ((T)(sizeof(T) == 4 ? 4096 * 5.9604644775390625e-8 : 65536 * 1.1102230246251565e-16))

#endif
