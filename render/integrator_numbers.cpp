// The random numbers of an integrator's surfaces.
#include <algorithm>

#include "render/integrator.h"

namespace occam::render {

Sequence Integrator::numbers(const Vertex& v, Use use, int slot) const noexcept
{
    return context_.sampler.sequence(v.sample.x, v.sample.y,
                                     Dimension::at(v.path.key, use, static_cast<std::uint32_t>(slot)));
}

// Uses that need more than one number of a sample at a hit have sequences of their own.
SurfaceNumbers Integrator::numbers_of(std::size_t i, const Vertex& v) noexcept
{
    constexpr std::size_t kBlock = SurfacesToDraw::kMost;
    if (i / kBlock != drawn_.number) {
        drawn_.number = i / kBlock;
        const std::size_t first = i / kBlock * kBlock, count = std::min(kBlock, paths_.size() - first);
        for (std::size_t k = 0; k < count; ++k) {
            const CameraSample& sample = samples_[paths_[first + k].sample];
            drawn_.surfaces.x[k] = sample.x;
            drawn_.surfaces.y[k] = sample.y;
            drawn_.surfaces.index[k] = static_cast<std::uint32_t>(sample.index);
            drawn_.surfaces.key[k] = paths_[first + k].key;
        }
        context_.sampler.draw(drawn_.surfaces, drawn_.numbers);
    }
    if (drawn_.surfaces.key[i % kBlock] == v.path.key) return drawn_.numbers[i % kBlock];
    // The ray has passed surfaces since the block was drawn.
    const std::uint32_t index = v.first_of(1);
    SurfaceNumbers drawn;
    for (int slot = 0; slot < SurfaceNumbers::kLightSlots; ++slot)
        if (is_drawn(slot)) drawn.light[slot] = numbers(v, Use::Light, slot).square(index);
    drawn.scatter = numbers(v, Use::Scatter).square(index);
    drawn.lobe = numbers(v, Use::Lobe).interval(index);
    return drawn;
}

// Returns the slots of Use::Light that are drawn for surfaces side by side: those of lights outside the tree, of meshes and
// of the environment, unless a light has several samples.
unsigned Integrator::light_slots_to_draw() const noexcept
{
    if (context_.settings.light_samples > 1) return 0;
    const int meshes = environment_slot() - 1;
    const auto placed = static_cast<unsigned>(
        std::min(context_.lights.lights_outside_tree(), std::size_t(kMaxLightsPerHit)));
    unsigned slots = (1u << placed) - 1;
    if (!context_.lights.meshes().is_empty()) slots |= 1u << meshes;
    if (context_.lights.environment().has_density()) slots |= 1u << environment_slot();
    return slots & ((1u << SurfaceNumbers::kLightSlots) - 1);
}

bool Integrator::is_drawn(int slot) const noexcept { return (drawn_.surfaces.light_slots >> slot & 1) != 0; }

int Integrator::environment_slot() const noexcept
{
    const int placed = std::min(static_cast<int>(context_.lights.lights_outside_tree()), kMaxLightsPerHit);
    return placed + (context_.lights.tree().is_empty() ? 0 : 1) + 1;
}

// Returns the point of the unit square for the only sample of a light.
Vec2f Integrator::light_square(const Vertex& v, int slot) const noexcept
{
    return is_drawn(slot) ? v.drawn.light[slot] : numbers(v, Use::Light, slot).square(v.first_of(1));
}

}  // namespace occam::render
