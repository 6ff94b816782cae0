#include <cmath>

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
    const double length = glm::length(direction);
    if (!(length > 0) || !std::isfinite(length) || !std::isfinite(glm::dot(origin, origin))) return std::nullopt;
    accel::Ray ray;
    ray.origin = origin;
    ray.direction = Vec3f(direction / length);
    ray.t_far = static_cast<float>(far);
    ray.footprint = state_->rays.pixel();
    return state_->closest(ray);
}

bool Query::is_occluded(Vec3d from, Vec3d to)
{
    const Vec3d way = to - from;
    const double length = glm::length(way);
    if (!(length > 0) || !std::isfinite(length)) return false;
    accel::Ray ray;
    ray.origin = from;
    ray.direction = Vec3f(way / length);
    ray.t_far = static_cast<float>(length);
    ray.footprint = state_->rays.pixel();
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
