#include "tests/support/random_look.h"

#include "tests/support/displaced_cages.h"

namespace occam::test {
namespace {

Texture noise_texture(CaseRandom& random, TextureRole role)
{
    Texture texture;
    texture.role = role;
    texture.width = texture.height = 16;
    for (int k = 0; k < 256; ++k) {
        const Vec3f color = random.color();
        texture.pixels.push_back(role == TextureRole::Data ? Vec4f(color.x, color.x, color.x, 1) : Vec4f(color, 1));
    }
    return texture;
}

/// Gives a mesh texture coordinates by its vertices' places, and a cage a chart for each face.
void add_coordinates(Cage& cage)
{
    if (cage.scheme != Scheme::Triangles) return add_charts(cage);
    UvSet uv;
    for (const Vec3f p : cage.positions) uv.values.push_back(Vec2f(p.x + 0.3f * p.z, p.y - 0.2f * p.z));
    cage.uv_sets = {std::move(uv)};
}

bool has_textures(const RandomPart& part)
{
    for (const PartFeature f : {PartFeature::Textured, PartFeature::Displaced, PartFeature::Holes, PartFeature::Veil,
                                PartFeature::Bumped, PartFeature::Strokes})
        if (part.has(f)) return true;
    return false;
}

void add_lobes(Material& material, const RandomCase& c, const RandomPart& part)
{
    if (part.has(PartFeature::Coated)) {
        CaseRandom random(c, part, PartFeature::Coated);
        material.clearcoat = float(random.number());
        material.clearcoat_roughness = float(random.number());
    }
    if (part.has(PartFeature::Sheen)) {
        CaseRandom random(c, part, PartFeature::Sheen);
        material.sheen_color = random.color();
        material.sheen_roughness = float(random.number());
    }
    if (part.has(PartFeature::Strokes)) {
        CaseRandom random(c, part, PartFeature::Strokes);
        material.anisotropy = float(random.number());
        material.anisotropy_rotation = float(random.between(0, 6));
    }
    if (part.has(PartFeature::Specular)) {
        CaseRandom random(c, part, PartFeature::Specular);
        material.specular = float(random.number());
        material.specular_color = random.color();
        material.ior = random.number() < 0.2 ? 0 : float(random.between(1, 2.5));
    }
    if (part.has(PartFeature::Body)) {
        CaseRandom random(c, part, PartFeature::Body);
        material.transmission = 1;
        material.thickness = 1;
        material.attenuation_color = random.color();
        material.attenuation_distance = float(random.between(0.1, 2));
    }
    if (part.has(PartFeature::Shining)) material.emission = CaseRandom(c, part, PartFeature::Shining).color() * 2.0f;
}

}  // namespace

Light random_light(CaseRandom& random)
{
    const Vec3f color = random.color();
    switch (random.index(6)) {
        case 0:
            return Light{"", PointLight{color}};
        case 1:
            return Light{"", PointLight{.intensity = color, .range = 4, .inner_angle = 0.2f, .outer_angle = 0.9f}};
        case 2:
            return Light{"", SunLight{color * 0.1f}};
        default:
            break;
    }
    AreaLight area;
    area.shape = static_cast<AreaLight::Shape>(random.index(3));
    const float width = float(random.between(0.05, 1));
    area.size = Vec2f(width, float(random.between(0.05, 1)));
    area.radiance = color;
    area.two_sided = random.number() < 0.3;
    return Light{"", area};
}

void paint(Cage& cage, Scene& scene, const RandomCase& c, const RandomPart& part)
{
    CaseRandom random(c, part, PartFeature::Metal);
    Material material;
    material.base_color = Vec4f(Vec3f(0.55 + 0.4 * random.inside_cube()), 1);
    material.roughness = float(random.number());
    material.double_sided = random.number() < 0.5;
    if (part.has(PartFeature::Metal)) material.metallic = 1;
    if (part.has(PartFeature::Glass)) material.transmission = 1;
    add_lobes(material, c, part);
    if (has_textures(part)) add_coordinates(cage);
    const auto texture_of = [&](PartFeature f, TextureRole role) {
        CaseRandom texels(c, part, f);
        return scene.add(noise_texture(texels, role));
    };
    if (part.has(PartFeature::Textured))
        material.base_color_texture.texture = texture_of(PartFeature::Textured, TextureRole::Color);
    if (part.has(PartFeature::Bumped)) {
        material.bump_texture.texture = texture_of(PartFeature::Bumped, TextureRole::Data);
        material.bump_scale = 0.02f;
    }
    if (part.has(PartFeature::Holes) || part.has(PartFeature::Veil)) {
        material.alpha_mode = part.has(PartFeature::Veil) ? AlphaMode::Blend : AlphaMode::Mask;
        material.alpha_texture.texture = texture_of(PartFeature::Holes, TextureRole::Data);
    }
    if (part.has(PartFeature::Displaced) && cage.scheme != Scheme::Triangles) {
        CaseRandom texels(c, part, PartFeature::Displaced);
        Displacement moves;
        moves.bound = float(cage.bounds().radius() * texels.between(0.005, 0.05));
        moves.scale = 2 * moves.bound;
        moves.texture.texture = scene.add(noise_texture(texels, TextureRole::Data));
        cage.displacement = moves;
    }
    cage.materials = {scene.add(material)};
}

void light(Scene& scene, const RandomCase& c, Vec3d origin)
{
    NodeDesc lamp;
    lamp.place.translation = origin + Vec3d(3, 6, 4);
    lamp.place.rotation = {-0.7071067811865476, 0, 0, 0.7071067811865476};
    lamp.light = scene.add(Light{"lamp", AreaLight{AreaLight::Shape::Rectangle, Vec2f(2), Vec3f(8)}});
    scene.add_node(scene.root(), lamp);
    if (c.has(SettingFeature::Lamps)) {
        CaseRandom random(c, SettingFeature::Lamps);
        for (std::size_t n = 1 + random.index(random.number() < 0.5 ? 4 : 90); n > 0; --n) {
            NodeDesc desc;
            desc.place.translation = origin + random.inside_cube() * 4.0;
            const double w = random.between(0.1, 1);
            desc.place.rotation = glm::normalize(Vec4d(random.inside_cube(), w));
            desc.light = scene.add(random_light(random));
            scene.add_node(scene.root(), desc);
        }
    }
    if (c.has(SettingFeature::Environment)) {
        CaseRandom random(c, SettingFeature::Environment);
        scene.environment.radiance = random.color();
        scene.environment.rotation = float(random.between(0, 6));
        Texture sky = noise_texture(random, TextureRole::Color);
        const float bright = float(random.between(1, 50));
        sky.pixels[random.index(sky.pixels.size())] = Vec4f(Vec3f(bright), 1);
        if (random.number() < 0.7) scene.environment.image = scene.add(std::move(sky));
    }
}

}  // namespace occam::test
