// The instances of run_packet() and run_single() that pictures need. Those of observed rays are in observe.cpp, so that the
// compiler's choices here do not depend on them.
#include "accel/run_rays.h"

namespace occam::accel {

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

}  // namespace occam::accel
