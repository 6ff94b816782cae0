// The suite measures what light costs in whole frames, and whether it converges to the same picture with and without level
// of detail.

#include <cmath>

#include "api/include/occam/occam.h"
#include "render/compare.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

std::vector<MaterialId> materials_of(const Scene& scene)
{
    std::vector<MaterialId> all;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
        all.insert(all.end(), node.materials.begin(), node.materials.end());
        for (const CageId id : node.cages)
            if (const CageSlot* slot = scene.find(id))
                all.insert(all.end(), slot->cage.materials.begin(), slot->cage.materials.end());
    });
    std::erase_if(all, [&](MaterialId id) { return !scene.find(id); });
    return all;
}

// Removes textures but keeps factors, so that nearly the same rays are shot.
void strip_textures(Scene& scene)
{
    for (const MaterialId id : materials_of(scene)) {
        Material m = scene.material(id);
        for (TextureUse* use :
             {&m.base_color_texture, &m.metallic_roughness_texture, &m.roughness_texture, &m.metallic_texture,
              &m.emission_texture, &m.normal_texture, &m.bump_texture, &m.occlusion_texture, &m.alpha_texture,
              &m.transmission_texture, &m.clearcoat_texture, &m.clearcoat_roughness_texture, &m.clearcoat_normal_texture,
              &m.specular_texture, &m.specular_color_texture})
            use->texture = {};
        scene.replace(id, m);
    }
}

// Reports the CPU seconds of the stages, measured in turns with textures and without.
void run_shares(Report& report, const std::string& name, Scene with, Scene without)
{
    strip_textures(without);
    Settings settings{.width = 320, .height = 240, .spp = 16, .integrator = IntegratorKind::Path};
    Renderer renderers[] = {Renderer({.threads = 1}), Renderer({.threads = 1})};
    Scene* const scenes[] = {&with, &without};
    std::vector<double> shading, textures, rays;
    for (int run = 0; run < 4; ++run) {
        double shade[2] = {}, all = 0;
        for (int k : {0, 1}) {
            const Camera camera = scenes[k]->camera().value_or(Camera::framing(scenes[k]->bounds(), 4.0f / 3));
            renderers[k].render(*scenes[k], camera, settings);
            const FrameStats& stats = renderers[k].stats();
            const FrameStats::Seconds& s = stats.seconds;
            shade[k] = s.shade;
            if (k == 0) all = s.build + s.tessellate + s.trace + s.shade + s.film;
            if (k == 0 && run > 0) rays.push_back(1e-6 * double(stats.rays.total()) / all);
        }
        if (run == 0) continue;  // the first run makes what is kept from frame to frame
        shading.push_back(shade[0] / all);
        textures.push_back(std::max(0.0, shade[0] - shade[1]) / all);
    }
    Row row{"light", name + ", path, 16 samples"};
    row.add("shading_share_of_frame", shading).add("texture_share_of_frame", textures).add("mrays_per_s", rays);
    row.note = "textures: what shading takes less without them";
    report.add(std::move(row));
}

struct Effect {
    const char* name;
    IntegratorKind integrator;
    bool has_lamp;
    float roughness;
};
constexpr Effect kEffects[] = {{"soft shadow", IntegratorKind::Direct, true, 1},
                               {"ambient occlusion", IntegratorKind::Ao, false, 1},
                               {"glossy, roughness 0.3", IntegratorKind::Path, false, 0.3f}};

Scene stage_of(const Effect& effect, Cage thing)
{
    Scene scene;
    Material material;
    material.metallic = effect.has_lamp ? 0.0f : 1.0f;
    material.roughness = effect.roughness;
    Cage floor;
    floor.positions = {{-4, 0, -4}, {-4, 0, 4}, {4, 0, 4}, {4, 0, -4}};
    floor.face_vertices = {0, 1, 2, 3};
    floor.face_sizes = {4};
    floor.scheme = Scheme::Bilinear;
    floor.materials = thing.materials = {scene.add(material)};
    Box3d box;
    for (const Vec3f p : thing.positions) box.add(Vec3d(p));
    NodeDesc node;
    node.cages = {scene.add(std::move(floor))};
    scene.add_node(scene.root(), node);
    const double scale = 2 / std::max({box.extent().x, box.extent().y, box.extent().z});
    node.place.scale = Vec3d(scale);
    node.place.translation = -(box.lo + box.hi) * 0.5 * scale + Vec3d(0, box.extent().y * scale * 0.5 + 0.02, 0);
    node.cages = {scene.add(std::move(thing))};
    scene.add_node(scene.root(), node);
    if (!effect.has_lamp) {
        scene.environment.radiance = Vec3f(1);
        return scene;
    }
    NodeDesc lamp;
    lamp.place.translation = {1, 4, 1};
    lamp.place.rotation = {-0.7071067811865476, 0, 0, 0.7071067811865476};
    lamp.light = scene.add(Light{"lamp", AreaLight{AreaLight::Shape::Rectangle, Vec2f(2), Vec3f(6)}});
    scene.add_node(scene.root(), lamp);
    return scene;
}

// Returns the means over blocks of pixels. Comparing two seeds shows how much noise is left in them.
Image blocks(const Image& image)
{
    constexpr int kBlock = 4;
    const Layer& from = *image.find("beauty");
    Image out(image.width / kBlock, image.height / kBlock);
    Layer& to = out.add_layer("beauty", from.channels);
    for (int y = 0; y < out.height * kBlock; ++y)
        for (int x = 0; x < out.width * kBlock; ++x)
            for (std::size_t c = 0; c < 4; ++c)
                to.pixels[(std::size_t(y / kBlock) * std::size_t(out.width) + std::size_t(x / kBlock)) * 4 + c] +=
                    from.pixels[(std::size_t(y) * std::size_t(image.width) + std::size_t(x)) * 4 + c] / (kBlock * kBlock);
    return out;
}

void run_convergence(Report& report, const std::string& thing, const Cage& cage)
{
    for (const Effect& effect : kEffects) {
        Scene scene = stage_of(effect, cage);
        const Camera camera = Camera::look_at({2.5, 2.2, 4}, {0, 0.6, 0}, {0, 1, 0}, 0.7f);
        Renderer renderer;
        Settings settings{.width = 96, .height = 72, .spp = 256, .integrator = effect.integrator, .bounces = 4};
        const auto picture = [&](render::Lod lod, float rate, std::uint64_t seed) {
            settings.lod = lod;
            settings.shading_rate = rate;
            settings.seed = seed;
            return blocks(renderer.render(scene, camera, settings));
        };
        const Image reference = picture(render::Lod::Off, 0.25f, 0);
        Row row{"converge", thing + ", " + effect.name};
        for (const float rate : {4.0f, 2.0f, 1.0f, 0.5f}) {
            const std::string at = "_at_rate_" + std::to_string(rate).substr(0, 3);
            row.add("on_against_off" + at,
                    render::compare(picture(render::Lod::On, rate, 0), picture(render::Lod::Off, rate, 0), "beauty").rmse);
            row.add("on_against_fine" + at, render::compare(picture(render::Lod::On, rate, 0), reference, "beauty").rmse);
        }
        row.add("noise", render::compare(picture(render::Lod::Off, 0.25f, 1), reference, "beauty").rmse);
        row.note =
            "RMSE of means over 4 x 4 pixels, 256 samples each; fine: level of detail off at rate 0.25; noise: that with "
            "another seed";
        report.add(std::move(row));
    }
}

}  // namespace

void run_light_frames(Report& report)
{
    run_shares(report, "built-in scene", builtin_scene(), builtin_scene());
    const std::filesystem::path helmet = shared_folder() / "gltf/static/FlightHelmet/FlightHelmet.gltf";
    if (!std::filesystem::exists(helmet)) {
        report.add({"light", "FlightHelmet", {}, "skipped: no shared data (set OCCAM_SHARED)"});
        return;
    }
    run_shares(report, "FlightHelmet", load(helmet), load(helmet));
}

void run_converge(Report& report)
{
    run_convergence(report, "torus", torus(24, 12));
    if (std::optional<Cage> head = suzanne()) run_convergence(report, "suzanne", *head);
    else report.add({"converge", "suzanne", {}, "skipped: no shared data (set OCCAM_SHARED)"});
}

}  // namespace occam::bench
