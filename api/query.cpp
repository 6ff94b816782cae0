#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <stdexcept>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "api/renderer_state.h"
#include "base/default_floats.h"
#include "base/error_without_file.h"
#include "base/unit_vector.h"
#include "render/camera_rays.h"
#include "render/hole_filter.h"
#include "scenegraph/content_rules.h"

namespace occam {
namespace {

int checked_height(int height)
{
    if (height < 1 || height > render::kMaxSide)
        throw error_without_file(
            "it must be from 1 to " + std::to_string(render::kMaxSide) + " pixels, not " + std::to_string(height),
            "image_height");
    return height;
}

// Holds the scene that queries ask about, as it was when they began.
struct Asked {
    /// holes   let rays pass the holes of surfaces, as they do in the picture
    Asked(Scene& scene, const Camera& camera, int height, const std::shared_ptr<SharedTopologies>& topologies,
          const TextureStore& textures, const render::HoleFilter& holes)
        : scale(scene.bounds()),
          lock(scene),
          tables(topologies, scene),
          frame(scene, tables.cache(), render::CameraRays(scale.placed(camera), height, height).levels(1),
                {.textures = &textures,
                 .shading = {nullptr, 1, holes.if_needed(scene.contents())},
                 .scale = scale,
                 .refuses_endless = false})
    {
    }
    FrameScale scale;
    Scene::FrameLock lock;
    TopologyUse tables;
    accel::Frame frame;
};

/// Returns the end of a ray as a float that is a little above it: the distance of a surface that lies there is a float, too,
/// and rays end before the end that they are given.
float end_above(double far) noexcept
{
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    if (!(far > 0)) return 0;
    float end = far < double(std::numeric_limits<float>::max()) ? static_cast<float>(far) : kInfinity;
    for (int step = 0; step < 2; ++step) end = std::nextafter(end, kInfinity);
    return end;
}

/// Returns the footprint in frame lengths. A width of 0 everywhere is that of the finest surface: a ray without a footprint
/// would have the camera's.
lod::Footprint footprint_of(const RayFootprint& asked, const FrameScale& scale) noexcept
{
    const float width = scale.to_frame(asked.width);
    return {asked.spread == 0 ? std::max(width, std::numeric_limits<float>::min()) : width, asked.spread};
}

void check_ray(const QueryRay& asked)
{
    if (const auto& f = asked.footprint; f && !(f->width >= 0 && std::isfinite(f->width) && std::isfinite(f->spread)))
        throw error_without_file("a footprint's width must be finite and 0 or more, and its spread finite", "ray");
    if (!(asked.time >= 0 && asked.time <= 1)) throw error_without_file("a ray's time must be from 0 to 1", "ray");
    if ((asked.kinds & RayKind::All) == 0) throw error_without_file("a ray must be of a kind that sees something", "ray");
}

/// Rays that start farther away, in lengths of the frame, see nothing: their distances would not be finite floats.
constexpr double kFarthestOrigin = 1e30;

/// The ray that is asked for has to pass check_ray().
accel::Ray ray_of(const QueryRay& asked, const Asked& about)
{
    accel::Ray ray;
    // The ray stays one that hits nothing if it has no direction, no origin or no end. One whose end is not a number would
    // decide for all rays of its packet where they end.
    ray.t_far = 0;
    const Vec3d direction = unit_vector(asked.direction), origin = asked.origin * about.scale.to_frame();
    if (direction == Vec3d(0) || !(glm::length(origin) <= kFarthestOrigin) || std::isnan(asked.far)) return ray;
    ray.time = asked.time;
    ray.kinds = asked.kinds;
    ray.origin = origin;
    ray.direction = Vec3f(direction);
    ray.t_far = end_above(asked.far * about.scale.to_frame());
    if (asked.footprint) ray.footprint = footprint_of(*asked.footprint, about.scale);  // else the camera's at the origin
    return ray;
}

}  // namespace

struct Query::State {
    State(Scene& borrowed, int image_height, std::size_t bytes, std::shared_ptr<SharedTopologies> tables,
          std::size_t texture_bytes = render::Resources().texture_bytes)
        : scene(borrowed),
          height(checked_height(image_height)),
          memory_bytes(bytes),
          topologies(std::move(tables)),
          textures(texture_bytes)
    {
    }
    ~State() { end(); }
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    void begin(const Camera& with_camera)
    {
        const DefaultFloats floats;
        check(with_camera);
        end();
        scene.refit();
        // Of textures that were looked up before, neither memory nor errors are left.
        if (looks_up_textures()) textures.prepare(scene);
        else textures.clear();
        textures.throw_if_failed();
        camera = with_camera;
        asked.emplace(scene, camera, height, topologies, textures, holes);
    }
    void end() noexcept
    {
        idle.clear();
        tracers = 0;
        asked.reset();
    }
    const Asked& asked_about() const
    {
        if (!asked) throw error_without_file("the query was ended: begin() has to be called before it is asked", "Query");
        return *asked;
    }

    // Borrows a tracer for one caller. It goes back into the pool afterwards, with what it has built, unless the caller ends
    // by an exception: what it has built may then be half made.
    class Borrowed {
    public:
        explicit Borrowed(State& state) : state_(state)
        {
            state.asked_about();
            {
                const std::lock_guard guard(state.mutex);
                if (!state.idle.empty()) {
                    tracer_ = std::move(state.idle.back());
                    state.idle.pop_back();
                }
            }
            if (tracer_) return;
            tracer_ = std::make_unique<accel::Tracer>(state.asked->frame, state.memory_bytes);
            // The pool has room for all tracers, so that giving one back needs no memory.
            const std::lock_guard guard(state.mutex);
            state.idle.reserve(++state.tracers);
        }
        ~Borrowed()
        {
            const std::lock_guard guard(state_.mutex);
            if (std::uncaught_exceptions() == before_) state_.idle.push_back(std::move(tracer_));
            else --state_.tracers;
        }
        Borrowed(const Borrowed&) = delete;
        Borrowed& operator=(const Borrowed&) = delete;
        accel::Tracer& tracer() const noexcept { return *tracer_; }

    private:
        State& state_;
        const int before_ = std::uncaught_exceptions();
        std::unique_ptr<accel::Tracer> tracer_;
    };

    /// Calls call(tracer) under the DefaultFloats of the caller. What it finds does not count if a displacement or a mask
    /// cannot be read, for which a stand-in was taken.
    template <class Call>
    void ask(Call&& call)
    {
        const Borrowed borrowed(*this);
        call(borrowed.tracer());
        textures.throw_if_failed();
    }
    bool looks_up_textures() const { return scene.contents().has(Contents::Displaced | Contents::Masked); }

    std::optional<Hit> closest(const accel::Ray& ray)
    {
        if (!(ray.t_far > 0)) return std::nullopt;
        accel::SurfaceHit hit;
        ask([&](accel::Tracer& tracer) { tracer.closest({&ray, 1}, {&hit, 1}); });
        if (!hit.is_hit()) return std::nullopt;
        const double to_world = asked->scale.to_world();
        Hit found;
        found.distance = double(hit.t) * to_world;
        found.position = hit.position * to_world;
        found.normal_geometric = hit.normal_geometric;
        found.normal = hit.normal_shading;
        found.uv = hit.uv[0];
        found.node = hit.node;
        found.instance = hit.instance;
        found.cage = hit.cage;
        found.face = hit.face;
        found.velocity = hit.velocity * static_cast<float>(to_world);
        return found;
    }

    bool is_occluded(const accel::Ray& ray)
    {
        if (!(ray.t_far > 0)) return false;
        std::uint8_t occluded = 0;
        ask([&](accel::Tracer& tracer) { tracer.occluded({&ray, 1}, {&occluded, 1}); });
        return occluded != 0;
    }

    Scene& scene;
    Camera camera;
    int height;
    std::size_t memory_bytes;
    std::shared_ptr<SharedTopologies> topologies;
    TextureStore textures;  // of displacements and masks
    const render::HoleFilter holes{textures};
    std::optional<Asked> asked;
    std::mutex mutex;  // guards the pool
    std::vector<std::unique_ptr<accel::Tracer>> idle;
    std::size_t tracers = 0;  ///< idle or borrowed
};

Query::Query(Scene& scene, const Camera& camera, int image_height, std::size_t memory_bytes)
    : state_(std::make_unique<State>(scene, image_height, memory_bytes, std::make_shared<SharedTopologies>()))
{
    begin(camera);
}
Query::Query(const Renderer& renderer, Scene& scene, const Camera& camera, int image_height, std::size_t memory_bytes)
    : state_(std::make_unique<State>(scene, image_height, memory_bytes, renderer.state_->topologies,
                                     renderer.state_->resources.texture_bytes))
{
    begin(camera);
}
Query::Query(Query&&) noexcept = default;
Query::~Query() = default;

void Query::begin(const Camera& camera) { state_->begin(camera); }
void Query::end() noexcept { state_->end(); }

std::optional<Hit> Query::closest(Vec3d origin, Vec3d direction, double far) const
{
    return closest(QueryRay{origin, direction, far});
}

std::optional<Hit> Query::closest(const QueryRay& ray) const
{
    const DefaultFloats floats;
    check_ray(ray);
    return state_->closest(ray_of(ray, state_->asked_about()));
}

void Query::first_hits(std::span<const QueryRay> rays, std::span<FirstHit> hits) const
{
    if (rays.size() != hits.size()) throw error_without_file("Query::first_hits() needs as many hits as rays");
    const DefaultFloats floats;
    for (const QueryRay& ray : rays) check_ray(ray);  // so that no hit is written if one of the rays is refused
    constexpr std::size_t kBatch = 2048;
    std::vector<accel::Ray> batch;
    std::vector<accel::FirstHit> found;
    state_->ask([&](accel::Tracer& tracer) {
        for (std::size_t first = 0; first < rays.size(); first += kBatch) {
            const std::size_t count = std::min(kBatch, rays.size() - first);
            batch.clear();
            for (const QueryRay& ray : rays.subspan(first, count)) batch.push_back(ray_of(ray, *state_->asked));
            found.resize(count);
            tracer.first_hits(batch, found);
            for (std::size_t i = 0; i < count; ++i)
                hits[first + i] = {double(found[i].t) * state_->asked->scale.to_world(), found[i].node, found[i].cage,
                                   found[i].face, found[i].instance};
        }
    });
}

bool Query::is_occluded(Vec3d from, Vec3d to) const
{
    const DefaultFloats floats;
    return is_occluded(QueryRay{from, to - from, glm::distance(from, to)});
}

bool Query::is_occluded(const QueryRay& ray) const
{
    const DefaultFloats floats;
    check_ray(ray);
    return state_->is_occluded(ray_of(ray, state_->asked_about()));
}

std::optional<Hit> Query::pick(double x, double y, int width) const
{
    const Asked& about = state_->asked_about();
    if (width < 1 || width > render::kMaxSide)
        throw error_without_file(
            "it must be from 1 to " + std::to_string(render::kMaxSide) + " pixels, not " + std::to_string(width), "width");
    if (!std::isfinite(x) || !std::isfinite(y)) return {};
    const DefaultFloats floats;
    Camera placed = about.scale.placed(state_->camera);
    placed.lens.radius = 0;  // the ray through the middle of the lens, which does not end at the plane of focus
    return state_->closest(render::CameraRays(placed, width, state_->height).ray(x, y, Vec2f(0.5f), 0.5f));
}

}  // namespace occam
