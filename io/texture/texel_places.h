// Where the texels about a point of an image lie, and their mean: the same for images in memory and for those on disk.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/simd.h"
#include "base/vec.h"
#include "scenegraph/material.h"

namespace occam {

// Maps a coordinate into one period of the wrap mode, in which an index fits an int.
inline float fold(float s, TextureUse::Wrap wrap) noexcept
{
    if (wrap == TextureUse::Wrap::Clamp) return std::clamp(s, 0.0f, 1.0f);
    return wrap == TextureUse::Wrap::Mirror ? s - 2 * std::floor(s * 0.5f) : s - std::floor(s);
}

// Wraps an index that is at most one texel outside of the period.
inline int wrapped(int i, int size, TextureUse::Wrap wrap) noexcept
{
    switch (wrap) {
        case TextureUse::Wrap::Clamp:
            return std::clamp(i, 0, size - 1);
        case TextureUse::Wrap::Repeat:
            return i < 0 ? i + size : i >= size ? i - size : i;
        case TextureUse::Wrap::Mirror:
            break;
    }
    if (i < 0) i = -1 - i;
    if (i >= 2 * size) i -= 2 * size;
    return i >= size ? 2 * size - 1 - i : i;
}

/// Holds the columns and rows of the four texels about a point, and their weights. For the nearest texel it is the first of
/// either.
struct TexelPlaces {
    int x[2], y[2];
    float fx = 0, fy = 0;

    /// width, height   of the level
    /// st              is finite; (0, 0) is the top left corner
    TexelPlaces(int width, int height, Vec2f st, TextureUse::Wrap wrap_s, TextureUse::Wrap wrap_t, bool nearest) noexcept
    {
        // Texel centres lie at halves.
        const float at_x = fold(st.x, wrap_s) * static_cast<float>(width) - 0.5f,
                    at_y = fold(st.y, wrap_t) * static_cast<float>(height) - 0.5f;
        if (nearest) {
            x[0] = x[1] = wrapped(static_cast<int>(std::floor(at_x + 0.5f)), width, wrap_s);
            y[0] = y[1] = wrapped(static_cast<int>(std::floor(at_y + 0.5f)), height, wrap_t);
            return;
        }
        const float x_floor = std::floor(at_x), y_floor = std::floor(at_y);
        fx = at_x - x_floor, fy = at_y - y_floor;
        x[0] = static_cast<int>(x_floor), x[1] = x[0] + 1;
        y[0] = static_cast<int>(y_floor), y[1] = y[0] + 1;
        if (x[0] < 0 || x[1] >= width)
            for (int& i : x) i = wrapped(i, width, wrap_s);
        if (y[0] < 0 || y[1] >= height)
            for (int& i : y) i = wrapped(i, height, wrap_t);
    }
};

/// Returns the bilinear mean of the four texels.
/// halves_at   returns the four half floats of the texel in column i and row j of the places
template <class HalvesAt>
Vec4f blended(const TexelPlaces& at, HalvesAt&& halves_at) noexcept
{
    const auto texel_at = [&](int i, int j) { return vfloat4::from_halves(halves_at(i, j)); };
    const vfloat4 top = texel_at(0, 0) * (1 - at.fx) + texel_at(1, 0) * at.fx;
    const vfloat4 bottom = texel_at(0, 1) * (1 - at.fx) + texel_at(1, 1) * at.fx;
    Vec4f mean;
    (top * (1 - at.fy) + bottom * at.fy).store(&mean.x);
    return mean;
}

}  // namespace occam
