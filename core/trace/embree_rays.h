// Compiles against Embree 3.13 (Debian 12) and 4 (Debian 13); only accel.cpp includes this.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "core/trace/accel.h"

namespace photond {

// As Accel's functions, in one of Embree's scenes.
Hit intersect_ray(RTCScene scene, const Ray& ray);
bool occlude_ray(RTCScene scene, const Ray& ray);
void intersect_rays(RTCScene scene, const RayLanes& rays, std::uint32_t count, Coherence coherence, HitLanes& hits);
void occlude_rays(RTCScene scene, const RayLanes& rays, std::uint32_t count, std::uint8_t (&hidden)[kLanes]);

}  // namespace photond
