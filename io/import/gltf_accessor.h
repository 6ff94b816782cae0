// Reading of glTF accessors: every layout that the format allows, with every bound checked before anything is allocated.
#pragma once

#include <tiny_gltf.h>

#include <optional>
#include <span>
#include <vector>

#include "base/vec.h"
#include "io/import/copy_budget.h"
#include "io/import/report.h"

namespace occam::import {

/// The numbers of the elements of an accessor that are wanted. They rise, and are below its count. Without a list all
/// elements are wanted. The time and memory that a list takes do not depend on the count, since many primitives may each use
/// a few elements of one accessor.
using ChosenElements = std::optional<std::vector<std::uint32_t>>;

/// Reads the accessors of one file, be they sparse, interleaved, normalised or quantised (glTF 2.0, sec. 3.6.2). Throws
/// Error naming the accessor if it does not fit its buffer, or has another type than the caller asks for.
class AccessorReader {
public:
    AccessorReader(const tinygltf::Model& model, const Report& report);

    std::size_t count(int accessor) const { return at(accessor).count; }
    int components(int accessor) const;
    const tinygltf::Accessor& at(int accessor) const;

    /// Returns `width` floats for each element; integers are scaled to [0, 1] or [-1, 1] if the accessor is normalised.
    /// Components that the accessor does not have are 0.
    std::vector<float> floats(int accessor, int width);
    std::vector<Vec2f> vec2(int accessor, const ChosenElements& chosen = {});
    std::vector<Vec3f> vec3(int accessor, const ChosenElements& chosen = {});
    std::vector<Vec4f> vec4(int accessor, const ChosenElements& chosen = {});
    /// Returns unsigned integers, one for each element.
    std::vector<std::uint32_t> indices(int accessor);
    /// Returns unsigned integers of 8 or 16 bits, four for each element.
    std::vector<glm::u16vec4> joints(int accessor, const ChosenElements& chosen = {});
    /// Returns 0, 1, 2 and so on, one for each element.
    std::vector<std::uint32_t> numbers(int accessor);
    /// Checks the numbers of all accessors; those that are not finite, or not within the declared bounds, become warnings.
    void check_values(Report& report);
    /// Returns the bytes of a buffer view; throws Error if they are not in its buffer.
    std::span<const unsigned char> view(int buffer_view, const std::string& where) const;

    /// Returns the limit to what elements other than accessors may have many copies of.
    CopyBudget& copies() noexcept { return copies_; }

private:
    struct Layout;
    Layout locate(int accessor, int width) const;
    template <class Value, class Out>
    std::vector<Value> read(int accessor, int width, const ChosenElements& chosen);
    template <class Out>
    void fill(const Layout& layout, int accessor, int width, Out* out, const ChosenElements& chosen, bool normalized);
    std::vector<std::uint32_t> sparse_places(int accessor, Layout& value);
    template <class Visit>
    void for_each_part(const Layout& layout, int accessor, Visit&& visit);
    std::size_t most_bytes() const;
    void charge(std::size_t bytes, int accessor);
    [[noreturn]] void refuse(int accessor, const std::string& what) const;

    const tinygltf::Model& model_;
    const Report& report_;
    std::size_t expansion_bytes_;  ///< bounds what accessors expand to, since many of them may show the same bytes
    CopyBudget copies_;
};

}  // namespace occam::import
