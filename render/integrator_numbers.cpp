// The random numbers of an integrator's surfaces.
#include <algorithm>

#include "render/integrator.h"

namespace occam::render {

using Use = Dimension::Use;

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
        const int slot = environment_slot();
        if (context_.lights.environment().has_density() && slot < drawn_.surfaces.light_slots) {
            Vec2f squares[kBlock];
            for (std::size_t k = 0; k < count; ++k) squares[k] = drawn_.numbers[k].light[slot];
            context_.lights.environment().prefetch(std::span(squares, count));
        }
    }
    if (drawn_.surfaces.key[i % kBlock] == v.path.key) return drawn_.numbers[i % kBlock];
    // The ray has passed surfaces since the block was drawn.
    const std::uint32_t index = v.first_of(1);
    SurfaceNumbers drawn;
    for (int slot = 0; slot < drawn_.surfaces.light_slots; ++slot)
        drawn.light[slot] = numbers(v, Use::Light, slot).square(index);
    drawn.scatter = numbers(v, Use::Scatter).square(index);
    drawn.lobe = numbers(v, Use::Lobe).interval(index);
    drawn.survival = numbers(v, Use::Survival).interval(index);
    return drawn;
}

// Returns the number of slots of Use::Light that are drawn for a surface beside each other: those of lights outside the
// tree, of meshes and of the environment, unless a light has several samples.
int Integrator::light_slots_to_draw() const noexcept
{
    if (context_.settings.light_samples > 1) return 1;
    const bool has_environment = context_.lights.environment().has_density();
    const bool has_meshes = !context_.lights.meshes().is_empty();
    const int slots = environment_slot() + (has_environment ? 1 : has_meshes ? 0 : -1);
    return std::clamp(slots, 1, SurfaceNumbers::kLightSlots);
}

int Integrator::environment_slot() const noexcept
{
    const int placed = std::min(static_cast<int>(context_.lights.lights_outside_tree()), kMaxLightsPerHit);
    return placed + (context_.lights.tree().is_empty() ? 0 : 1) + 1;
}

// Returns the point of the unit square for the only sample of a light.
Vec2f Integrator::light_square(const Vertex& v, int slot) const noexcept
{
    return slot < drawn_.surfaces.light_slots ? v.drawn.light[slot] : numbers(v, Use::Light, slot).square(v.first_of(1));
}

}  // namespace occam::render
