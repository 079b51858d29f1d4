/* bladesmith: functions of a scene that are compiled by themselves, and called from the driver: kinds of surface that
   take long, and the loop that meets several rays at once. */
#ifndef BLADESMITH_SCENE_APART_H
#define BLADESMITH_SCENE_APART_H

/* A function that other units of the same library call, and nobody else. */
#if defined(__GNUC__)
#define BS_SHARED __attribute__((visibility("hidden")))
#else
#define BS_SHARED
#endif

#define BS_APART_PREPARE(name) BS_SHARED int FN(name##_prepare_apart)(S *k, const S *parameters)
#define BS_APART_HITS(name) BS_SHARED void FN(name##_hits_apart)(FN(search) *search, const S *k, const FN(ray) *ray)
#define BS_APART_NORMAL(name) \
  BS_SHARED void FN(name##_normal_apart)(S *normal, const S *k, const FN(ray) *ray, const FN(hit) *hit)
#define BS_APART_WIDE \
  BS_SHARED void FN(scene_wide_apart)(const bs_scene *scene, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays, \
                                      const bs_hits *hits)

/* In the unit of a kind, behind its functions. */
#define BS_APART_UNIT(name) \
  BS_APART_PREPARE(name); \
  BS_APART_HITS(name); \
  BS_APART_NORMAL(name); \
  BS_APART_PREPARE(name) { return FN(name##_prepare)(k, parameters); } \
  BS_APART_HITS(name) { FN(name##_hits)(search, k, ray); } \
  BS_APART_NORMAL(name) { FN(name##_normal)(normal, k, ray, hit); }

/* In the driver, in place of the kind's functions. */
#define BS_APART_KIND(name) \
  BS_APART_PREPARE(name); \
  BS_APART_HITS(name); \
  BS_APART_NORMAL(name); \
  BS_INLINE int FN(name##_prepare)(S *k, const S *parameters) { return FN(name##_prepare_apart)(k, parameters); } \
  BS_INLINE void FN(name##_hits)(FN(search) *search, const S *k, const FN(ray) *ray) \
  { \
    FN(name##_hits_apart)(search, k, ray); \
  } \
  BS_INLINE void FN(name##_normal)(S *normal, const S *k, const FN(ray) *ray, const FN(hit) *hit) \
  { \
    FN(name##_normal_apart)(normal, k, ray, hit); \
  }

#endif
