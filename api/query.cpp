#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "occam/occam.h"
#include "render/camera_rays.h"

namespace occam {
namespace {

int checked_height(int height)
{
    if (height < 1 || height > render::kMaxSide)
        throw Error("", "from 1 to " + std::to_string(render::kMaxSide), "image height");
    return height;
}

const TextureStore& prepared(TextureStore& textures, const Scene& scene)
{
    if (scene.is_displaced()) textures.prepare(scene);
    return textures;
}

const Scene& refitted(Scene& scene)
{
    scene.refit();
    return scene;
}

}  // namespace

struct Query::State {
    State(Scene& borrowed, const Camera& with_camera, int image_height, std::size_t memory_bytes)
        : camera(with_camera),
          height(checked_height(image_height)),
          rays(camera, height, height),
          lock(refitted(borrowed)),
          textures(render::Resources().texture_bytes),
          frame(borrowed, topologies, rays.levels(1), &prepared(textures, borrowed)),
          tracer(frame, memory_bytes)
    {
    }

    /// Of nothing, for a direction without length.
    accel::Ray ray(Vec3d origin, Vec3d direction, double far) const
    {
        accel::Ray ray;
        ray.t_far = 0;
        const double length = glm::length(direction);
        if (!(length > 0) || !std::isfinite(length) || !std::isfinite(glm::dot(origin, origin))) return ray;
        ray.origin = origin;
        ray.direction = Vec3f(direction / length);
        ray.t_far = static_cast<float>(far);
        ray.footprint = rays.pixel();
        return ray;
    }

    std::optional<Hit> closest(const accel::Ray& ray)
    {
        accel::SurfaceHit hit;
        tracer.closest({&ray, 1}, {&hit, 1});
        if (!hit.is_hit()) return std::nullopt;
        return Hit{double(hit.t), hit.position, hit.normal_geometric, hit.normal_shading, hit.uv[0], hit.node, hit.face};
    }

    Camera camera;
    int height;
    render::CameraRays rays;
    Scene::FrameLock lock;
    lod::TopologyCache topologies;
    TextureStore textures;  ///< of displacement
    accel::Frame frame;
    accel::Tracer tracer;
};

Query::Query(Scene& scene, const Camera& camera, int image_height, std::size_t memory_bytes)
    : state_(std::make_unique<State>(scene, camera, image_height, memory_bytes))
{
}
Query::Query(Query&&) noexcept = default;
Query::~Query() = default;

std::optional<Hit> Query::closest(Vec3d origin, Vec3d direction, double far)
{
    const accel::Ray ray = state_->ray(origin, direction, far);
    return ray.t_far > 0 ? state_->closest(ray) : std::nullopt;
}

void Query::first_hits(std::span<const QueryRay> rays, std::span<FirstHit> hits)
{
    if (rays.size() != hits.size()) throw std::invalid_argument("Query::first_hits: as many hits as rays are wanted");
    constexpr std::size_t kBatch = 2048;
    std::vector<accel::Ray> batch;
    std::vector<accel::FirstHit> found;
    for (std::size_t first = 0; first < rays.size(); first += kBatch) {
        const std::size_t count = std::min(kBatch, rays.size() - first);
        batch.clear();
        for (const QueryRay& ray : rays.subspan(first, count))
            batch.push_back(state_->ray(ray.origin, ray.direction, ray.far));
        found.resize(count);
        state_->tracer.first_hits(batch, found);
        for (std::size_t i = 0; i < count; ++i) hits[first + i] = {double(found[i].t), found[i].node, found[i].face};
    }
}

bool Query::is_occluded(Vec3d from, Vec3d to)
{
    const accel::Ray ray = state_->ray(from, to - from, glm::distance(from, to));
    if (!(ray.t_far > 0)) return false;
    std::uint8_t occluded = 0;
    state_->tracer.occluded({&ray, 1}, {&occluded, 1});
    return occluded != 0;
}

std::optional<Hit> Query::pick(double x, double y, int width)
{
    if (width < 1 || width > render::kMaxSide) throw Error("", "from 1 to " + std::to_string(render::kMaxSide), "width");
    return state_->closest(render::CameraRays(state_->camera, width, state_->height).ray(x, y));
}

}  // namespace occam
