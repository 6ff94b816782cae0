// Lets the rays of a frame pass the holes that alpha masks cut into surfaces.
#pragma once

#include "lod/hit_filter.h"
#include "render/shade_point.h"
#include "shade/surface.h"

namespace occam::render {

class MaskFilter final : public lod::HitFilter {
public:
    /// texture_width   of a hit's texture filter, in footprints (render/shade_point.h)
    MaskFilter(const TextureStore& textures, float texture_width) noexcept
        : textures_(textures), texture_width_(texture_width)
    {
    }

    bool is_hole(const Material& material, const lod::VertexToShade& at, Vec4f color) const noexcept override
    {
        lod::VertexToShade narrow = at;
        for (float& width : narrow.uv_width) width *= texture_width_;
        return shade::is_hole(material, narrow, color, textures_);
    }

private:
    const TextureStore& textures_;
    const float texture_width_;
};

}  // namespace occam::render
