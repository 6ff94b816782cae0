// Sends packets of rays and single rays through the trees of all kinds, for queries of all kinds.
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

template Tracer::State::PacketResult Tracer::State::run_packet<InKdTree, 1>(std::span<const Ray>, const RayAxes&,
                                                                            std::size_t, PacketQuery<Nearest, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InKdTree, 2>(std::span<const Ray>, const RayAxes&,
                                                                            std::size_t, PacketQuery<Nearest, 2>&);
template bool Tracer::State::run_single<InKdTree>(const Ray&, const RayAxes&, std::size_t, SingleQuery<Nearest>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InKdTree, 1>(std::span<const Ray>, const RayAxes&,
                                                                            std::size_t, PacketQuery<NearestSome, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InKdTree, 2>(std::span<const Ray>, const RayAxes&,
                                                                            std::size_t, PacketQuery<NearestSome, 2>&);
template bool Tracer::State::run_single<InKdTree>(const Ray&, const RayAxes&, std::size_t, SingleQuery<NearestSome>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InKdTree, 1>(std::span<const Ray>, const RayAxes&,
                                                                            std::size_t, PacketQuery<AnyHit, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InKdTree, 2>(std::span<const Ray>, const RayAxes&,
                                                                            std::size_t, PacketQuery<AnyHit, 2>&);
template bool Tracer::State::run_single<InKdTree>(const Ray&, const RayAxes&, std::size_t, SingleQuery<AnyHit>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InBvh, 1>(std::span<const Ray>, const RayAxes&, std::size_t,
                                                                         PacketQuery<Nearest, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InBvh, 2>(std::span<const Ray>, const RayAxes&, std::size_t,
                                                                         PacketQuery<Nearest, 2>&);
template bool Tracer::State::run_single<InBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<Nearest>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InBvh, 1>(std::span<const Ray>, const RayAxes&, std::size_t,
                                                                         PacketQuery<NearestSome, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InBvh, 2>(std::span<const Ray>, const RayAxes&, std::size_t,
                                                                         PacketQuery<NearestSome, 2>&);
template bool Tracer::State::run_single<InBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<NearestSome>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InBvh, 1>(std::span<const Ray>, const RayAxes&, std::size_t,
                                                                         PacketQuery<AnyHit, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InBvh, 2>(std::span<const Ray>, const RayAxes&, std::size_t,
                                                                         PacketQuery<AnyHit, 2>&);
template bool Tracer::State::run_single<InBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<AnyHit>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InMovingBvh, 1>(std::span<const Ray>, const RayAxes&,
                                                                               std::size_t, PacketQuery<Nearest, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InMovingBvh, 2>(std::span<const Ray>, const RayAxes&,
                                                                               std::size_t, PacketQuery<Nearest, 2>&);
template bool Tracer::State::run_single<InMovingBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<Nearest>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InMovingBvh, 1>(std::span<const Ray>, const RayAxes&,
                                                                               std::size_t, PacketQuery<NearestSome, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InMovingBvh, 2>(std::span<const Ray>, const RayAxes&,
                                                                               std::size_t, PacketQuery<NearestSome, 2>&);
template bool Tracer::State::run_single<InMovingBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<NearestSome>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InMovingBvh, 1>(std::span<const Ray>, const RayAxes&,
                                                                               std::size_t, PacketQuery<AnyHit, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InMovingBvh, 2>(std::span<const Ray>, const RayAxes&,
                                                                               std::size_t, PacketQuery<AnyHit, 2>&);
template bool Tracer::State::run_single<InMovingBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<AnyHit>&);
template bool Tracer::State::run_single<InKdTree>(const Ray&, const RayAxes&, std::size_t, SingleQuery<ObservedNearest>&);
template bool Tracer::State::run_single<InBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<ObservedNearest>&);
template bool Tracer::State::run_single<InMovingBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<ObservedNearest>&);

}  // namespace occam::accel
