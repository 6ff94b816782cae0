// A scene, its frames, and rays towards it, for tests of tracers.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>
#include <span>
#include <thread>
#include <tuple>
#include <vector>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "tests/support/shape_builders.h"

namespace occam::test {

constexpr std::size_t kPlenty = std::size_t(1) << 30;

inline std::vector<accel::Ray> rays_towards(Vec3d eye, const Box3d& bounds, int count, std::uint64_t seed)
{
    std::mt19937_64 random(seed);
    const auto uniform = [&] { return double(random() >> 11) * 0x1p-53; };
    std::vector<accel::Ray> rays(count);
    for (accel::Ray& ray : rays) {
        ray.origin = eye;
        ray.direction = Vec3f(glm::normalize(bounds.lo + bounds.extent() * Vec3d(uniform(), uniform(), uniform()) - eye));
    }
    return rays;
}

inline bool same(const accel::SurfaceHit& a, const accel::SurfaceHit& b)
{
    if (std::bit_cast<std::uint32_t>(a.t) != std::bit_cast<std::uint32_t>(b.t)) return false;
    const auto all = [](const accel::SurfaceHit& h) {
        return std::tuple(h.self_distance, h.uv_width[0], h.uv_width[1], h.normal_geometric, h.curvature, h.normal_shading,
                          h.tangent_sign, h.tangent, h.blend, h.uv[0], h.uv[1], h.position, h.u_gradient, h.v_gradient,
                          h.v_axis, h.color, h.material, h.node, h.face, h.back_side, h.side, h.level, h.micropolygon,
                          h.to_start, h.start_normal, h.start_level);
    };
    return !a.is_hit() || all(a) == all(b);
}

struct Stage {
    Scene scene;
    lod::TopologyCache topologies;
    accel::Frame frame(int level, lod::LevelMode mode = lod::LevelMode::PerRay, accel::TreeKind tree = accel::TreeKind::Auto)
    {
        scene.refit();
        return accel::Frame(scene, topologies, {.eye = Vec3d(0), .pixel = {std::ldexp(1.0f, level), 0}, .mode = mode},
                            {.tree = tree});
    }
};

/// Asks about rays in batches from three threads that share a tree, by answers.ask(tracer, rays, first, count).
template <class Answers>
void ask_in_threads(accel::SharedTree& tree, std::span<const accel::Ray> rays, std::size_t batch, Answers& answers)
{
    constexpr std::size_t kThreads = 3;
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < kThreads; ++t)
        threads.emplace_back([&, t] {
            accel::Tracer tracer(tree);
            for (std::size_t at = t * batch; at < rays.size(); at += kThreads * batch)
                answers.ask(tracer, rays, at, std::min(batch, rays.size() - at));
        });
    for (std::thread& thread : threads) thread.join();
}

}  // namespace occam::test
