#include "tests/support/random_case.h"

#include "tests/support/case_random.h"
#include "tests/support/made_cages.h"
#include "tests/support/random_look.h"
#include "tests/support/random_parts.h"

namespace occam::test {
namespace {

constexpr const char* kPartNames[kPartFeatures] = {
    "noise",    "creases",   "corners", "hole",  "fin",       "bilinear", "triangles", "displaced", "skinned",
    "mirrored", "stretched", "large",   "small", "instanced", "textured", "glass",     "metal",     "holes",
    "veil",     "bumped",    "coated",  "sheen", "strokes",   "specular", "body",      "shining",   "moving"};
constexpr const char* kSettingNames[kSettingFeatures] = {
    "path",    "ao",       "vertices", "frozen",  "lod-off",   "coarse", "fine", "lens",  "orthographic",
    "far",     "still",    "adaptive", "cropped", "one-sided", "layers", "sky",  "lamps", "light-samples",
    "clamped", "filtered", "rounds",   "shutter", "swarm"};

template <std::size_t N>
std::string names_of(unsigned bits, const char* const (&names)[N])
{
    std::string text;
    for (std::size_t k = 0; k < N; ++k)
        if (bits >> k & 1) text += std::string(" ") + names[k];
    return text;
}

/// Returns bits of which each is set with a chance of one in `one_in`.
unsigned random_bits(CaseRandom& random, unsigned count, std::size_t one_in)
{
    unsigned bits = 0;
    for (unsigned k = 0; k < count; ++k) bits |= unsigned(random.index(one_in) == 0) << k;
    return bits;
}

}  // namespace

bool is_hopeless(const Error& e)
{
    return std::string_view(e.what()).find("so this would not end") != std::string_view::npos;
}

RandomCase random_case(std::uint64_t seed)
{
    RandomCase c;
    c.seed = seed;
    CaseRandom random(seed, 0, 0);
    c.settings = random_bits(random, kSettingFeatures, 5);
    const std::vector<MadeCage> cages = made_cages();
    for (std::uint32_t key = 1, count = 1 + static_cast<std::uint32_t>(random.index(4)); key <= count; ++key)
        c.parts.push_back({key, random_bits(random, kPartFeatures, 6), cages[random.index(cages.size())].name});
    return c;
}

Scene scene_of(const RandomCase& c)
{
    Scene scene;
    std::vector<AddedPart> added;
    for (const RandomPart& part : c.parts) added.push_back(add_part(scene, c, part));
    light(scene, c, origin_of(c));
    if (c.has(SettingFeature::Shutter)) {
        CaseRandom random(c, SettingFeature::Shutter);
        scene.record_shutter(1 << random.index(6), [&](double tau) {
            for (const AddedPart& a : added) {
                if (a.part.has(PartFeature::Moving)) move_part(scene, c, a, tau);
                move_swarm(scene, c, a, tau);
            }
        });
    }
    return scene;
}

Settings settings_of(const RandomCase& c)
{
    Settings s{.width = 48, .height = 32, .spp = 2};
    if (c.has(SettingFeature::Ao)) s.integrator = IntegratorKind::Ao;
    if (c.has(SettingFeature::Path)) s.integrator = IntegratorKind::Path;
    s.bounces = 3;
    if (c.has(SettingFeature::AtVertices)) s.shade_at = render::ShadeAt::Vertex;
    if (c.has(SettingFeature::Frozen)) s.lod = render::Lod::Frozen;
    if (c.has(SettingFeature::LodOff)) s.lod = render::Lod::Off;
    if (c.has(SettingFeature::Fine)) s.shading_rate = 0.5f;
    if (c.has(SettingFeature::Coarse)) s.shading_rate = 3;
    if (c.has(SettingFeature::Still)) s.jitter = false;
    if (c.has(SettingFeature::Adaptive)) s.error = 0.1f, s.spp = 16, s.min_spp = 4;
    if (c.has(SettingFeature::Cropped)) s.crop_x0 = 0.2f, s.crop_x1 = 0.7f, s.crop_y1 = 0.55f;
    if (c.has(SettingFeature::OneSided)) s.back_faces = false;
    if (c.has(SettingFeature::Layers))
        for (const render::AovRow& row : render::kAovs)
            if (row.aov != Aov::Motion || c.has(SettingFeature::Shutter)) s.aovs |= row.aov;
    if (c.has(SettingFeature::LightSamples)) s.light_samples = 3;
    if (c.has(SettingFeature::Clamped)) s.clamp = 2;
    if (c.has(SettingFeature::Filtered)) s.filter = render::FilterKind::BlackmanHarris;
    if (c.has(SettingFeature::Rounds)) s.progressive = true;
    if (c.has(SettingFeature::Shutter)) s.shutter = {0, 0.5};
    s.seed = c.seed;
    return s;
}

Camera camera_of(const RandomCase& c, Scene& scene)
{
    const Vec3d about = origin_of(c);
    CaseRandom random(c.seed, 0, 2);
    const double up = random.between(0, 3), right = random.between(-4, 4);
    Camera camera = Camera::look_at(about + Vec3d(right, up, 7), about, {0, 1, 0}, 0.9f);
    if (c.has(SettingFeature::Orthographic)) camera.lens.orthographic = true, camera.lens.height = 6;
    if (c.has(SettingFeature::Lens)) camera.lens.radius = 0.15f, camera.lens.focus = 6;
    if (c.has(SettingFeature::Shutter))
        for (const double tau : {0.0, 0.5, 1.0}) {
            camera.keys.push_back(camera.world_from_camera);
            camera.keys.back()[3] += Vec4d(0.1 * tau, 0.1 * tau * tau, 0, 0);
        }
    scene.refit();
    return camera;
}

std::string description(const RandomCase& c)
{
    std::string text = "seed " + std::to_string(c.seed) + ", settings:" + names_of(c.settings, kSettingNames);
    for (const RandomPart& part : c.parts)
        text += "; part " + std::to_string(part.key) + " " + part.cage + ":" + names_of(part.features, kPartNames);
    return text;
}

RandomCase shrunk(RandomCase failing, const CaseCheck& check)
{
    const auto still_fails = [&](const RandomCase& smaller) {
        if (check(smaller).empty()) return false;
        failing = smaller;
        return true;
    };
    for (bool is_smaller = true; is_smaller;) {
        is_smaller = false;
        for (std::size_t p = failing.parts.size(); p-- > 0 && failing.parts.size() > 1;) {
            RandomCase less = failing;
            less.parts.erase(less.parts.begin() + static_cast<std::ptrdiff_t>(p));
            is_smaller |= still_fails(less);
        }
        for (unsigned bit = 0; bit < kSettingFeatures; ++bit) {
            RandomCase less = failing;
            less.settings &= ~(1u << bit);
            if (less.settings != failing.settings) is_smaller |= still_fails(less);
        }
        for (std::size_t p = 0; p < failing.parts.size(); ++p)
            for (unsigned bit = 0; bit < kPartFeatures; ++bit) {
                RandomCase less = failing;
                less.parts[p].features &= ~(1u << bit);
                if (less.parts[p].features != failing.parts[p].features) is_smaller |= still_fails(less);
            }
    }
    return failing;
}

std::string check_pictures(const RandomCase& c)
try {
    Scene scene = scene_of(c);
    const Camera camera = camera_of(c, scene);
    const Settings settings = settings_of(c);
    std::uint64_t expected = 0, micropolygons = 0;
    std::size_t used = 0;
    const auto fault_of = [&](const char* name, const Resources& resources) -> std::string {
        Renderer renderer(resources);
        const Image image = renderer.render(scene, camera, settings);
        const FrameStats& stats = renderer.stats();
        if (stats.image.samples_not_finite > 0)
            return std::string(name) + ": " + std::to_string(stats.image.samples_not_finite) + " samples are not finite";
        if (expected == 0) {
            expected = image.checksum();
            used = stats.memory.arena_peak_bytes;
            micropolygons = stats.built.micropolygons;
        }
        if (image.checksum() == expected) return {};
        return std::string(name) + ": the picture differs from that of one thread";
    };
    constexpr std::size_t kEnough = 256u << 20;
    constexpr std::uint64_t kTooMany = 5'000'000;  // the cases with more take minutes, so they are rendered only once
    // In a kd-tree a moving part takes up all the space that it passes through. Where that surrounds the camera, memory does
    // not suffice (docs/motion.md).
    const TreeKind kd = c.has(SettingFeature::Shutter) ? TreeKind::Auto : TreeKind::Kd;
    for (const auto& [name, resources] :
         {std::pair("one thread", Resources{.threads = 1, .memory_bytes = kEnough}),
          std::pair("three threads, kd-trees", Resources{.threads = 3, .memory_bytes = 3 * kEnough, .tree = kd}),
          std::pair("three threads, one tree of boxes",
                    Resources{.threads = 3, .memory_bytes = kEnough, .workers_a_tree = 0, .tree = TreeKind::Bvh})})
        if (std::string fault = fault_of(name, resources); !fault.empty() || micropolygons > kTooMany) return fault;
    const std::size_t least = 4 * Renderer({.threads = 2}).memory_floor(scene);
    return fault_of("little memory", {.threads = 2, .memory_bytes = std::max(least, used)});
} catch (const Error& e) {
    if (is_hopeless(e)) return {};
    throw;
}

std::string check_closedness(const RandomCase& c, std::uint64_t rays, Tested* tested)
try {
    RandomCase without_swarm = c;  // its forty instances of each part are the same cages again
    without_swarm.remove(SettingFeature::Swarm);
    Scene scene = scene_of(without_swarm);
    VerifySettings settings;
    settings.rays = rays;
    settings.seed = c.seed;
    settings.largest_rate = 8;
    for (const VerifiedCage& found : verify(scene, settings)) {
        if (tested) {
            tested->cages += found.rays > 0;
            tested->rays += found.rays;
        }
        if (!found.holds())
            return found.node + ": " + std::to_string(found.escaped) + " of " + std::to_string(found.rays) +
                   " rays escape, " + std::to_string(found.not_finite) + " hits are not finite" +
                   (found.replay.empty() ? "" : "; " + found.replay.front());
    }
    return {};
} catch (const Error& e) {
    if (!is_hopeless(e)) throw;
    if (tested) ++tested->hopeless;
    return {};
}

}  // namespace occam::test
