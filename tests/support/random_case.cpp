#include "tests/support/random_case.h"

#include <array>
#include <map>

#include "tests/support/case_random.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/made_cages.h"
#include "tests/support/random_look.h"

namespace occam::test {
namespace {

constexpr const char* kPartNames[kPartFeatures] = {
    "noise",    "creases",   "corners", "hole",  "fin",       "bilinear", "triangles", "displaced", "skinned",
    "mirrored", "stretched", "large",   "small", "instanced", "textured", "glass",     "metal",     "holes",
    "veil",     "bumped",    "coated",  "sheen", "strokes",   "specular", "body",      "shining",   "moving"};
constexpr const char* kSettingNames[kSettingFeatures] = {
    "path",    "ao",       "vertices", "frozen",  "lod-off",   "coarse", "fine", "lens",  "orthographic",
    "far",     "still",    "adaptive", "cropped", "one-sided", "layers", "sky",  "lamps", "light-samples",
    "clamped", "filtered", "rounds",   "shutter"};

/// Triangulates every face as a fan; the result is a mesh, which is rendered as it is.
void make_triangles(Cage& cage)
{
    std::vector<std::uint32_t> corners;
    std::size_t first = 0;
    for (const std::uint32_t size : cage.face_sizes) {
        for (std::uint32_t i = 2; i < size; ++i)
            for (const std::uint32_t k : {0u, i - 1, i}) corners.push_back(cage.face_vertices[first + k]);
        first += size;
    }
    Cage triangles;
    triangles.scheme = Scheme::Triangles;
    triangles.name = cage.name;
    triangles.positions = cage.positions;
    triangles.face_vertices = corners;
    cage = std::move(triangles);
}

void shape(Cage& cage, const RandomCase& c, const RandomPart& part)
{
    if (part.has(PartFeature::Noise)) {
        CaseRandom random(c, part, PartFeature::Noise);
        const double size = random.between(0, 0.08) * cage.bounds().radius();
        for (Vec3f& p : cage.positions) p += Vec3f(random.inside_cube() * size);
    }
    if (part.has(PartFeature::Creases)) {
        CaseRandom random(c, part, PartFeature::Creases);
        const double share = random.number();
        std::size_t first = 0;
        cage.creases.clear();
        for (const std::uint32_t size : cage.face_sizes) {
            for (std::uint32_t i = 0; i < size; ++i)
                if (cage.face_vertices[first + i] < cage.face_vertices[first + (i + 1) % size] && random.number() < share)
                    cage.creases.push_back({cage.face_vertices[first + i], cage.face_vertices[first + (i + 1) % size],
                                            0.25f * float(1 + random.index(40))});
            first += size;
        }
    }
    if (part.has(PartFeature::Corners)) {
        CaseRandom random(c, part, PartFeature::Corners);
        cage.corners.clear();
        for (std::size_t n = 1 + random.index(3); n > 0; --n)
            cage.corners.push_back(
                {static_cast<std::uint32_t>(random.index(cage.positions.size())), 0.25f * float(1 + random.index(40))});
    }
    if (part.has(PartFeature::Hole))
        cage.holes = {static_cast<std::uint32_t>(CaseRandom(c, part, PartFeature::Hole).index(cage.face_sizes.size()))};
    if (part.has(PartFeature::Fin)) {
        cage.positions.push_back(cage.positions[cage.face_vertices[0]] * 1.7f);
        cage.face_sizes.push_back(3);
        cage.face_vertices.insert(cage.face_vertices.end(), {cage.face_vertices[0], cage.face_vertices[1],
                                                             static_cast<std::uint32_t>(cage.positions.size() - 1)});
    }
    if (part.has(PartFeature::Bilinear)) cage.scheme = Scheme::Bilinear;
}

/// Returns the middle of the world of a case.
Vec3d origin_of(const RandomCase& c) { return c.has(SettingFeature::Far) ? Vec3d(1e5, -3e4, 7e4) : Vec3d(0); }

Mat4d place_of(const RandomCase& c, const RandomPart& part)
{
    CaseRandom random(c.seed, part.key, 1);
    // Compilers evaluate arguments in any order.
    const double w = random.between(0.1, 1);
    const Vec4d turn = glm::normalize(Vec4d(random.inside_cube(), w));
    double scale = random.between(0.4, 1.2);
    Vec3d at = random.inside_cube() * 2.0;
    if (part.has(PartFeature::Large)) scale *= 1000, at = at * 1000.0 - Vec3d(0, 0, 5000);
    if (part.has(PartFeature::Small)) scale *= 0.001;
    at += origin_of(c);
    Trs place;
    place.translation = at;
    place.rotation = turn;
    place.scale = Vec3d(scale);
    if (part.has(PartFeature::Stretched)) place.scale = place.scale * Vec3d(1, 0.3, 1.9);
    if (part.has(PartFeature::Mirrored)) place.scale.x = -place.scale.x;
    return place.matrix();
}

/// Holds what of an added part may move.
struct AddedPart {
    const RandomPart* part;
    NodeId node, joint;  ///< joint: the one that bends it, if it is skinned
    CageId cage;
    Mat4d place;
};

AddedPart add_part(Scene& scene, const RandomCase& c, const RandomPart& part)
{
    Cage cage = made_cage(part.cage);
    shape(cage, c, part);
    cage.name = part.cage + std::to_string(part.key);
    if (part.has(PartFeature::Skinned)) add_skin(cage);
    if (part.has(PartFeature::Triangles)) make_triangles(cage);
    paint(cage, scene, c, part);
    AddedPart added{.part = &part, .node = {}, .joint = {}, .cage = {}, .place = place_of(c, part)};
    NodeDesc desc;
    desc.name = cage.name;
    desc.matrix = added.place;
    if (part.has(PartFeature::Skinned) && !part.has(PartFeature::Triangles)) {
        Skin skin;
        for (const Mat4d& joint : bent_joints()) {
            NodeDesc bone;
            bone.matrix = added.place * joint;
            skin.joints.push_back(scene.add_node(scene.root(), bone));
        }
        added.joint = skin.joints.back();
        desc.skin = scene.add(skin);
    }
    added.cage = scene.add(std::move(cage));
    desc.cages = {added.cage};
    added.node = scene.add_node(scene.root(), desc);
    for (int k = 0; part.has(PartFeature::Instanced) && k < 3; ++k) {
        NodeDesc copy;
        copy.instance_of = added.node;
        copy.matrix = added.place;
        (*copy.matrix)[3] += added.place[static_cast<int>(k)] * 2.5;
        scene.add_node(scene.root(), copy);
    }
    return added;
}

/// Moves a part to where it is at a moment of the shutter, in one of several ways.
void move_part(Scene& scene, const RandomCase& c, const AddedPart& added, double tau)
{
    CaseRandom random(c, *added.part, PartFeature::Moving);
    const std::size_t kind = random.index(added.joint ? 6 : 7);  // vertices that follow joints are not written
    const Vec3d way = random.inside_cube();
    Trs trs;
    switch (kind) {
        case 0:
            trs.translation = way * tau;
            break;
        case 1:
            trs.rotation = glm::normalize(Vec4d(way * tau, 1));
            break;
        case 2:
            trs.scale = Vec3d(1 - 0.9 * tau) + Vec3d(0, 0.3 * tau, 0);
            break;
        case 3:
            trs.translation = way * (20 * tau);
            break;
        case 4:
            trs.scale = Vec3d(1, 1 - 2 * tau, 1);
            break;
        case 5:
            scene.set_visible(added.node, tau < 0.5);
            return;
        default:
            break;
    }
    if (kind != 6) return scene.set_transform(added.joint ? added.joint : added.node, added.place * trs.matrix());
    std::vector<Vec3f> bent;
    for (const Vec3f p : made_cage(added.part->cage).positions)
        bent.push_back(p + Vec3f(way * (0.5 * tau)) * (p.x * p.x + p.y));
    bent.resize(scene.cage(added.cage).cage.positions.size(), Vec3f(0.1f, 1.2f, 0.3f));  // a fin has one more vertex
    scene.write_vertices(added.cage, bent);
}

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
        scene.record_shutter(1 << random.index(4), [&](double tau) {
            for (const AddedPart& a : added)
                if (a.part->has(PartFeature::Moving)) move_part(scene, c, a, tau);
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
    if (c.has(SettingFeature::Adaptive)) s.error = 0.1f, s.spp = 16;
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
{
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
    constexpr std::uint64_t kTooMany = 5'000'000;  // a large body seen closely takes minutes, and is only rendered once
    // In a kd-tree what moves is wherever it is at some time. Where that is around the camera, memory ends.
    const TreeKind kd = c.has(SettingFeature::Shutter) ? TreeKind::Auto : TreeKind::Kd;
    for (const auto& [name, resources] :
         {std::pair("one thread", Resources{.threads = 1, .memory_bytes = kEnough}),
          std::pair("three threads, kd-trees", Resources{.threads = 3, .memory_bytes = 3 * kEnough, .tree = kd}),
          std::pair("three threads, one tree of boxes",
                    Resources{.threads = 3, .memory_bytes = kEnough, .workers_a_tree = 0, .tree = TreeKind::Bvh})})
        if (std::string fault = fault_of(name, resources); !fault.empty() || micropolygons > kTooMany) return fault;
    const std::size_t least = 4 * Renderer({.threads = 2}).memory_floor(scene);
    return fault_of("little memory", {.threads = 2, .memory_bytes = std::max(least, used)});
}

std::string check_closedness(const RandomCase& c, std::uint64_t rays, Tested* tested)
{
    Scene scene = scene_of(c);
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
}

}  // namespace occam::test
