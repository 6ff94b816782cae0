// The suite compares materials that are looked up once at the vertices of grids with materials that are looked up at every
// hit (Djeu et al. 2011, sec. 5.3 and 6.5): the number of lookups, their time and their error, for several shading rates and
// numbers of samples a pixel.
//
// The error is the RMSE of the picture against one with many samples at hits, at the same shading rate, so that geometry has
// no part in it. There is one light without size, so pictures differ only in textures and at the edges of objects.
//
// Seconds are those of one thread. At vertices they are the additional time of phase one, the time by which interpolation
// makes hits on built trees slower, and the time to read the values at hits; at hits they are the time to look values up and
// to read them. Whole frames are beside them.

#include <cmath>

#include "api/include/occam/occam.h"
#include "base/hash.h"
#include "render/camera_rays.h"
#include "render/compare.h"
#include "render/sampler.h"
#include "render/shade_point.h"
#include "shade/material_values.h"
#include "shade/surface.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kWidth = 256, kHeight = 192, kRuns = 5, kManySamples = 36, kReferenceSamples = 256;
constexpr std::size_t kMemoryBytes = std::size_t(2) << 30;
constexpr double kNever = 1e30;

float hashed(std::uint32_t x, std::uint32_t y, std::uint32_t seed)
{
    return float(mix_bits(std::uint64_t(seed) << 40 ^ std::uint64_t(x) << 20 ^ y) >> 40) * 0x1p-24f;
}

/// Returns repeating octaves of noise about one half, each with half the strength of the next coarser one.
Texture noise(std::uint32_t seed)
{
    constexpr int kSide = 1024, kOctaves = 7;
    Texture texture;
    texture.width = texture.height = kSide;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            Vec4f sum(0.5f, 0.5f, 0.5f, 1);
            for (int octave = 2; octave < 2 + kOctaves; ++octave) {
                const std::uint32_t cells = 1u << octave;
                const float s = float(x) * float(cells) / kSide, t = float(y) * float(cells) / kSide;
                const auto i = static_cast<std::uint32_t>(s), j = static_cast<std::uint32_t>(t);
                const float u = s - float(i), v = t - float(j);
                for (std::uint32_t c = 0; c < 3; ++c) {
                    const auto at = [&](std::uint32_t p, std::uint32_t q) {
                        return hashed(p % cells, q % cells, seed * 64 + std::uint32_t(octave) * 4 + c);
                    };
                    const float low = at(i, j) * (1 - u) + at(i + 1, j) * u,
                                high = at(i, j + 1) * (1 - u) + at(i + 1, j + 1) * u;
                    sum[static_cast<int>(c)] += (low * (1 - v) + high * v - 0.5f) * std::ldexp(1.2f, 1 - octave);
                }
            }
            texture.pixels.push_back(glm::clamp(sum, Vec4f(0.02f), Vec4f(1)));
        }
    return texture;
}

/// Returns a normal map of noise with little slope.
Texture bumps(std::uint32_t seed)
{
    Texture texture = noise(seed);
    for (Vec4f& p : texture.pixels)
        p = Vec4f(Vec3f(glm::normalize(Vec3f((p.x - 0.5f) * 0.6f, (p.y - 0.5f) * 0.6f, 1))) * 0.5f + 0.5f, 1);
    return texture;
}

/// Returns a material with the first `maps` of these maps: base colour, roughness and metallic, normals, emission, specular,
/// heights.
Material mapped(Scene& scene, int maps)
{
    Material m;
    m.roughness = 0.9f;
    if (maps > 0) m.base_color_texture.texture = scene.add(noise(1));
    if (maps > 1) m.metallic_roughness_texture.texture = scene.add(noise(2)), m.metallic = 0.3f;
    if (maps > 2) m.normal_texture.texture = scene.add(bumps(3));
    if (maps > 3) m.emission_texture.texture = scene.add(noise(4)), m.emission = Vec3f(0.05f);
    if (maps > 4) m.specular_texture.texture = scene.add(noise(5));
    if (maps > 5) m.bump_texture.texture = scene.add(noise(6)), m.bump_scale = 0.01f;
    return m;
}

/// Returns columns x rows quads with coordinates from 0 to `repeats`; place(i, j) gives the position of a corner. Sides that
/// are closed share vertices.
template <class Place>
Cage sheet_of(std::uint32_t columns, std::uint32_t rows, bool closes, Vec2f repeats, Place&& place)
{
    Cage cage;
    UvSet uv;
    const std::uint32_t width = closes ? columns : columns + 1, height = closes ? rows : rows + 1;
    for (std::uint32_t j = 0; j < height; ++j)
        for (std::uint32_t i = 0; i < width; ++i) cage.positions.push_back(place(i, j));
    for (std::uint32_t j = 0; j <= rows; ++j)
        for (std::uint32_t i = 0; i <= columns; ++i)
            uv.values.push_back(repeats * Vec2f(float(i) / float(columns), float(j) / float(rows)));
    for (std::uint32_t j = 0; j < rows; ++j)
        for (std::uint32_t i = 0; i < columns; ++i) {
            for (const auto& [di, dj] : {std::pair(0u, 0u), {0u, 1u}, {1u, 1u}, {1u, 0u}}) {
                cage.face_vertices.push_back((j + dj) % height * width + (i + di) % width);
                uv.indices.push_back((j + dj) * (columns + 1) + i + di);
            }
            cage.face_sizes.push_back(4);
        }
    cage.uv_sets = {std::move(uv)};
    return cage;
}

struct Stage {
    Scene scene;
    Camera camera = Camera::look_at({0, 2.2, 4.2}, {0, 0.2, 0}, {0, 1, 0}, 0.75f);
};

/// Makes a floor and three rings, all of one material.
Stage stage_of(int maps)
{
    Stage stage;
    Scene& scene = stage.scene;
    const MaterialId material = scene.add(mapped(scene, maps));
    Cage floor = sheet_of(6, 6, false, Vec2f(3),
                          [](std::uint32_t i, std::uint32_t j) { return Vec3f(2 * float(i) - 6, 0, 2 * float(j) - 8); });
    floor.scheme = Scheme::Bilinear;
    Cage ring = sheet_of(16, 8, true, Vec2f(3, 1), [](std::uint32_t i, std::uint32_t j) {
        const double a = 0.39269908169872414 * i, b = 0.7853981633974483 * j, r = 1 + 0.4 * std::cos(b);
        return Vec3f(float(r * std::cos(a)), float(0.4 * std::sin(b)), float(r * std::sin(a)));
    });
    floor.materials = ring.materials = {material};
    NodeDesc node;
    node.cages = {scene.add(std::move(floor))};
    scene.add_node(scene.root(), node);
    node.cages = {scene.add(std::move(ring))};
    for (const Vec3d at : {Vec3d(-1.5, 0.4, -0.5), Vec3d(1.5, 0.4, -1), Vec3d(0.2, 0.4, 1.3)}) {
        node.place.translation = at;
        node.place.scale = Vec3d(0.9);
        scene.add_node(scene.root(), node);
    }
    NodeDesc lamp;
    lamp.place.translation = {2, 5, 3};
    lamp.light = scene.add(Light{"lamp", PointLight{Vec3f(60)}});
    scene.add_node(scene.root(), lamp);
    scene.refit();
    return stage;
}

/// Returns camera rays as a frame shoots them: tile by tile, with the samples of a pixel together.
std::vector<accel::Ray> camera_rays(const Stage& stage, int samples)
{
    constexpr int kTile = 16;
    const render::CameraRays camera(stage.camera, kWidth, kHeight);
    const render::Sampler sampler(0, samples, true);
    std::vector<accel::Ray> rays;
    for (int y0 = 0; y0 < kHeight; y0 += kTile)
        for (int x0 = 0; x0 < kWidth; x0 += kTile)
            for (int y = y0; y < y0 + kTile; ++y)
                for (int x = x0; x < x0 + kTile; ++x)
                    for (int s = 0; s < samples; ++s) {
                        const Vec2f at = sampler.in_pixel(x, y, s);
                        rays.push_back(camera.ray(x + double(at.x), y + double(at.y)));
                    }
    return rays;
}

struct Seconds {
    double trace = 0, evaluate = 0;
};

/// Finds all hits and begins to shade them, batch by batch.
Seconds look_at(accel::Tracer& tracer, std::span<const accel::Ray> rays, float texture_width, const TextureStore& textures,
                std::uint64_t& hit_count)
{
    Seconds seconds;
    std::vector<accel::SurfaceHit> hits(kBatch);
    float sum = 0;
    hit_count = 0;
    for (std::size_t first = 0; first < rays.size(); first += kBatch) {
        const std::span<const accel::Ray> batch = rays.subspan(first, std::min(kBatch, rays.size() - first));
        double start = thread_seconds();
        tracer.closest(batch, {hits.data(), batch.size()});
        seconds.trace += thread_seconds() - start;
        start = thread_seconds();
        for (std::size_t i = 0; i < batch.size(); ++i) {
            if (!hits[i].is_hit()) continue;
            sum += shade::evaluate(render::shade_point(batch[i], hits[i], texture_width), textures).base_color.x;
            ++hit_count;
        }
        seconds.evaluate += thread_seconds() - start;
    }
    if (!(sum >= 0)) hit_count = 0;
    return seconds;
}

/// Holds the costs of both ways. Seconds are the least of all runs, since phase one is timed by the wall clock.
struct Costs {
    double vertices = 0, hits = 0;
    double phase_one = kNever, interpolation = 0, reading = kNever, looking_up = kNever;
    double at_vertices() const { return phase_one + interpolation + reading; }
};

/// Returns what it costs to look materials up for a frame's camera rays, in both ways.
Costs costs_of(Stage& stage, const TextureStore& textures, int samples, float rate)
{
    lod::TopologyCache topologies;
    const lod::LevelSettings levels = render::CameraRays(stage.camera, kWidth, kHeight).levels(rate);
    const float texture_width = render::sample_width(samples);
    const shade::PhaseOne phase_one(textures);
    const accel::Frame without(stage.scene, topologies, levels, {.textures = &textures}),
        with(stage.scene, topologies, levels, {.textures = &textures, .shading = {&phase_one, texture_width}});
    const std::vector<accel::Ray> rays = camera_rays(stage, samples);
    Costs costs;
    double made[2] = {kNever, kNever}, traced[2] = {kNever, kNever};
    for (int run = 0; run < kRuns; ++run) {
        accel::Tracer plain(without, kMemoryBytes), shading(with, kMemoryBytes);
        accel::Tracer* const tracers[] = {&plain, &shading};
        std::uint64_t hits;
        for (accel::Tracer* tracer : tracers)
            look_at(*tracer, rays, texture_width, textures, hits);  // this builds everything that is lazy
        for (const int way : {0, 1}) {
            const Seconds hot = look_at(*tracers[way], rays, texture_width, textures, hits);
            made[way] = std::min(made[way], tracers[way]->counters().shade_seconds);
            traced[way] = std::min(traced[way], hot.trace);
            double& reads = way ? costs.reading : costs.looking_up;
            reads = std::min(reads, hot.evaluate);
        }
        costs.vertices = double(shading.counters().vertices_looked_up);
        costs.hits = double(hits);
    }
    costs.phase_one = made[1] - made[0];
    costs.interpolation = std::max(0.0, traced[1] - traced[0]);
    return costs;
}

Row& add_costs(Row& row, const Costs& costs)
{
    row.add("vertices", costs.vertices).add("hits", costs.hits).add("vertices_over_hits", costs.vertices / costs.hits);
    row.add("phase_one_ns_a_vertex", 1e9 * costs.phase_one / costs.vertices);
    row.add("interpolation_ns_a_hit", 1e9 * costs.interpolation / costs.hits);
    row.add("evaluate_ns_a_hit_with_values", 1e9 * costs.reading / costs.hits);
    row.add("evaluate_ns_a_hit_looking_up", 1e9 * costs.looking_up / costs.hits);
    row.add("at_vertices_s", costs.at_vertices()).add("at_hits_s", costs.looking_up);
    return row.add("vertices_over_hits_s", costs.at_vertices() / costs.looking_up);
}

void add_frames(Row& row, Stage& stage, int samples, float rate)
{
    Renderer renderer({.threads = 1}), many;
    Settings settings{.width = kWidth,
                      .height = kHeight,
                      .spp = kReferenceSamples,
                      .integrator = IntegratorKind::Direct,
                      .shading_rate = rate};
    settings.seed = 1;
    const Image reference = many.render(stage.scene, stage.camera, settings);
    settings.seed = 0;
    settings.spp = samples;
    std::vector<double> seconds[2];
    double error[2] = {};
    for (int run = 0; run < kRuns; ++run)
        for (const int way : {0, 1}) {
            settings.shade_at = way ? render::ShadeAt::Hit : render::ShadeAt::Vertex;
            const double start = process_seconds();
            const Image image = renderer.render(stage.scene, stage.camera, settings);
            seconds[way].push_back(process_seconds() - start);
            error[way] = render::compare(image, reference, "beauty").rmse;
        }
    row.add("frame_vertices_over_hits_s", ratios(seconds[0], seconds[1]));
    row.add("rmse_vertices", error[0]).add("rmse_hits", error[1]);
}

void run_rates(Report& report)
{
    Stage stage = stage_of(3);
    TextureStore textures(std::size_t(1) << 30);
    textures.prepare(stage.scene);
    for (const float rate : {0.5f, 1.0f, 2.0f, 4.0f}) {
        Row row{"shade", "3 maps, 36 samples, rate " + std::to_string(rate).substr(0, 3)};
        if (!report.wants(row.name)) continue;
        add_costs(row, costs_of(stage, textures, kManySamples, rate));
        add_frames(row, stage, kManySamples, rate);
        report.add(std::move(row));
    }
}

/// Finds the number of samples a pixel from which on vertices are cheaper, which is where phase one costs what it saves at
/// hits. A vertex costs the same for any number of samples, and so does a hit, so the least figure of each is taken.
void run_crossover(Report& report)
{
    Stage stage = stage_of(3);
    TextureStore textures(std::size_t(1) << 30);
    textures.prepare(stage.scene);
    for (const float rate : {0.5f, 1.0f, 2.0f}) {
        const std::string name = "3 maps, rate " + std::to_string(rate).substr(0, 3);
        if (!report.wants(name)) continue;
        double vertices = 0, hits = 0, vertex = kNever, saved = 0;
        for (const int samples : {1, 2, 4, 8, 16, 36}) {
            Row row{"shade", name + ", samples " + std::to_string(samples)};
            const Costs costs = costs_of(stage, textures, samples, rate);
            report.add(std::move(add_costs(row, costs)));
            vertex = std::min(vertex, costs.phase_one / costs.vertices);
            saved = std::max(saved, (costs.looking_up - costs.reading - costs.interpolation) / costs.hits);
            if (samples == 4) vertices = costs.vertices, hits = costs.hits / samples;
        }
        Row row{"shade", name + ", crossover"};
        row.add("samples_a_pixel", vertices * vertex / (hits * saved)).add("vertices_a_sample_of_hits", vertices / hits);
        row.add("phase_one_ns_a_vertex", 1e9 * vertex).add("saved_ns_a_hit", 1e9 * saved);
        report.add(std::move(row));
    }
}

void run_maps(Report& report)
{
    constexpr int kSide = 9, kTiles = 64;
    for (int maps = 0; maps <= 6; ++maps) {
        if (!report.wants(std::to_string(maps) + " maps")) continue;
        Scene scene;
        const Material material = mapped(scene, maps);
        TextureStore textures(std::size_t(1) << 30);
        textures.prepare(scene);
        const shade::PhaseOne phase_one(textures);
        // The tiles lie beside each other in the texture, with vertices two texels apart.
        std::vector<lod::VertexToShade> vertices;
        constexpr float kStep = 2.0f / 1024;
        for (int tile = 0; tile < kTiles; ++tile)
            for (int j = 0; j < kSide; ++j)
                for (int i = 0; i < kSide; ++i)
                    vertices.push_back(
                        {{Vec2f(float(tile % 8 * (kSide - 1) + i) * kStep, float(tile / 8 * (kSide - 1) + j) * kStep)},
                         {kStep * 0.9f}});
        std::vector<float> out(vertices.size() * lod::VertexShader::kMaxChannels);
        const double each = 1e9 / double(vertices.size());
        const auto shade_all = [&] {
            constexpr std::size_t kVertices = kSide * kSide;
            for (std::size_t first = 0; first < vertices.size(); first += kVertices) {
                const lod::LatticeToShade lattice{std::span(vertices).subspan(first, kVertices), kSide};
                phase_one.shade(material, lattice, &out[first * static_cast<std::size_t>(phase_one.channels(material))]);
            }
        };
        shade::ShadePoint point;
        point.material = &material;
        point.axes.along = {1, 0, 0};
        float sum = 0;
        const auto evaluate_all = [&](const float* made) {
            for (const lod::VertexToShade& at : vertices) {
                point.texture = at;
                point.phase_one = made;
                sum += shade::evaluate(point, textures).base_color.x;
            }
        };
        shade_all();
        Row row{"shade", std::to_string(maps) + " maps"};
        row.add("phase_one_ns_a_vertex", times(repeat(9, shade_all), each));
        row.add("evaluate_ns_a_hit_looking_up", times(repeat(9, [&] { evaluate_all(nullptr); }), each));
        row.add("evaluate_ns_a_hit_with_values", times(repeat(9, [&] { evaluate_all(out.data()); }), each));
        row.add("floats_a_vertex", phase_one.channels(material));
        if (!(sum >= 0)) row.note = "not a number";
        report.add(std::move(row));
    }
}

}  // namespace

void run_shade(Report& report)
{
    run_maps(report);
    run_crossover(report);
    run_rates(report);
}

}  // namespace occam::bench
