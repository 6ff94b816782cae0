// Lets the rays of a frame pass the holes that alpha masks cut into surfaces.
#pragma once

#include "lod/hit_filter.h"
#include "shade/surface.h"

namespace occam::render {

class MaskFilter final : public lod::HitFilter {
public:
    explicit MaskFilter(const TextureStore& textures) noexcept : textures_(textures) {}

    bool is_hole(const Material& material, const lod::VertexToShade& at, Vec4f color) const noexcept override
    {
        return shade::is_hole(material, at, color, textures_);
    }

private:
    const TextureStore& textures_;
};

}  // namespace occam::render
