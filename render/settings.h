// What a picture is made with. The picture depends on the scene, the camera and these alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "render/filter.h"
#include "scenegraph/camera.h"
#include "shade/sky.h"

namespace occam::render {

/// Layers beside beauty, as bits of Settings::aovs. Names: aov_name().
enum class Aov : std::uint16_t {
    Depth = 1,                ///< camera z; infinity where nothing is hit
    Normal = 2,               ///< shading normal, world axes, towards the eye
    NormalGeometric = 4,      ///< of the micropolygon
    Albedo = 8,               ///< base colour times coverage, and coverage: the mean over the pixel
    Uv = 16,                  ///< first set, as in the file of glTF's axes: v runs downwards
    Position = 32,            ///< world
    Id = 64,                  ///< a number for each node, from 1; 0 where nothing is hit
    Variance = 128,           ///< of the pixel's mean luminance, estimated from its samples
    NormalMean = 256,         ///< mean over the pixel of the normal with its normal map: with albedo, what a denoiser wants
    CryptomatteObject = 512,  ///< which nodes are seen and how much of each, by name: render/cryptomatte.h
    CryptomatteMaterial = 1024,  ///< the same of materials
    Occlusion = 2048             ///< what occlusion maps leave of ambient light, times coverage: the mean over the pixel
};
inline constexpr Aov kAllAovs[] = {Aov::Depth,
                                   Aov::Normal,
                                   Aov::NormalGeometric,
                                   Aov::Albedo,
                                   Aov::Uv,
                                   Aov::Position,
                                   Aov::Id,
                                   Aov::Variance,
                                   Aov::NormalMean,
                                   Aov::CryptomatteObject,
                                   Aov::CryptomatteMaterial,
                                   Aov::Occlusion};
std::string_view aov_name(Aov aov) noexcept;

/// Debug pictures instead of light.
enum class View : std::uint8_t {
    Beauty,
    Depth,   ///< near white, far black
    Normal,  ///< shading normal, -1 to 1 as 0 to 1
    Uv,      ///< fractional parts as red and green
    Face,    ///< a colour for each face of each node's cage
    Level,   ///< a colour for each pair of levels, darker towards the coarser one
    Blend,   ///< black where the finer level of the pair is seen, white where the coarser one is
    Grid     ///< a colour for each micropolygon
};
std::string_view view_name(View view) noexcept;
inline constexpr View kAllViews[] = {View::Depth, View::Normal, View::Uv, View::Face, View::Level, View::Blend, View::Grid};

/// Whose wanted edge length decides how finely a surface is seen.
enum class Lod : unsigned char {
    On,     ///< each ray's own, all along it
    Off,    ///< one level a cage instance, by the camera's footprint where it comes nearest
    Frozen  ///< of secondary rays: as wide all along as at their origin
};

/// Where materials are looked up.
enum class ShadeAt : std::uint8_t {
    Vertex,  ///< phase one at the vertices of grids, once, interpolated to hits; triangle meshes and alpha masks: at hits
    Hit
};

/// Which light is followed; see render/integrator.h.
enum class IntegratorKind : std::uint8_t { Direct, Ao, Path };
std::string_view integrator_name(IntegratorKind kind) noexcept;

struct Settings {
    int width = 1280, height = 720;  ///< of the whole frame, pixels
    /// Part of the frame that is made, each 0 to 1 from the top left.
    float crop_x0 = 0, crop_x1 = 1, crop_y0 = 0, crop_y1 = 1;

    int spp = 16;        ///< samples a pixel
    bool jitter = true;  ///< false: every sample goes through the middle of its pixel
    FilterKind filter = FilterKind::Box;
    float filter_radius = 0;  ///< half the filter's width, pixels; 0: what suits it
    /// Above 0: a tile of pixels is done before its `spp` samples once the estimated standard error of its pixels is below
    /// this share of their brightness (see PixelSums::relative_error).
    float error = 0;
    IntegratorKind integrator = IntegratorKind::Path;
    int bounces = 8;  ///< The most times that light is scattered on its way; for `direct`, mirrors one behind the other.
    /// Above 0, no single contribution of light that was scattered twice or more is brighter than this in any channel. The
    /// limit takes away rare bright pixels (fireflies) and with them some light, so references are made without it.
    float clamp = 0;
    float ao_distance = 0;              ///< how far `ao` looks, world length; 0: to infinity
    int light_samples = 1;              ///< of each light at each hit that the camera sees; of the sky in `ao`
    shade::Sky sky = shade::Sky::Auto;  ///< soft daylight, in place of a black environment
    float sky_strength = 1;             ///< its brightness times this
    float shading_rate = 1;             ///< wanted micropolygon edge, pixels
    Lod lod = Lod::On;
    ShadeAt shade_at = ShadeAt::Hit;
    std::optional<Camera> lod_camera{};  ///< whose pixels the footprints are; none: the picture's own
    std::uint64_t seed = 0;
    double deadline_s = 0;  ///< stop after so long with what is done; 0: none. The one setting that makes pictures differ
    unsigned aovs = 0;      ///< bits of Aov
    View view = View::Beauty;
    bool back_faces =
        true;             ///< false: rays pass the backs of single-sided surfaces (glTF 2.0, sec. 3.9.5), but those of glass
    bool strict = false;  ///< a texture that is missing, or made smaller to fit the memory, is an Error
    bool background = true;  ///< draw sky or environment behind the scene; false: transparent

    bool has(Aov aov) const noexcept { return (aovs & static_cast<unsigned>(aov)) != 0; }
};

/// What is at hand to make it with. Has no influence on the picture.
struct Resources {
    int threads = 0;  ///< 0: one for each processor
    /// For what is rebuilt each frame, all workers together; 0: a quarter of the machine. What a scene needs at least:
    /// Renderer::memory_floor().
    std::size_t memory_bytes = 0;
    int workers_a_tree = 1;  ///< 1: each worker builds its own; more: that many share one; 0: all do
    std::size_t texture_bytes = std::size_t(1) << 30;

    /// The zeros above replaced by what the machine has.
    Resources resolved() const;
};

/// The pixels of the frame that the crop names: first and one past the last; never empty.
struct PixelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    int width() const noexcept { return x1 - x0; }
    int height() const noexcept { return y1 - y0; }
    friend bool operator==(const PixelRect&, const PixelRect&) = default;
};
PixelRect crop_pixels(const Settings& settings) noexcept;

/// Throws Error naming the setting that is out of its range.
void check(const Settings& settings);
inline constexpr int kMaxSide = 65536;
inline constexpr int kMaxSamples = 65536;
inline constexpr int kMaxLightSamples = 1024;
inline constexpr int kMaxBounces = 128;
inline constexpr std::int64_t kMaxPixels = std::int64_t(1) << 28;

}  // namespace occam::render
