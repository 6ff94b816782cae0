// Light from infinitely far, in every direction: a constant, an equirectangular image, or the default sky of a scene
// without light.
//
// Memory   tables of 512 x 256 luminances and indices for an image that is not even, 1 MB. Borrows the texture store.
// Time     about 6 ms for an image, unless its table is kept.
// Threads  const after construction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/maths.h"
#include "io/texture/texture_store.h"
#include "scenegraph/light.h"

namespace occam::shade {

class Environment {
public:
    struct Table;
    /// The table of the last frame's image; null if there was none. It depends on the image alone.
    using Kept = std::shared_ptr<const Table>;

    Environment() = default;  ///< no environment: black
    /// The textures must be prepared.
    /// kept   null, or a table that is used if it is of the same image, and else becomes that of this one
    Environment(const occam::Environment& description, const TextureStore& textures, Kept* kept = nullptr);
    /// Returns daylight for a scene that brings no light of its own: a soft gradient about +y.
    static Environment sky(float strength = 1);

    bool is_black() const noexcept { return kind_ == Kind::None; }
    Vec3f radiance(Vec3f direction) const noexcept;

    /// Returns true for an image that is also sampled by its brightness. For an image that is about equally bright
    /// everywhere, and for all that is no image, the lobes of the surface suffice.
    bool has_density() const noexcept { return !cells_.empty(); }
    /// Light from one direction, and the density per solid angle with which draw() finds it; 0 if the environment has no
    /// density.
    struct Light {
        Vec3f direction{0};
        Vec3f radiance{0};
        float density = 0;
    };
    /// Draws a direction by the brightness of the image, which there has to be.
    Light draw(Vec2f square) const noexcept;
    Light look_up(Vec3f direction) const noexcept;
    /// Does the same for several points or directions, at most kAtOnce, with the same bits. They wait together for tables
    /// and texels, which lie far apart. The image has to have a density.
    static constexpr std::size_t kAtOnce = 8;
    void draw(std::span<const Vec2f> squares, std::span<Light> to) const noexcept;
    void look_up(std::span<const Vec3f> directions, std::span<Light> to) const noexcept;

private:
    enum class Kind : unsigned char { None, Constant, Image, Sky };
    /// An entry of a table of running sums, of which the last one is 1. What a draw needs of both lies side by side, since
    /// it waits for memory.
    struct Sum {
        float upto;
        /// Where to begin looking for a number (Chen and Asau 1974): entry i of n has the index of the first sum above i /
        /// n.
        std::uint16_t guide;
    };
    struct Interval;
    struct Spread;

    Vec3f in_axes_of_image(Vec3f direction) const noexcept;
    Vec2f uv_of(Vec3f direction) const noexcept;
    static Vec2f uv_at(const Interval& row, const Interval& column) noexcept;
    /// Returns the direction at these angles about the image's pole and from it.
    Vec3f direction_of(maths::SinCos around, maths::SinCos up) const noexcept;
    Light light_at(Vec3f direction, Vec2f uv) const noexcept;
    Vec3f texel(Vec2f uv) const noexcept;
    float density_at(int row, int column, float ring) const noexcept;
    void take(Kept table) noexcept;
    Kept tabulate() const;
    /// Returns the mean luminance of a cell as it is interpolated.
    float mean_of_cell(int row, int column) const noexcept;
    /// Corrects the cells beside far brighter ones.
    /// mean   of the luminances of all cells
    void add_light_from_beside(std::vector<Sum>& cells, double mean) const;
    static Interval find_interval(std::span<const Sum> sums, float u) noexcept;
    /// Returns the entry whose guide says where to begin looking for u.
    static const Sum& guide_of(std::span<const Sum> sums, float u) noexcept;
    std::span<const Sum> cells_of(int row) const noexcept;
    static void fill_guides(std::span<Sum> sums) noexcept;
    static float share_of(std::span<const Sum> sums, int index) noexcept;
    static float accumulate(std::span<Sum> weights) noexcept;

    Kind kind_ = Kind::None;
    Vec3f scale_{0};
    TextureUse image_;
    float rotation_sin_ = 0, rotation_cos_ = 1;
    const TextureStore* textures_ = nullptr;
    Kept table_;
    std::span<const Sum> rows_;   ///< over rows; empty without a density
    std::span<const Sum> cells_;  ///< within each row; the same
};

/// What is known of an image.
struct Environment::Table {
    std::uint64_t image = 0;  ///< TextureStore::identity()
    float texel_width = 0;    ///< changes if the image is halved
    std::vector<Sum> rows, cells;
    bool is_one_color = false;
    Vec3f darkest{0};  ///< in each channel
};

}  // namespace occam::shade
