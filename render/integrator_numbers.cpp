// The random numbers of an integrator's surfaces.
#include <algorithm>

#include "render/integrator.h"

namespace occam::render {

Sequence Integrator::numbers(const Vertex& v, Use use, int slot) const noexcept
{
    return context_.sampler.sequence(v.sample.x, v.sample.y,
                                     Dimension::at(v.path.key, use, static_cast<std::uint32_t>(slot)));
}

// Draws the numbers of which each waiting surface needs exactly one.
void Integrator::draw_for_waiting(int count)
{
    SurfacesToDraw& of = surfaces_to_draw_;
    for (int k = 0; k < kLanes; ++k) {
        const Vertex& v = waiting(std::min(k, count - 1));
        of.x[k] = v.sample.x;
        of.y[k] = v.sample.y;
        of.index[k] = static_cast<std::uint32_t>(v.sample.index);
        of.key[k] = v.path.key;
    }
    context_.sampler.draw(of, drawn_);
}

// Returns the slots of Use::Light that are drawn for surfaces side by side: those of lights outside the tree, of meshes and
// of the environment.
std::uint32_t Integrator::light_slots_to_draw() const noexcept
{
    static_assert(SurfacesToDraw::kLightSlots == kMaxLightsPerHit + 2);
    std::uint32_t slots = 0;
    const auto& lights = context_.lights.lights();
    if (!waits_) return slots;
    for (std::size_t slot = 0; slot < lights.size(); ++slot) slots |= lights[slot].has_extent() ? 1u << slot : 0u;
    if (!context_.lights.meshes().is_empty()) slots |= 1u << (environment_slot() - 1);
    if (context_.lights.environment().has_density()) slots |= 1u << environment_slot();
    return slots;
}

int Integrator::environment_slot() const noexcept
{
    const int placed = std::min(static_cast<int>(context_.lights.lights_outside_tree()), kMaxLightsPerHit);
    return placed + (context_.lights.tree().is_empty() ? 0 : 1) + 1;
}

// Returns the point of the unit square for the only sample of a light.
Vec2f Integrator::light_square(const Vertex& v, int slot) const noexcept
{
    return numbers(v, Use::Light, slot).square(v.first_of(1));
}

}  // namespace occam::render
