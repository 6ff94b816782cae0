#include "verify/silhouettes.h"

#include <array>
#include <cmath>
#include <numbers>

namespace occam {
namespace {

constexpr std::size_t kAround = 16;

}  // namespace

Silhouettes::Silhouettes(const Scene& scene, lod::TopologyCache& topologies, const lod::LevelSettings& levels,
                         const TextureStore* textures, float radius)
    : frame_(scene, topologies, levels, {.textures = textures}), tracer_(frame_, std::size_t(1) << 30), radius_(radius)
{
}

bool Silhouettes::explain(const accel::Ray& ray)
{
    // A vertex, the middle of two others, a blend and a ray's origin are each off by half an ulp of a coordinate at most,
    // so an outline lies within 2^-22 of the radius of where it should be. Parallel rays pass at four times that distance
    // on all sides. An outline that crosses their circle is met by no two neighbours, which are 0.39 of the circle's
    // radius apart, while a front side of any width is.
    const double distance = 0x1p-20 * double(radius_);
    const Vec3d along(ray.direction);
    const Vec3d aside = std::abs(along.x) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
    const Vec3d x = glm::normalize(glm::cross(along, aside)), y = glm::normalize(glm::cross(along, x));
    std::array<accel::Ray, kAround> rays;
    std::array<accel::SurfaceHit, kAround> hits;
    for (std::size_t k = 0; k < kAround; ++k) {
        const double angle = 2 * std::numbers::pi * double(k) / kAround;
        rays[k] = ray;
        rays[k].origin += distance * (std::cos(angle) * x + std::sin(angle) * y);
    }
    tracer_.closest(rays, hits);
    const auto is_back = [&](std::size_t k) { return hits[k % kAround].is_hit() && hits[k % kAround].back_side; };
    for (std::size_t k = 0; k < kAround; ++k)
        if (!is_back(k) && !is_back(k + 1)) return false;
    return true;
}

}  // namespace occam
