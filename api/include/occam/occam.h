// Occam, for applications: load or build a scene, render it, ask it what a ray meets.
//
//     occam::Scene scene = occam::load("courtyard.glb");
//     occam::Camera camera = scene.camera().value_or(occam::framing(scene));
//     occam::Renderer renderer;
//     renderer.render(scene, camera, {.width = 1280, .height = 720, .spp = 16}).write("courtyard.exr");
//
// The scene is the application's; renderers, jobs and queries only borrow it, and while one of them works on it edits throw.
// Everything that can go wrong is an occam::Error that names file, element and reason.
#pragma once

#include <chrono>
#include <limits>
#include <memory>
#include <optional>

#include "base/error.h"
#include "io/builtin/builtin_scene.h"
#include "io/import/import.h"
#include "render/frame_control.h"
#include "render/image.h"
#include "render/settings.h"
#include "render/stats.h"
#include "render/version.h"
#include "scenegraph/camera_fit.h"
#include "scenegraph/scene.h"
#include "verify/verify.h"

namespace occam {

using render::Aov;
using render::FilterKind;
using render::FrameStats;
using render::Image;
using render::IntegratorKind;
using render::Layer;
using render::Lod;
using render::Resources;
using render::Settings;
using render::ShadeAt;
using render::Tonemap;
using render::View;
using render::WriteOptions;
using shade::Sky;

/// How far a job is: its stage, the fraction done, seconds left (below 0: unknown).
using Progress = render::FrameControl::Progress;
using Stage = render::FrameControl::Stage;

/// The nearest camera that has all of the scene in its picture, as it is posed now, with a narrow margin: what the command
/// line uses where a file has no camera.
/// aspect   width over height of the picture
Camera framing(Scene& scene, float aspect = 16.0f / 9.0f, ViewFrom from = ViewFrom::ThreeQuarter, Vec3d up = {0, 1, 0});

/// A frame on its way, on a thread of its own. Movable; one owner.
class Job {
public:
    Job(Job&&) noexcept;
    Job& operator=(Job&&) noexcept;
    /// Cancels, and waits for the workers to let go of the scene.
    ~Job();

    /// True once the frame is done, cancelled or failed.
    bool wait_for(std::chrono::milliseconds time) const;
    void wait() const;

    Progress progress() const noexcept;
    /// Stops soon, within a batch of rays. Finished tiles stay; with Settings::progressive, all samples so far.
    void cancel() noexcept;

    // These wait for the end, and throw what went wrong if something did.
    const Image& image() const;
    Image take_image();
    const FrameStats& stats() const;
    /// What Renderer::start() can go on from, if the frame was made in rounds (Settings::progressive) and stopped before its
    /// end; else empty. Bytes for this version on machines of this byte order.
    const std::string& checkpoint() const;

private:
    friend class Renderer;
    struct State;
    explicit Job(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// Makes pictures. Keeps what no vertex position can change (topology tables) and textures from frame to frame.
class Renderer {
public:
    explicit Renderer(const Resources& resources = {});
    Renderer(Renderer&&) noexcept;
    Renderer& operator=(Renderer&&) noexcept;
    ~Renderer();

    /// One frame. Throws Error for a bad setting, for a memory budget below memory_floor(), or if this renderer is busy with
    /// another frame.
    Image render(Scene& scene, const Camera& camera, const Settings& settings = {});
    /// The same, without waiting for it.
    /// checkpoint   what Job::checkpoint() of the same scene, camera and settings gave: the frame goes on from there, and
    /// its
    ///              picture has the bits of one that was never stopped. The job fails if it is another picture's.
    Job start(Scene& scene, const Camera& camera, const Settings& settings = {}, std::string checkpoint = {});
    /// The least Resources::memory_bytes that this scene can be rendered with by this renderer's number of threads.
    std::size_t memory_floor(const Scene& scene) const;
    /// Of the last frame that render() made.
    const FrameStats& stats() const noexcept;

private:
    friend class Job;
    friend class Query;
    struct State;
    std::shared_ptr<State> state_;
};

/// What a ray met first.
struct Hit {
    double distance = 0;  ///< along the ray, world length
    Vec3d position{0};
    Vec3f normal_geometric{0};  ///< unit, towards the ray's origin
    Vec3f normal{0};            ///< of shading
    Vec2f uv{0};
    NodeId node;
    std::uint32_t face = 0;  ///< of the node's cage
};

/// The full width of the beam that a ray stands for: `width + spread * t` at the distance t, world length. It decides how
/// fine the surfaces are that the ray meets.
struct RayFootprint {
    float width = 0, spread = 0;
};

/// A ray to be asked about.
struct QueryRay {
    Vec3d origin{0};
    Vec3d direction{0, 0, -1};                             ///< need not be unit
    double far = std::numeric_limits<double>::infinity();  ///< world length
    std::optional<RayFootprint> footprint{};               ///< none: that of a pixel of the query's camera
};

/// Where a ray ends.
struct FirstHit {
    double distance = std::numeric_limits<double>::infinity();  ///< along the ray, world length; infinity: nothing was met
    NodeId node;
    std::uint32_t face = 0;  ///< of the node's cage
};

/// Questions to a scene that holds still: edits throw from construction or begin() until end().
///
/// Surfaces are diced as for the camera's picture: a ray meets what that picture shows, unless it brings a footprint. A
/// query outlives frames: end() lets the application edit the scene, begin() asks about the edited one, and what no vertex
/// position can change is kept between them.
///
/// Memory   at most `memory_bytes` for each thread that asks at the same time.
/// Threads  the const functions from any number of threads at once; begin() and end() while no thread asks.
class Query {
public:
    /// image_height   of the picture whose pixels decide how fine surfaces are
    /// scene          must outlive the query
    Query(Scene& scene, const Camera& camera, int image_height = 720, std::size_t memory_bytes = std::size_t(256) << 20);
    /// Shares the renderer's topology tables, so that none is made twice. The renderer may render meanwhile, and may die
    /// first.
    Query(const Renderer& renderer, Scene& scene, const Camera& camera, int image_height = 720,
          std::size_t memory_bytes = std::size_t(256) << 20);
    Query(Query&&) noexcept;
    ~Query();

    /// Gives the scene back for edits. Questions throw Error until begin().
    void end() noexcept;
    /// Asks about the scene as it is now, seen from that camera. Ends what was begun before.
    void begin(const Camera& camera);

    /// Nearest surface within `far`; `direction` need not be unit. None for a zero or non-finite direction.
    std::optional<Hit> closest(Vec3d origin, Vec3d direction, double far = std::numeric_limits<double>::infinity()) const;
    std::optional<Hit> closest(const QueryRay& ray) const;
    /// The same for many rays at once, without what shading needs: several times as fast a ray where they lie close together
    /// (sensors, lines of sight, footsteps). hits.size() == rays.size(), else it throws std::invalid_argument.
    void first_hits(std::span<const QueryRay> rays, std::span<FirstHit> hits) const;
    /// True if anything lies strictly between the two points.
    bool is_occluded(Vec3d from, Vec3d to) const;
    bool is_occluded(const QueryRay& ray) const;
    /// What a pixel of the camera's picture shows; x and y in pixels of a width x image_height frame.
    std::optional<Hit> pick(double x, double y, int width) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace occam
