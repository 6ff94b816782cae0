// The interface of Occam for applications: load or build a scene, render it, and ask which surface a ray hits.
//
//     occam::Scene scene = occam::load("courtyard.glb");
//     occam::Camera camera = scene.camera().value_or(occam::framing(scene));
//     occam::Renderer renderer;
//     renderer.render(scene, camera, {.width = 1280, .height = 720, .spp = 16}).write("courtyard.exr");
//
// The application owns the scene. Renderers, jobs and queries only borrow it, and while one of them works on it, edits
// throw; what has no function to edit it, such as Scene::environment, must stay as it is. What fails throws an occam::Error
// that names the reason and, as far as there are any, file and element. Where there is not enough memory it may be a
// std::bad_alloc instead. What a callback of the application throws is passed on as it is, but for a std::bad_alloc: that
// counts as any other lack of memory, so that frames end with an Error that says so.
//
// Renderers, jobs, queries, framing() and record_shutter() round to the nearest number, whatever the calling thread does
// otherwise, and so do the callbacks that they call.
#pragma once

#include <chrono>
#include <functional>
#include <iosfwd>
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

using accel::TreeKind;
using render::Aov;
using render::AovSet;
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

/// Says how far a job is: its stage, the fraction done, and the seconds left (below 0: unknown).
using Progress = render::FrameControl::Progress;
using Stage = render::FrameControl::Stage;

/// Returns the nearest camera that has all of the scene, as it is posed now, in its picture, with a narrow margin. The
/// command line uses it where a file has no camera. A displaced surface counts as if it reached Displacement::bound on all
/// sides, so that it may fill less of the picture.
/// aspect   width over height of the picture; Error unless it is finite and above 0
Camera framing(Scene& scene, float aspect = 16.0f / 9.0f, ViewFrom from = ViewFrom::ThreeQuarter, Vec3d up = {0, 1, 0});

/// Poses the scene by `pose` and records what moves while the shutter of the next frame is open, with the fewest segments
/// that keep all paths within a quarter of a pixel: what the command line does for --shutter. Returns the camera of the
/// frame, which has keys if it moves itself, whether a node carries it or the application computes it: as many as 32
/// segments have, or as `segments` says. Settings::shutter should say how many frames the shutter is open.
/// pose       poses the scene at a moment of the shutter: 0 when it opens, 1 when it closes. See Scene::record_shutter()
/// camera     returns the camera of the scene as it is posed then, for instance by Scene::camera(). It is called after
///            `pose` at each moment, and at the end in the middle of the shutter, which decides the lens. If it returns a
///            camera with keys while moments are recorded, the last one's keys are taken as they are
/// height     of the picture in pixels
/// segments   1, 2, 4, 8, 16 or 32; 0: as many as are needed, up to 32
Camera record_shutter(Scene& scene, const std::function<void(double tau)>& pose, const std::function<Camera()>& camera,
                      int height, int segments = 0);

/// A frame that is being rendered on a thread of its own. A job has one owner and can be moved. A Job, a Renderer or a Query
/// that was moved from may only be destroyed; a Job and a Renderer may be assigned to as well.
class Job {
public:
    Job(Job&&) noexcept;
    Job& operator=(Job&&) noexcept;
    /// Cancels the frame, and waits until no worker uses the scene.
    ~Job();

    /// Returns true if the frame is done, cancelled or failed within this time.
    bool wait_for(std::chrono::milliseconds time) const;
    void wait() const;

    Progress progress() const noexcept;
    /// Stops the frame soon: before it begins, or within a batch of rays. That is no failure. The picture keeps the tiles
    /// that are finished, or all samples so far with Settings::progressive, and FrameStats::complete is false.
    void cancel() noexcept;

    // These functions wait for the end. If the frame failed, they throw what it ended with: an Error, std::bad_alloc, or
    // what a callback of the application has thrown.
    const Image& image() const;
    /// Returns the picture and leaves an empty one to the job.
    Image take_image();
    const FrameStats& stats() const;
    /// Returns what Renderer::start() can continue from, if the frame was made in rounds (Settings::progressive) and stopped
    /// before its end; else an empty string. If it failed because a texture proved unreadable, that is what was made before,
    /// so that nothing is lost once the file can be read (a frame without a sample throws). The bytes are valid for this
    /// version on machines of this byte order.
    const std::string& checkpoint() const;

private:
    friend class Renderer;
    struct State;
    explicit Job(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// Names one sample of a picture.
struct PixelSample {
    int x = 0, y = 0;  ///< pixel of the whole frame, from the top left
    int sample = 0;    ///< number among the samples of the pixel, from 0
};

/// Holds what a sample contributes to its pixel; the colour is multiplied by alpha.
struct SampleColor {
    Vec3f radiance{0};
    float alpha = 0;
};

/// Makes pictures. From frame to frame it keeps textures, everything that no vertex position can change (topology tables),
/// and placed lights with the tree over them, as long as they are the same. What the scene no longer has is forgotten when a
/// frame begins, and an image that could not be read is read again.
class Renderer {
public:
    explicit Renderer(const Resources& resources = {});
    Renderer(Renderer&&) noexcept;
    Renderer& operator=(Renderer&&) noexcept;
    ~Renderer();

    /// Renders one frame. Throws Error for a bad setting or camera, for a memory budget below memory_floor(), or if this
    /// renderer is busy with another frame.
    Image render(Scene& scene, const Camera& camera, const Settings& settings = {});
    /// Starts a frame and returns without waiting for it. `checkpoint` may hold what Job::checkpoint() returned for the same
    /// scene, camera and settings: the frame then continues from there, and its picture has the same bits as one that was
    /// never stopped. The job fails if the checkpoint belongs to another picture. Scenes are compared by a hash over
    /// the environment, all visible nodes in their order, also those that hold nothing, and what they hold; of an image in a
    /// file it knows the path, and of a cage on demand its name, bounds and materials. With Aov::Id or View::Face it also
    /// knows the slots of the handles of nodes (NodeId::slot), which these show: the checkpoint then belongs to a scene
    /// whose nodes were added and removed in the same order.
    /// Throws what render() throws, and Error if the system gives no thread for the frame; render() does without one.
    Job start(Scene& scene, const Camera& camera, const Settings& settings = {}, std::string checkpoint = {});
    /// Traces one sample of the picture that render() would make, and writes to `out` what each of its rays does and how
    /// each hit is shaded. Returns what the sample contributes, with the bits that it has in the picture. Throws Error for a
    /// pixel outside of the picture, for a sample that it does not have, and for a texture that cannot be decoded.
    SampleColor replay(Scene& scene, const Camera& camera, const Settings& settings, const PixelSample& which,
                       std::ostream& out);
    /// Returns the least Resources::memory_bytes with which this renderer's number of threads can render the scene.
    std::size_t memory_floor(const Scene& scene) const;
    /// Returns a number that tells how often each image of the scene is halved to fit Resources::texture_bytes, which
    /// changes pictures; 0 if none is. Opens the images. Throws Error for images that cannot be decoded in reasonable time,
    /// or if this renderer is busy with a frame.
    std::uint64_t halvings(const Scene& scene);
    /// Returns the statistics of the last frame that render() made. Call it while render() makes no other frame.
    const FrameStats& stats() const noexcept;

private:
    friend class Job;
    friend class Query;
    struct State;
    Job start(Scene& scene, const Camera& camera, const Settings& settings, std::string checkpoint, bool caller_waits);
    std::shared_ptr<State> state_;
};

/// Describes the first surface that a ray hits.
struct Hit {
    double distance = 0;  ///< along the ray, world length
    Vec3d position{0};
    Vec3f normal_geometric{0};  ///< unit, towards the ray's origin
    Vec3f normal{0};            ///< shading normal, unit
    Vec2f uv{0};
    NodeId node;
    NodeId instance;         ///< the innermost node that shows that one by NodeDesc::instance_of; null: none does
    CageId cage;             ///< of the node's cages
    std::uint32_t face = 0;  ///< index in the cage
    /// Of the surface there at the ray's time, by its own motion: world length per shutter. Between two keys of the shutter
    /// the surface moves straight on, and this is the slope of that segment; at a key, that of the segment which begins
    /// there or, at the end of the shutter, ends there.
    Vec3f velocity{0};
};

/// The full width of a ray's beam, which is `width + spread * t` at the distance t, in world length. It decides how fine the
/// surfaces are that the ray sees: without a width, as fine as can be. Only what rounding would hide is left out: edges are
/// not much shorter than 1.2e-7 of the surface's distance from the query's camera. A ray without a width that begins more
/// than some 10^5 times the size of a surface away from it may meet so many of its details that the question is refused.
struct RayFootprint {
    float width = 0, spread = 0;
};

/// A ray of a query. It is traced with a direction of floats, so at the distance t it is off by about 6e-8 t, in its
/// position and by as much in what it hits: a ray that starts far from a small surface may miss it. Its origin is exact.
/// `far` is rounded upwards to a float, so that surfaces there are hit, and those up to 3e-7 of it farther away may be. The
/// levels of detail that a beam blends are chosen up to `far`, so another `far` may move what it hits by a small part of the
/// beam's width: a ray that ends just behind a hit of a longer one need not hit it again. A ray whose origin or direction is
/// not finite, whose direction is zero, whose `far` is not a number or whose origin is some 10^30 times the size of the
/// scene away hits nothing. Questions throw Error, before any of their rays is traced, for a footprint or a time out of
/// range, and for kinds that see nothing.
struct QueryRay {
    Vec3d origin{0};
    Vec3d direction{0, 0, -1};                             ///< need not be unit
    double far = std::numeric_limits<double>::infinity();  ///< world length
    /// If it is absent, it is that of a pixel of the query's camera where the ray starts, and grows as the camera's does.
    std::optional<RayFootprint> footprint{};
    float time = 0.5f;  ///< from 0 (the shutter opens) to 1; only for scenes whose shutter is recorded
    /// It passes through surfaces that rays of none of these kinds see (NodeDesc::seen_by).
    std::uint8_t kinds = RayKind::Camera;
};

/// Says where a ray ends.
struct FirstHit {
    double distance = std::numeric_limits<double>::infinity();  ///< along the ray, world length; infinity: nothing was hit
    NodeId node;
    CageId cage;             ///< of the node's cages
    std::uint32_t face = 0;  ///< index in the cage
    NodeId instance{};       ///< as in Hit
};

/// Answers questions about a scene that must not change meanwhile: edits throw from construction or begin() until end().
///
/// Surfaces are diced as for the camera's picture with a shading rate of 1 and a level for each ray: a ray hits what that
/// picture shows, unless it has a footprint of its own. It passes the holes of alpha masks. It hits what is transparent in
/// other ways, and the backs of single-sided surfaces.
///
/// A query can be used for many frames: end() lets the application edit the scene, begin() continues with the edited scene,
/// and everything that no vertex position can change is kept in between.
///
/// Memory   at most `memory_bytes` for each thread that asks at the same time, or what a single ray needs if that is more
///          (some megabytes, but up to 1.5 GB where it is much finer than a displacement's bound). With a small budget
///          questions take longer, and have the same answers.
/// Threads  any number of threads may call the const functions at once; begin() and end() need to be called alone.
/// Errors   in a scene with displacements or masks, begin() and questions throw Error if a texture cannot be read.
class Query {
public:
    /// image_height   height of the picture whose pixels decide how fine surfaces are
    /// scene          must outlive the query and stay where it is
    Query(Scene& scene, const Camera& camera, int image_height = 720, std::size_t memory_bytes = std::size_t(256) << 20);
    /// Shares the renderer's topology tables, so that none is made twice, and halves textures of displacement as often as
    /// the renderer does. The renderer may render meanwhile, and may be destroyed first.
    Query(const Renderer& renderer, Scene& scene, const Camera& camera, int image_height = 720,
          std::size_t memory_bytes = std::size_t(256) << 20);
    Query(Query&&) noexcept;
    ~Query();

    /// Allows edits of the scene again. Questions throw Error until begin().
    void end() noexcept;
    /// Prepares questions about the scene as it is now, seen from that camera. Calls end() first if that was not done.
    void begin(const Camera& camera);

    /// Returns the nearest surface within `far`, as precisely as QueryRay says; `direction` need not be unit. Returns none
    /// for a direction that is zero or not finite, for an origin that is not finite, and for a `far` that is not a number.
    std::optional<Hit> closest(Vec3d origin, Vec3d direction, double far = std::numeric_limits<double>::infinity()) const;
    std::optional<Hit> closest(const QueryRay& ray) const;
    /// Finds the nearest surfaces of many rays at once, without what shading needs. This is several times as fast for each
    /// ray where rays lie close together (sensors, lines of sight, footsteps). Throws Error if hits.size() differs from
    /// rays.size().
    void first_hits(std::span<const QueryRay> rays, std::span<FirstHit> hits) const;
    /// Returns true if a surface lies between the two points. A point on a surface has to be moved off it, towards the other
    /// one, by more than its coordinates are rounded and more than a footprint there: else its own surface may count.
    bool is_occluded(Vec3d from, Vec3d to) const;
    bool is_occluded(const QueryRay& ray) const;
    /// Returns the surface that a pixel of the camera's picture shows, through the middle of its lens; x and y are in pixels
    /// of a width x image_height frame. Returns none if either is not finite.
    std::optional<Hit> pick(double x, double y, int width) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace occam
