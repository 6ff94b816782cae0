// Numbers out of glTF accessors: every layout the format knows, every bound checked before anything is allocated.
#pragma once

#include <tiny_gltf.h>

#include <span>

#include "base/vec.h"
#include "io/import/report.h"

namespace occam::import {

/// Reads accessors of one file. Sparse, interleaved, normalised and quantised ones alike (glTF 2.0, sec. 3.6.2).
/// Throws Error naming the accessor if it does not fit its buffer, or has another type than wanted.
class AccessorReader {
public:
    AccessorReader(const tinygltf::Model& model, const Report& report);

    std::size_t count(int accessor) const { return at(accessor).count; }
    int components(int accessor) const;
    const tinygltf::Accessor& at(int accessor) const;

    /// `width` floats an element; integers are scaled to [0, 1] or [-1, 1] if the accessor is normalised.
    std::vector<float> floats(int accessor, int width);
    std::vector<Vec2f> vec2(int accessor);
    std::vector<Vec3f> vec3(int accessor);
    std::vector<Vec4f> vec4(int accessor);
    /// Unsigned integers, one an element.
    std::vector<std::uint32_t> indices(int accessor);
    /// Unsigned integers, four an element; of 8 or 16 bits.
    std::vector<glm::u16vec4> joints(int accessor);
    /// Numbers of all accessors that are not finite, or not within the declared bounds, are warnings.
    void check_values(Report& report);
    /// The bytes of a buffer view; throws if they are not in its buffer.
    std::span<const unsigned char> view(int buffer_view, const std::string& where) const;

private:
    struct Layout;
    Layout locate(int accessor, int width);
    template <class Out>
    void fill(const Layout& layout, int accessor, int width, bool normalized, Out* out) const;
    template <class Visit>
    void for_each_part(const Layout& layout, int accessor, Visit&& visit) const;
    void charge(std::size_t bytes, int accessor);
    [[noreturn]] void refuse(int accessor, const std::string& what) const;

    const tinygltf::Model& model_;
    const Report& report_;
    std::size_t budget_bytes_;  ///< many accessors may show the same bytes: what they expand to is bounded
};

}  // namespace occam::import
