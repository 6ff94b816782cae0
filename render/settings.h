// The settings of a picture. The picture depends on the scene, the camera and these settings alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "accel/tree_kind.h"
#include "render/aovs.h"
#include "render/filter.h"
#include "scenegraph/camera.h"
#include "shade/sky.h"

namespace occam::render {

/// Names the debug pictures that are shown instead of light; kViews says what each shows.
enum class View : std::uint8_t { Beauty, Depth, Normal, Uv, Face, Level, Blend, Grid, KdSteps, Tests, Reuse, Time };
struct ViewRow {
    View view;
    std::string_view name;
    std::string_view help;
    bool is_cost = false;  ///< shows what camera rays cost, those that hit nothing, too
};
inline constexpr ViewRow kViews[] = {
    {View::Depth, "depth", "near white, far black"},
    {View::Normal, "normal", "the shading normal, -1 to 1 as 0 to 1"},
    {View::Uv, "uv", "fractional parts of the texture coordinates as red and green"},
    {View::Face, "face", "a colour for each face of each node's cage"},
    {View::Level, "level", "a colour for each pair of levels, darker towards the coarser one"},
    {View::Blend, "blend", "black where the finer level of the pair is seen, white where the coarser one is"},
    {View::Grid, "grid", "a colour for each micropolygon"},
    {View::KdSteps, "kd_steps",
     "nodes of the tree that the camera ray enters: black 0, red 9, yellow 101, white 1023 or more", true},
    {View::Tests, "tests",
     "triangles that the camera ray is tested against: black 0, red 15, yellow 255, white 4095 or more", true},
    {View::Reuse, "reuse",
     "white where the grids that the camera ray meets existed before, black where it builds them; blue: none", true},
    {View::Time, "time", "time that the camera ray takes: black 0, red 9, yellow 101, white 1023 microseconds or more",
     true},
};
/// Returns whether a view shows what camera rays cost. Such pictures differ from run to run: what a ray costs depends on
/// what other rays have built before.
bool shows_cost(View view) noexcept;

/// Decides whose target edge length sets how finely a surface is seen.
enum class Lod : unsigned char {
    On,     ///< that of each ray, all along it
    Off,    ///< one level per cage instance, by the camera's footprint where the instance is nearest
    Frozen  ///< that of each ray, but secondary rays keep the width that they have at their origin
};

/// Decides where materials are looked up.
enum class ShadeAt : std::uint8_t {
    Vertex,  ///< once at the vertices of grids, and interpolated to hits; for triangle meshes and alpha masks at hits
    Hit
};

/// Names the light transport that is computed; see render/integrator.h.
enum class IntegratorKind : std::uint8_t { Direct, Ao, Path };

/// A setting of one value has a row in render/setting_rows.h.
struct Settings {
    int width = 1280, height = 720;  ///< size of the whole frame in pixels
    /// The part of the frame that is rendered, each value from 0 to 1 from the top left.
    float crop_x0 = 0, crop_x1 = 1, crop_y0 = 0, crop_y1 = 1;

    int spp = 16;        ///< samples per pixel
    bool jitter = true;  ///< false: every sample goes through the middle of its pixel
    FilterKind filter = FilterKind::Box;
    float filter_radius = 0;  ///< half the width of the filter in pixels; 0: the usual one
    /// If this is above 0, a pixel ends before its `spp` samples once the estimated standard error of the pixels around it
    /// is below this share of their brightness (see render/pixel_errors.h).
    float error = 0;
    /// The number of samples at which errors are estimated for the first time; then it is doubled.
    int min_spp = 16;
    IntegratorKind integrator = IntegratorKind::Path;
    int bounces = 8;  ///< the largest number of scattering events of light; for `direct`, of mirrors one behind the other
    /// If this is above 0, no single contribution of light that was scattered twice or more exceeds it in any channel. The
    /// limit takes away rare bright pixels (fireflies) and with them some light, so references are made without it. What
    /// is limited is the light that is left behind all surfaces and bodies that it passes straight on; a ray that passes
    /// them by chance may bring as much as all the rays for which it stands.
    float clamp = 0;
    /// The limit above is for the picture as it is shown with automatic exposure (render/display.h), which a sketch at
    /// the beginning of the frame measures (render/exposure_sketch.h): it is divided by two for each stop. It does not
    /// depend on the crop. The time of the sketch is not part of `deadline_s`; its rays and what they build are in the
    /// statistics.
    bool clamp_as_shown = false;
    float ao_distance = 0;              ///< the distance up to which `ao` looks, in world length; 0: to infinity
    int light_samples = 1;              ///< per light at each hit that the camera sees; for `ao`, samples of the sky
    shade::Sky sky = shade::Sky::Auto;  ///< soft daylight, in place of a black environment
    float sky_strength = 1;             ///< factor of its brightness
    /// Whether a scene without placed lights and environment gets the default light, unless `sky` is off. None: it does if
    /// its emissive surfaces do not light what the camera sees. A sequence decides once.
    std::optional<bool> default_light{};
    float shading_rate = 1;  ///< target edge length of micropolygons, in pixels
    Lod lod = Lod::On;
    ShadeAt shade_at = ShadeAt::Hit;
    /// When the shutter is open. The scene's motion is what Scene::record_shutter() recorded, whatever is said here; this
    /// tells how many frames that takes, for Aov::Motion.
    Shutter shutter{};
    std::optional<Camera> lod_camera{};  ///< the camera whose pixels the footprints are; none: the picture's own
    std::uint64_t seed = 0;
    /// Stop after so long with what is done; 0: none. With a deadline pictures may differ from run to run, as do the views
    /// that show costs.
    double deadline_s = 0;
    /// The frame is made in rounds of 1, 1, 2, 4, 8, ... samples a pixel, so that a frame that stops early is a picture of
    /// few samples, and can go on later. Costs 64 to 200 bytes a pixel, and up to 1 KB more for each Cryptomatte layer,
    /// beyond Resources::memory_bytes (see render/frame_sums.h); a frame for which the machine has too little memory is
    /// refused. A deadline implies it.
    bool progressive = false;
    AovSet aovs{};
    View view = View::Beauty;
    /// If false, rays pass the backs of single-sided surfaces (glTF 2.0, sec. 3.9.5), but not those of glass.
    bool back_faces = true;
    /// A texture that is missing, or made smaller to fit the memory, is an Error; so is what is repaired in an OnDemandCage.
    bool strict = false;
    bool background = true;  ///< draw sky or environment behind the scene; false: transparent

    bool has(Aov aov) const noexcept { return aovs.has(aov); }
};

/// The resources for rendering. They have no influence on the picture, except for what `texture_bytes` says.
struct Resources {
    /// 0: one for each processor that the process may use; those that the system refuses are done without.
    int threads = 0;
    /// The memory for what is rebuilt in each frame, all workers together; 0 means a quarter of the machine's, or of what a
    /// container leaves of it, but no more than 3 GB, or 512 MB for each thread if that is more.
    /// Renderer::memory_floor() returns the least with which a frame is begun.
    std::size_t memory_bytes = 0;
    int workers_a_tree = 1;  ///< 1: each worker builds its own tree; more: that many share one; 0: all share one
    std::size_t texture_bytes = std::size_t(1) << 30;  ///< textures that do not fit are made smaller (TextureStore)
    accel::TreeKind tree = accel::TreeKind::Auto;      ///< the tree over the parts of the scene that rays touch

    /// Returns a copy in which the zeros above are replaced by what the machine has. Throws Error for a number below
    /// 0, and for a kind of tree that does not exist.
    Resources resolved() const;
};

/// Holds the pixels of the frame inside the crop: the first and one past the last; it is never empty.
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
