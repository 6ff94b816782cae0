#include "tests/bench/subjects.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <utility>

#include "base/error.h"
#include "io/import/import.h"
#include "lod/dicer.h"
#include "lod/pose_cage.h"
#include "render/sampler.h"
#include "render/tiles.h"
#include "tests/bench/harness.h"
#include "tests/support/shape_builders.h"

namespace occam::bench {
namespace {

constexpr double kPi = 3.14159265358979323846;

// Returns a number in [0, 1) for an index, the same in every run (by a finaliser of 32 bits).
double number(std::uint32_t i, std::uint32_t which)
{
    std::uint32_t h = i * 0x9e3779b9u + which * 0x85ebca6bu + 1;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (h ^ h >> 16) / 4294967296.0;
}

}  // namespace

Cage torus(std::uint32_t around, std::uint32_t across) { return test::torus(around, across, false); }

Cage fan(int valence, float crease)
{
    constexpr int kSide = 3;
    Cage cage;
    std::map<std::array<int, 3>, std::uint32_t> known;  // sector and steps along its two sides
    const auto vertex = [&](int sector, int a, int b) {
        if (a == 0 && b == 0) sector = 0;
        else if (a == 0) {
            sector = (sector + 1) % valence;
            a = std::exchange(b, 0);
        }
        const auto [at, is_new] = known.try_emplace({sector, a, b}, static_cast<std::uint32_t>(cage.positions.size()));
        if (is_new) {
            const double from = 2 * kPi * sector / valence, to = 2 * kPi * (sector + 1) / valence;
            const double x = a * std::cos(from) + b * std::cos(to), y = a * std::sin(from) + b * std::sin(to);
            cage.positions.push_back({float(x), float(y), float(0.4 * std::cos(1.3 * x) * std::cos(0.9 * y))});
        }
        return at->second;
    };
    for (int s = 0; s < valence; ++s)
        for (int b = 0; b < kSide; ++b)
            for (int a = 0; a < kSide; ++a) {
                cage.face_sizes.push_back(4);
                cage.face_vertices.insert(cage.face_vertices.end(), {vertex(s, a, b), vertex(s, a + 1, b),
                                                                     vertex(s, a + 1, b + 1), vertex(s, a, b + 1)});
            }
    for (int a = 0; a < kSide && crease > 0; ++a) cage.creases.push_back({vertex(0, a, 0), vertex(0, a + 1, 0), crease});
    return cage;
}

std::optional<Cage> suzanne() { return shared_cage("subdiv/suzanne.obj"); }

std::filesystem::path shared_folder()
{
    namespace fs = std::filesystem;
    const char* named = std::getenv("OCCAM_SHARED");
    return (named ? fs::path(named) : fs::path(OCCAM_SOURCE_DIR).parent_path() / "shared") / "data";
}

std::optional<Cage> shared_cage(const char* name)
{
    const std::filesystem::path file = shared_folder() / name;
    if (!std::filesystem::exists(file)) return std::nullopt;
    const Scene scene = load(file, {.subdivide = Subdivide::On});
    std::optional<Cage> cage;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
        if (!cage && !node.cages.empty()) cage = scene.cage(node.cages.front()).cage;
    });
    if (cage) cage->materials.clear();  // they belong to another scene
    if (cage) cage->face_slots.clear();
    return cage;
}

Subject::Subject(std::string what, Cage cage, int width, int height, std::optional<Camera> camera, float shading_rate)
    : name(std::move(what)), width_(width), height_(height)
{
    const CageId id = scene.add(std::move(cage));
    NodeDesc desc;
    desc.cages = {id};
    const NodeId node = scene.add_node(scene.root(), std::move(desc));
    camera_ = camera.value_or(Camera::framing(scene.bounds(), static_cast<float>(width) / static_cast<float>(height)));
    if (!camera) camera_.lens.fov *= 0.75f;  // framing() shows the whole box, but its middle is enough
    const CageSlot& slot = scene.cage(id);
    const double start = thread_seconds();
    const lod::CageTables& tables = topologies.get(slot);
    topology_seconds = thread_seconds() - start;
    lod::LevelSettings levels = render::CameraRays(camera_, width, height).levels(shading_rate);
    levels.mode = lod::LevelMode::PerInstance;  // all rays see one mesh, as in Embree
    const Mat4d at_origin(1);
    lod::DeformCounters counters;
    posed = lod::pose_cage({slot, scene.node(node), node, nullptr, {&at_origin, 1}}, levels,
                           {tables, nullptr, pose_, counters});
    frame = std::make_unique<accel::Frame>(scene, topologies, levels);
}

TreePair::TreePair(const Scene& scene, lod::TopologyCache& topologies, const lod::LevelSettings& levels,
                   std::size_t memory_bytes)
    : kd_frame(scene, topologies, levels, {.tree = accel::TreeKind::Kd}),
      bvh_frame(scene, topologies, levels, {.tree = accel::TreeKind::Bvh}),
      kd(kd_frame, memory_bytes),
      bvh(bvh_frame, memory_bytes),
      usual(accel::Frame(scene, topologies, levels).tree())
{
}

std::vector<accel::Ray> Subject::camera_rays() const
{
    constexpr int kSide = 2;
    const render::CameraRays camera(camera_, width_, height_);
    std::vector<accel::Ray> rays;
    for (const render::PixelRect& tile : render::make_tiles({0, 0, width_, height_}))
        for (const auto [x, y] : render::pixels_of(tile))
            for (int s = 0; s < kSide * kSide; ++s)
                rays.push_back(camera.ray(x + (s % kSide + 0.5) / kSide, y + (s / kSide + 0.5) / kSide));
    return rays;
}

std::vector<std::unique_ptr<Subject>> usual_subjects(int width, int height)
{
    std::vector<std::unique_ptr<Subject>> all;
    all.push_back(std::make_unique<Subject>("torus", torus(24, 12), width, height));
    // One level serves the whole cage, and some of it is close to this eye. If its micropolygons there were as small as a
    // pixel, there would be millions of them.
    const Camera in_tube = Camera::look_at({1, 0, 0}, {1, 0.1, 1}, {0, 1, 0}, 1.2f);
    all.push_back(std::make_unique<Subject>("tube", torus(24, 12), width, height, in_tube, 32.0f));
    if (auto cage = suzanne()) all.push_back(std::make_unique<Subject>("suzanne", std::move(*cage), width, height));
    return all;
}

std::vector<accel::Ray> rays_of_a_frame(const render::CameraRays& camera, int width, int height, int samples)
{
    const render::Sampler sampler(1, samples, true);
    std::vector<accel::Ray> rays;
    for (const render::PixelRect& tile : render::make_tiles({0, 0, width, height}))
        for (const auto [x, y] : render::pixels_of(tile))
            for (int s = 0; s < samples; ++s) {
                const auto index = static_cast<std::uint32_t>(s);
                const Vec2f in = sampler.in_pixel(x, y, s), lens = sampler.square(x, y, index, render::Dimension::lens());
                rays.push_back(camera.ray(x + double(in.x), y + double(in.y), lens,
                                          sampler.interval(x, y, index, render::Dimension::time())));
            }
    return rays;
}

std::vector<accel::Ray> diffuse_rays(std::span<const accel::Ray> rays, std::span<const accel::SurfaceHit> hits)
{
    std::vector<accel::Ray> all;
    for (std::uint32_t i = 0; i < hits.size(); ++i) {
        const accel::SurfaceHit& hit = hits[i];
        if (!hit.is_hit()) continue;
        const double r2 = number(i, 1), angle = 2 * kPi * number(i, 2);
        const Vec3d n(hit.normal_geometric);
        const Vec3d u = glm::normalize(glm::cross(n, std::abs(n.x) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0))),
                    v = glm::cross(n, u);
        const Vec3d d = std::sqrt(r2) * (std::cos(angle) * u + std::sin(angle) * v) + std::sqrt(1 - r2) * n;
        accel::Ray ray;
        ray.origin = hit.position + Vec3d(hit.to_start) + Vec3d(hit.start_normal) * double(hit.self_distance);
        ray.start_level = hit.start_level;
        ray.direction = Vec3f(glm::normalize(d));
        ray.time = rays[i].time;
        ray.footprint = {rays[i].footprint.at(hit.t), 0};
        all.push_back(ray);
    }
    return all;
}

void trace_closest(accel::Tracer& tracer, std::span<const accel::Ray> rays, std::span<accel::SurfaceHit> hits)
{
    for (std::size_t i = 0; i < rays.size(); i += kBatch) {
        const std::size_t n = std::min(kBatch, rays.size() - i);
        tracer.closest(rays.subspan(i, n), hits.subspan(i, n));
    }
}

void trace_occluded(accel::Tracer& tracer, std::span<const accel::Ray> rays, std::span<std::uint8_t> occluded)
{
    for (std::size_t i = 0; i < rays.size(); i += kBatch) {
        const std::size_t n = std::min(kBatch, rays.size() - i);
        tracer.occluded(rays.subspan(i, n), occluded.subspan(i, n));
    }
}

std::vector<Vec3f> micropolygons(const lod::PosedCage& cage, int key)
{
    std::vector<Vec3f> corners;
    lod::Dicer dicer;
    Arena arena;
    const auto add_tile = [&](const lod::TileRef& tile) {
        arena.reset();
        const lod::LevelGrid grid = dicer.dice(cage.at_key(key), tile, arena);
        for (int j = 0; j < tile.rows; ++j)
            for (int i = 0; i < tile.columns; ++i)
                for (const auto& [di, dj] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}})
                    corners.push_back(grid.vertex(i + di, j + dj));
    };
    const auto add_patch = [&](lod::PatchRef patch) {
        const lod::PatchRates rates = dicer.scale(cage, patch).rates(cage.level);
        const int columns = 1 << rates.u, rows = 1 << rates.v, side = lod::TileRef::kMaxSide;
        const auto size = [&](int whole) { return static_cast<std::uint16_t>(std::min(whole, side)); };
        for (int j = 0; j < rows; j += side)
            for (int i = 0; i < columns; i += side)
                add_tile(
                    {patch, rates, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j), size(columns), size(rows)});
    };
    for (std::uint32_t face = 0; face < cage.topology->face_count(); ++face)
        for (std::uint32_t sub = 0; cage.topology->is_seen(face) && sub < cage.topology->patches_of(face); ++sub)
            add_patch({face, sub});
    return corners;
}

}  // namespace occam::bench
