#include "core/trace/embree_rays.h"

namespace photond {

namespace {

RTCRay make_ray(const Ray& from) {
  RTCRay ray;
  ray.org_x = from.origin.x;
  ray.org_y = from.origin.y;
  ray.org_z = from.origin.z;
  ray.tnear = 0;
  ray.dir_x = from.direction.x;
  ray.dir_y = from.direction.y;
  ray.dir_z = from.direction.z;
  ray.time = 0;
  ray.tfar = from.t_max;
  ray.mask = 0xffffffff;
  ray.id = 0;
  ray.flags = 0;
  return ray;
}

// Packets of eight rays: wider ones were no faster, and every CPU with AVX has these.
constexpr std::uint32_t kPacket = 8;
static_assert(kLanes % kPacket == 0);

struct alignas(32) Valid {
  int lanes[kPacket];   // −1 or 0

  explicit Valid(std::uint32_t count) {
    for (std::uint32_t i = 0; i < kPacket; ++i) lanes[i] = i < count ? -1 : 0;
  }
};

// Takes over the rays from `first` on.
void load_rays(const RayLanes& rays, std::uint32_t first, RTCRay8& packet) {
  for (std::uint32_t i = 0; i < kPacket; ++i) {
    packet.org_x[i] = rays.origin.x[first + i];
    packet.org_y[i] = rays.origin.y[first + i];
    packet.org_z[i] = rays.origin.z[first + i];
    packet.tnear[i] = 0;
    packet.dir_x[i] = rays.direction.x[first + i];
    packet.dir_y[i] = rays.direction.y[first + i];
    packet.dir_z[i] = rays.direction.z[first + i];
    packet.time[i] = 0;
    packet.tfar[i] = rays.t_max[first + i];
    packet.mask[i] = 0xffffffff;
    packet.id[i] = 0;
    packet.flags[i] = 0;
  }
}

void intersect_packet(RTCScene scene, const Valid& valid, Coherence coherence, RTCRayHit8& query) {
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  if (coherence == Coherence::high) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect8(valid.lanes, scene, &query, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (coherence == Coherence::high) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid.lanes, scene, &context, &query);
#endif
}

void occlude_packet(RTCScene scene, const Valid& valid, RTCRay8& ray) {
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded8(valid.lanes, scene, &ray);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded8(valid.lanes, scene, &context, &ray);
#endif
}

}  // namespace

Hit intersect_ray(RTCScene scene, const Ray& ray) {
  RTCRayHit query;
  query.ray = make_ray(ray);
  query.hit.u = query.hit.v = 0;
  query.hit.primID = 0;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene, &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
#endif
  static_assert(RTC_INVALID_GEOMETRY_ID == Hit::kNone);  // a miss needs no branch
  const bool instanced = query.hit.instID[0] != RTC_INVALID_GEOMETRY_ID;
  return {query.ray.tfar, query.hit.u, query.hit.v, query.hit.primID,
          instanced ? query.hit.instID[0] : query.hit.geomID};
}

bool occlude_ray(RTCScene scene, const Ray& ray) {
  RTCRay query = make_ray(ray);
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded1(scene, &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &query);
#endif
  return query.tfar < 0;
}

void intersect_rays(RTCScene scene, const RayLanes& rays, std::uint32_t count, Coherence coherence, HitLanes& hits) {
  for (std::uint32_t first = 0; first < count; first += kPacket) {
    RTCRayHit8 query;
    load_rays(rays, first, query.ray);
    for (std::uint32_t i = 0; i < kPacket; ++i) {
      query.hit.u[i] = query.hit.v[i] = 0;
      query.hit.primID[i] = 0;
      query.hit.geomID[i] = query.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    intersect_packet(scene, Valid(count - first), coherence, query);
    for (std::uint32_t i = 0; i < kPacket; ++i) {
      hits.t[first + i] = query.ray.tfar[i];
      hits.u[first + i] = query.hit.u[i];
      hits.v[first + i] = query.hit.v[i];
      hits.triangle[first + i] = query.hit.primID[i];
      const bool instanced = query.hit.instID[0][i] != RTC_INVALID_GEOMETRY_ID;
      hits.instance[first + i] = instanced ? query.hit.instID[0][i] : query.hit.geomID[i];
    }
  }
}

void occlude_rays(RTCScene scene, const RayLanes& rays, std::uint32_t count, std::uint8_t (&hidden)[kLanes]) {
  for (std::uint32_t first = 0; first < count; first += kPacket) {
    RTCRay8 query;
    load_rays(rays, first, query);
    occlude_packet(scene, Valid(count - first), query);
    for (std::uint32_t i = 0; i < kPacket; ++i) hidden[first + i] = query.tfar[i] < 0;
  }
}

}  // namespace photond
