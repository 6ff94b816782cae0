// Says where the rays of a frame pass surfaces: through the holes that alpha masks cut into them, and from behind where the
// frame hides the backs of single-sided ones.
#pragma once

#include "lod/hit_filter.h"
#include "scenegraph/contents.h"
#include "shade/surface.h"

namespace occam::render {

class HoleFilter final : public lod::HitFilter {
public:
    /// hides_backs   the opposite of Settings::back_faces
    explicit HoleFilter(const TextureStore& textures, bool hides_backs = false) noexcept
        : textures_(textures), hides_backs_(hides_backs)
    {
    }

    /// Returns what a frame needs that shows these contents: this filter, or null.
    const lod::HitFilter* if_needed(const Contents& contents) const noexcept
    {
        return hides_backs_ || contents.has(Contents::Masked) ? this : nullptr;
    }
    bool is_hole(const Material& material, const lod::VertexToShade& at, Vec4f color) const noexcept override
    {
        return shade::is_hole(material, at, color, textures_);
    }
    bool hides_back(const Material& material) const noexcept override
    {
        return hides_backs_ && shade::is_single_sided(material);
    }

private:
    const TextureStore& textures_;
    const bool hides_backs_;
};

}  // namespace occam::render
