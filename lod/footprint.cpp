#include "lod/footprint.h"

namespace occam::lod {

int choose_level(const LevelSettings& settings, const Box3d& bounds) noexcept
{
    constexpr int kFinest = -60, kCoarsest = 60;
    if (bounds.is_empty()) return kCoarsest;
    const Vec3d nearest = glm::clamp(settings.eye, bounds.lo, bounds.hi);
    const double distance = std::max(glm::distance(settings.eye, nearest), bounds.radius() / 16);
    const float wanted = settings.shading_rate * settings.pixel.at(static_cast<float>(distance));
    if (!(wanted > 0)) return kFinest;
    return std::clamp(std::ilogb(wanted), kFinest, kCoarsest);
}

}  // namespace occam::lod
