// The suite measures what a level of detail for each ray costs and saves, compared with one level for each cage, and with
// secondary rays that keep the level of their origin. The scenes are like those of Djeu et al. 2011, fig. 12 (soft shadow of
// a large, finely tessellated wall off screen) and fig. 15 (glossy throughout).

#include <array>
#include <cmath>

#include "api/include/occam/occam.h"
#include "render/compare.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

using render::Lod;

/// Makes a sheet of columns x rows quads in the plane y = 0, with bumps.
Cage sheet(int columns, int rows, float width, float depth, float bump)
{
    Cage cage;
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            const float x = (float(i) / float(columns) - 0.5f) * width, z = (float(j) / float(rows) - 0.5f) * depth;
            cage.positions.push_back({x, bump * std::sin(2.1f * x) * std::cos(1.7f * z), z});
        }
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const auto at = static_cast<std::uint32_t>(j * (columns + 1) + i),
                       up = at + static_cast<std::uint32_t>(columns + 1);
            cage.face_vertices.insert(cage.face_vertices.end(), {at, up, up + 1, at + 1});
            cage.face_sizes.push_back(4);
        }
    return cage;
}

struct Stage {
    Scene scene;
    Camera camera = Camera::look_at({0, 3, 9}, {0, 0.6, 0}, {0, 1, 0}, 0.7f);
};

Vec4d about_x(double angle) { return {std::sin(angle / 2), 0, 0, std::cos(angle / 2)}; }

void put(Scene& scene, CageId cage, Vec3d at, double scale, double lean = 0)
{
    NodeDesc desc;
    desc.place.translation = at;
    desc.place.scale = Vec3d(scale);
    desc.place.rotation = about_x(lean);
    desc.cages = {cage};
    scene.add_node(scene.root(), std::move(desc));
}

void put_things(Scene& scene, MaterialId material)
{
    Cage floor = sheet(8, 8, 24, 24, 0), ring = torus(24, 12);
    floor.materials = ring.materials = {material};
    put(scene, scene.add(std::move(floor)), {0, 0, 0}, 1);
    const CageId id = scene.add(std::move(ring));
    for (int i = 0; i < 5; ++i) put(scene, id, {2.2 * (i - 2), 0.8, 0.7 * (i % 2)}, 0.8, 0.5 * i);
}

/// Makes a scene with a square light high up. A wall that leans over the objects, out of the camera's sight, stands between
/// the light and them.
Stage behind_a_wall()
{
    Stage stage;
    put_things(stage.scene, stage.scene.add(Material{}));
    put(stage.scene, stage.scene.add(sheet(40, 40, 40, 40, 0.15f)), {21, 7, 4}, 1, 0.05);
    AreaLight light;
    light.size = Vec2f(26);
    light.radiance = {6, 5.6f, 5.2f};
    NodeDesc desc;
    desc.place.translation = {2, 24, 4};
    desc.place.rotation = about_x(-1.5707963267948966);  // its -z axis points down
    desc.light = stage.scene.add(Light{"lamp", light});
    stage.scene.add_node(stage.scene.root(), std::move(desc));
    return stage;
}

Stage glossy()
{
    Stage stage;
    Material metal;
    metal.metallic = 1;
    metal.roughness = 0.35f;
    metal.base_color = {0.9f, 0.8f, 0.7f, 1};
    const MaterialId id = stage.scene.add(metal);
    put_things(stage.scene, id);
    Cage back = sheet(120, 120, 30, 30, 0.2f);
    back.materials = {id};
    put(stage.scene, stage.scene.add(std::move(back)), {0, 8, -12}, 1, 1.5707963267948966);
    return stage;
}

struct Made {
    std::vector<double> wall, cpu;
    Image image;
    FrameStats stats;
};

/// Measures the three ways in turns.
void run_stage(Report& report, const std::string& name, Stage stage, Settings settings)
{
    constexpr int kRuns = 3;
    constexpr std::array<Lod, 3> kWays{Lod::On, Lod::Frozen, Lod::Off};
    constexpr const char* kNames[] = {"on", "frozen", "off"};
    std::array<Made, 3> made;
    std::array<Renderer, 3> renderers;
    for (int run = 0; run < kRuns; ++run)
        for (std::size_t w = 0; w < 3; ++w) {
            settings.lod = kWays[w];
            const double wall = wall_seconds(), cpu = process_seconds();
            made[w].image = renderers[w].render(stage.scene, stage.camera, settings);
            made[w].wall.push_back(wall_seconds() - wall);
            made[w].cpu.push_back(process_seconds() - cpu);
            made[w].stats = renderers[w].stats();
        }
    settings.lod = Lod::On;
    settings.seed = 1;
    const Image other = renderers[0].render(stage.scene, stage.camera, settings);
    Row noise{"levels", name + ", on against another seed"};
    noise.add("rmse", render::compare(other, made[0].image, "beauty").rmse);
    report.add(std::move(noise));
    for (std::size_t w = 0; w < 3; ++w) {
        const FrameStats& stats = made[w].stats;
        Row row{"levels", name + ", " + kNames[w]};
        row.add("cpu_s", made[w].cpu).add("wall_s", made[w].wall);
        row.add("cpu_over_on", ratios(made[w].cpu, made[0].cpu));
        row.add("arena_mb", 1e-6 * double(stats.memory.arena_peak_bytes));
        row.add("arena_over_on", double(stats.memory.arena_peak_bytes) / double(made[0].stats.memory.arena_peak_bytes));
        row.add("micropolygons", double(stats.built.micropolygons)).add("rays", double(stats.rays.total()));
        if (w > 0) row.add("rmse_from_on", render::compare(made[w].image, made[0].image, "beauty").rmse);
        report.add(std::move(row));
    }
}

/// Compares rays of one width, half way between two levels, with rays that all see the finer level, which shows what
/// blending costs. With a width at which nothing changes any more it shows what it costs to be ready to blend.
void run_kernel(Report& report, const std::string& name, float width, std::string note)
{
    Scene scene;
    scene.add_node(scene.root(), {.cages = {scene.add(torus(24, 12))}});
    scene.refit();
    lod::TopologyCache topologies;
    lod::LevelSettings levels{.eye = {0, 4, 0.1}, .pixel = {width, 0}};
    const accel::Frame on(scene, topologies, levels);
    levels.mode = lod::LevelMode::PerInstance;
    const accel::Frame off(scene, topologies, levels);
    accel::Tracer with(on, std::size_t(4) << 30), without(off, std::size_t(4) << 30);

    std::vector<accel::Ray> rays;
    constexpr int kSide = 512;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            accel::Ray ray;
            ray.origin = levels.eye;
            ray.direction = Vec3f(glm::normalize(Vec3d((x + 0.5) / kSide - 0.5, -1.2, (y + 0.5) / kSide - 0.5)));
            ray.footprint = levels.pixel;
            rays.push_back(ray);
        }
    std::vector<std::uint8_t> found(rays.size());
    trace_occluded(with, rays, found);
    trace_occluded(without, rays, found);
    std::vector<double> a, b;
    for (int run = 0; run < 9; ++run) {
        double start = thread_seconds();
        trace_occluded(with, rays, found);
        a.push_back(thread_seconds() - start);
        start = thread_seconds();
        trace_occluded(without, rays, found);
        b.push_back(thread_seconds() - start);
    }
    Row row{"levels", name};
    row.add("on_over_off", ratios(a, b));
    row.add("on_mrays_per_s", per(1e-6 * double(rays.size()), a)).add("off_mrays_per_s", per(1e-6 * double(rays.size()), b));
    row.add("micropolygons_on", double(with.counters().micropolygons))
        .add("micropolygons_off", double(without.counters().micropolygons));
    row.note = std::move(note);
    report.add(std::move(row));
}

}  // namespace

void run_levels(Report& report)
{
    run_kernel(report, "every ray blends", 0x1p-6f, "any hit; each ray half way between two levels");
    run_kernel(report, "nothing to blend", 8, "any hit; all rates are 1, fine and coarse are the same");
    run_stage(report, "wall off screen", behind_a_wall(), {.width = 480, .height = 270, .spp = 4, .light_samples = 4});
    Settings settings{.width = 480, .height = 270, .spp = 8};
    settings.integrator = render::IntegratorKind::Path;
    settings.bounces = 2;
    run_stage(report, "glossy", glossy(), settings);
}

}  // namespace occam::bench
