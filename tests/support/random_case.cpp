#include "tests/support/random_case.h"

#include <array>
#include <map>

#include "base/hash.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/made_cages.h"

namespace occam::test {
namespace {

constexpr const char* kPartNames[kPartFeatures] = {"noise",     "creases",   "corners",  "hole",     "fin",       "bilinear",
                                                   "triangles", "displaced", "skinned",  "mirrored", "stretched", "large",
                                                   "small",     "instanced", "textured", "glass",    "metal",     "holes"};
constexpr const char* kSettingNames[kSettingFeatures] = {"path",   "ao",       "vertices", "frozen",       "lod-off",
                                                         "coarse", "fine",     "lens",     "orthographic", "far",
                                                         "still",  "adaptive", "cropped",  "one-sided",    "layers"};

/// Generates the random numbers of one feature of one part, which are the same whatever else the case has.
class Random {
public:
    Random(std::uint64_t seed, std::uint64_t key, std::uint64_t feature)
        : state_(mix_bits(seed * 0x9e3779b97f4a7c15ull + key * 1009 + feature * 31 + 7))
    {
    }
    Random(const RandomCase& c, const RandomPart& part, PartFeature f)
        : Random(c.seed, part.key, static_cast<std::uint64_t>(f) + 100)
    {
    }
    /// Returns a number that is uniform in [0, 1).
    double number() { return double(mix_bits(state_ += 0x9e3779b97f4a7c15ull) >> 11) * 0x1p-53; }
    double between(double lo, double hi) { return lo + (hi - lo) * number(); }
    std::size_t index(std::size_t count) { return std::min(count - 1, static_cast<std::size_t>(number() * double(count))); }
    Vec3d inside_cube()
    {
        const double x = between(-1, 1), y = between(-1, 1);
        return {x, y, between(-1, 1)};
    }

private:
    std::uint64_t state_;
};

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
        Random random(c, part, PartFeature::Noise);
        const double size = random.between(0, 0.08) * cage.bounds().radius();
        for (Vec3f& p : cage.positions) p += Vec3f(random.inside_cube() * size);
    }
    if (part.has(PartFeature::Creases)) {
        Random random(c, part, PartFeature::Creases);
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
        Random random(c, part, PartFeature::Corners);
        cage.corners.clear();
        for (std::size_t n = 1 + random.index(3); n > 0; --n)
            cage.corners.push_back(
                {static_cast<std::uint32_t>(random.index(cage.positions.size())), 0.25f * float(1 + random.index(40))});
    }
    if (part.has(PartFeature::Hole))
        cage.holes = {static_cast<std::uint32_t>(Random(c, part, PartFeature::Hole).index(cage.face_sizes.size()))};
    if (part.has(PartFeature::Fin)) {
        cage.positions.push_back(cage.positions[cage.face_vertices[0]] * 1.7f);
        cage.face_sizes.push_back(3);
        cage.face_vertices.insert(cage.face_vertices.end(), {cage.face_vertices[0], cage.face_vertices[1],
                                                             static_cast<std::uint32_t>(cage.positions.size() - 1)});
    }
    if (part.has(PartFeature::Bilinear)) cage.scheme = Scheme::Bilinear;
}

Texture noise_texture(Random& random, TextureRole role)
{
    Texture texture;
    texture.role = role;
    texture.width = texture.height = 16;
    for (int k = 0; k < 256; ++k) {
        const Vec3f color(0.5 + 0.5 * random.inside_cube());
        texture.pixels.push_back(role == TextureRole::Data ? Vec4f(color.x, color.x, color.x, 1) : Vec4f(color, 1));
    }
    return texture;
}

void paint(Cage& cage, Scene& scene, const RandomCase& c, const RandomPart& part)
{
    Random random(c, part, PartFeature::Metal);
    Material material;
    material.base_color = Vec4f(Vec3f(0.55 + 0.4 * random.inside_cube()), 1);
    material.roughness = float(random.number());
    if (part.has(PartFeature::Metal)) material.metallic = 1;
    if (part.has(PartFeature::Glass)) material.transmission = 1;
    if (part.has(PartFeature::Textured) || part.has(PartFeature::Displaced) || part.has(PartFeature::Holes))
        add_charts(cage);
    if (part.has(PartFeature::Textured)) {
        Random texels(c, part, PartFeature::Textured);
        material.base_color_texture.texture = scene.add(noise_texture(texels, TextureRole::Color));
    }
    if (part.has(PartFeature::Holes)) {
        Random texels(c, part, PartFeature::Holes);
        material.alpha_mode = AlphaMode::Mask;
        material.alpha_texture.texture = scene.add(noise_texture(texels, TextureRole::Data));
    }
    if (part.has(PartFeature::Displaced)) {
        Random texels(c, part, PartFeature::Displaced);
        Displacement moves;
        moves.bound = float(cage.bounds().radius() * texels.between(0.005, 0.05));
        moves.scale = 2 * moves.bound;
        moves.texture.texture = scene.add(noise_texture(texels, TextureRole::Data));
        cage.displacement = moves;
    }
    cage.materials = {scene.add(material)};
}

Mat4d place_of(const RandomCase& c, const RandomPart& part)
{
    Random random(c.seed, part.key, 1);
    // Compilers evaluate arguments in any order.
    const double w = random.between(0.1, 1);
    const Vec4d turn = glm::normalize(Vec4d(random.inside_cube(), w));
    double scale = random.between(0.4, 1.2);
    Vec3d at = random.inside_cube() * 2.0;
    if (part.has(PartFeature::Large)) scale *= 1000, at = at * 1000.0 - Vec3d(0, 0, 5000);
    if (part.has(PartFeature::Small)) scale *= 0.001;
    if (c.has(SettingFeature::Far)) at += Vec3d(1e5, -3e4, 7e4);
    Trs place;
    place.translation = at;
    place.rotation = turn;
    place.scale = Vec3d(scale);
    if (part.has(PartFeature::Stretched)) place.scale = place.scale * Vec3d(1, 0.3, 1.9);
    if (part.has(PartFeature::Mirrored)) place.scale.x = -place.scale.x;
    return place.matrix();
}

void add_part(Scene& scene, const RandomCase& c, const RandomPart& part)
{
    Cage cage = made_cage(part.cage);
    shape(cage, c, part);
    cage.name = part.cage + std::to_string(part.key);
    if (part.has(PartFeature::Skinned)) add_skin(cage);
    if (part.has(PartFeature::Triangles)) make_triangles(cage);
    else paint(cage, scene, c, part);
    const Mat4d place = place_of(c, part);
    NodeDesc desc;
    desc.name = cage.name;
    desc.matrix = place;
    if (part.has(PartFeature::Skinned) && !part.has(PartFeature::Triangles)) {
        Skin skin;
        for (const Mat4d& joint : bent_joints()) {
            NodeDesc bone;
            bone.matrix = place * joint;
            skin.joints.push_back(scene.add_node(scene.root(), bone));
        }
        desc.skin = scene.add(skin);
    }
    desc.cages = {scene.add(std::move(cage))};
    const NodeId node = scene.add_node(scene.root(), desc);
    for (int k = 0; part.has(PartFeature::Instanced) && k < 3; ++k) {
        NodeDesc copy;
        copy.instance_of = node;
        copy.matrix = place;
        (*copy.matrix)[3] += place[static_cast<int>(k)] * 2.5;
        scene.add_node(scene.root(), copy);
    }
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
unsigned random_bits(Random& random, unsigned count, std::size_t one_in)
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
    Random random(seed, 0, 0);
    c.settings = random_bits(random, kSettingFeatures, 5);
    const std::vector<MadeCage> cages = made_cages();
    for (std::uint32_t key = 1, count = 1 + static_cast<std::uint32_t>(random.index(4)); key <= count; ++key)
        c.parts.push_back({key, random_bits(random, kPartFeatures, 6), cages[random.index(cages.size())].name});
    return c;
}

Scene scene_of(const RandomCase& c)
{
    Scene scene;
    for (const RandomPart& part : c.parts) add_part(scene, c, part);
    NodeDesc lamp;
    lamp.place.translation = {3, 6, 4};
    if (c.has(SettingFeature::Far)) lamp.place.translation += Vec3d(1e5, -3e4, 7e4);
    lamp.place.rotation = {-0.7071067811865476, 0, 0, 0.7071067811865476};
    lamp.light = scene.add(Light{"lamp", AreaLight{AreaLight::Shape::Rectangle, Vec2f(2), Vec3f(8)}});
    scene.add_node(scene.root(), lamp);
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
            if (row.aov != Aov::Motion) s.aovs |= row.aov;  // motion needs a shutter that is open
    s.seed = c.seed;
    return s;
}

Camera camera_of(const RandomCase& c, Scene& scene)
{
    const Vec3d about = c.has(SettingFeature::Far) ? Vec3d(1e5, -3e4, 7e4) : Vec3d(0);
    Random random(c.seed, 0, 2);
    const double up = random.between(0, 3), right = random.between(-4, 4);
    Camera camera = Camera::look_at(about + Vec3d(right, up, 7), about, {0, 1, 0}, 0.9f);
    if (c.has(SettingFeature::Orthographic)) camera.lens.orthographic = true, camera.lens.height = 6;
    if (c.has(SettingFeature::Lens)) camera.lens.radius = 0.15f, camera.lens.focus = 6;
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
    std::uint64_t expected = 0;
    for (const auto& [name, resources] :
         {std::pair("one thread", Resources{.threads = 1, .memory_bytes = 256u << 20}),
          std::pair("three threads", Resources{.threads = 3, .memory_bytes = 256u << 20}),
          std::pair("three threads and one tree", Resources{.threads = 3, .memory_bytes = 256u << 20, .workers_a_tree = 0}),
          std::pair("little memory", Resources{.threads = 2})}) {
        Resources these = resources;
        if (these.memory_bytes == 0) these.memory_bytes = 4 * Renderer({.threads = these.threads}).memory_floor(scene);
        Renderer renderer(these);
        const Image image = renderer.render(scene, camera, settings);
        if (renderer.stats().image.samples_not_finite > 0)
            return std::string(name) + ": " + std::to_string(renderer.stats().image.samples_not_finite) +
                   " samples are not finite";
        if (expected == 0) expected = image.checksum();
        if (image.checksum() != expected) return std::string(name) + ": the picture differs from that of one thread";
    }
    return {};
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
