// Sends packets of rays and single rays through the trees of all kinds, for queries of all kinds: the templates that
// tracer_state.h declares.
//
// Their instances are in run_instances.cpp; those for a ray that is observed are in observe.cpp.
#pragma once

#include "accel/lone_ray.h"
#include "accel/packet_rays.h"
#include "accel/walk.h"

namespace occam::accel {

template <class Way, int kParts, class Found>
Tracer::State::PacketResult Tracer::State::run_packet(std::span<const Ray> rays, const RayAxes& axes,
                                                      std::size_t memory_bytes, PacketQuery<Found, kParts>& query)
{
    PacketRays<Found, kParts> party(rays, axes, frame, packet_levels<kParts>(), query);
    return Walk<Way, PacketRays<Found, kParts>>(*this, party, memory_bytes).run();
}

template <class Way, class Found>
bool Tracer::State::run_single(const Ray& ray, const RayAxes& axes, std::size_t memory_bytes, SingleQuery<Found>& query)
{
    LoneRay<Found> party(ray, axes, frame, single_levels, query);
    return Walk<Way, LoneRay<Found>>(*this, party, memory_bytes).run() == PacketResult::Done;
}

}  // namespace occam::accel
