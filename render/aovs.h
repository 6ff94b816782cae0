// The layers that a picture can have beside beauty: one row for each.
//
// To add a layer, add its value to `Aov`, its row to kAovs and a case to PixelSums::write() (render/film.cpp). If it needs a
// value that samples do not have yet, add that to FirstSurface or to SampleResult (render/film.h); a sum of its own is kept
// between the rounds of a picture by PixelSums::visit_packed().
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <string_view>

namespace occam::render {

/// Layers beside beauty. kAovs says what each of them holds.
enum class Aov : std::uint8_t {
    Depth,
    Normal,
    NormalGeometric,
    Albedo,
    Uv,
    Position,
    Id,
    Variance,
    NormalMean,
    CryptomatteObject,
    CryptomatteMaterial,
    Occlusion,
    Motion
};

/// A set of layers.
class AovSet {
public:
    constexpr AovSet() noexcept = default;
    /// A number that is no layer stays one, which check(const Settings&) refuses.
    constexpr AovSet(Aov aov) noexcept : bits_(1u << std::min(static_cast<unsigned>(aov), 31u)) {}
    constexpr AovSet(std::initializer_list<Aov> aovs) noexcept
    {
        for (const Aov aov : aovs) *this |= aov;
    }

    constexpr bool has(Aov aov) const noexcept { return has_any(aov); }
    constexpr bool has_any(AovSet of) const noexcept { return (bits_ & of.bits_) != 0; }
    constexpr bool is_empty() const noexcept { return bits_ == 0; }
    constexpr AovSet& operator|=(AovSet other) noexcept
    {
        bits_ |= other.bits_;
        return *this;
    }
    friend constexpr AovSet operator|(AovSet a, AovSet b) noexcept { return a |= b; }
    friend constexpr bool operator==(AovSet, AovSet) noexcept = default;

private:
    std::uint32_t bits_ = 0;
};
constexpr AovSet operator|(Aov a, Aov b) noexcept { return AovSet(a) | AovSet(b); }

/// Describes a layer.
struct AovRow {
    Aov aov;
    std::string_view name;      ///< of the option --aov, of the layer in the file, and in statistics
    std::string_view channels;  ///< one letter for each channel
    bool full_float;            ///< written with 32 bits, whatever the other layers have
    float miss;                 ///< the value of a pixel that shows nothing
    bool is_first_surface;      ///< it shows the first surface of the sample nearest to the middle of the pixel
    std::string_view help;
};

inline constexpr AovRow kAovs[] = {
    {Aov::Depth, "depth", "Z", true, std::numeric_limits<float>::infinity(), true,
     "distance along the camera's axis; infinity where nothing is hit"},
    {Aov::Normal, "normal", "XYZ", false, 0, true, "shading normal in world axes, towards the eye"},
    {Aov::NormalGeometric, "normal_geometric", "XYZ", false, 0, true, "normal of the micropolygon, towards the eye"},
    {Aov::Albedo, "albedo", "RGBA", false, 0, false, "base colour times coverage, and coverage: the mean over the pixel"},
    {Aov::Uv, "uv", "UV", true, 0, true, "first set of texture coordinates, along the axes of glTF: v runs downwards"},
    {Aov::Position, "position", "XYZ", true, 0, true, "point in world space"},
    {Aov::Id, "id", "I", true, 0, true, "a number for each node, from 1; 0 where nothing is hit"},
    {Aov::Variance, "variance", "Y", true, 0, false,
     "variance of the pixel's mean luminance, estimated from its samples; infinity where these are too few to tell it"},
    {Aov::NormalMean, "normal_mean", "XYZ", false, 0, false,
     "mean over the pixel of the normal with its normal map; denoisers use it with albedo"},
    {Aov::CryptomatteObject, "cryptomatte_object", "RGBA", true, 0, false,
     "which nodes are seen and how much of each, by name (render/cryptomatte.h)"},
    {Aov::CryptomatteMaterial, "cryptomatte_material", "RGBA", true, 0, false, "the same for materials"},
    {Aov::Occlusion, "occlusion", "Y", false, 0, false,
     "share of ambient light that occlusion maps leave, times coverage: the mean over the pixel"},
    {Aov::Motion, "motion", "XY", true, 0, true, "pixels by which the surface moves to the right and down in a frame"},
};

inline constexpr AovSet kCryptomattes = Aov::CryptomatteObject | Aov::CryptomatteMaterial;
/// The layers that show the first surface of the sample nearest to the middle of the pixel.
inline constexpr AovSet kFirstSurfaceAovs = [] {
    AovSet set;
    for (const AovRow& row : kAovs)
        if (row.is_first_surface) set |= row.aov;
    return set;
}();

/// Returns the row of a layer. The rows stand in the order of the layers.
constexpr const AovRow& row_of(Aov aov) noexcept { return kAovs[static_cast<std::size_t>(aov)]; }

/// The most channels of a layer.
inline constexpr std::size_t kMostChannels = 4;

consteval bool are_rows_in_order()
{
    std::size_t n = 0;
    for (const AovRow& row : kAovs)
        if (static_cast<std::size_t>(row.aov) != n++ || row.channels.size() > kMostChannels) return false;
    return true;
}
static_assert(are_rows_in_order());

}  // namespace occam::render
