#include "tests/support/textured_floor.h"

#include <cmath>

#include "render/compare.h"
#include "tests/support/shape_builders.h"

namespace occam::test {

Texture waves(float phase)
{
    return texture_of([&](float x, float y) {
        const float a = 6.2831853f / kTexels;
        return Vec4f(0.5f + 0.4f * std::sin(a * x * 3 + phase), 0.5f + 0.4f * std::sin(a * y * 2 + phase),
                     0.5f + 0.3f * std::sin(a * (x + y)), 1);
    });
}

Cage floor_of(MaterialId material, Scheme scheme)
{
    Cage cage;
    UvSet uv;
    for (int j = 0; j <= 4; ++j)
        for (int i = 0; i <= 4; ++i) {
            cage.positions.push_back({float(i - 2), 0, float(j - 2)});
            uv.values.push_back(Vec2f(float(i), float(j)) * 0.25f);
        }
    for (std::uint32_t j = 0; j < 4; ++j)
        for (std::uint32_t i = 0; i < 4; ++i) {
            const std::uint32_t a = j * 5 + i, b = a + 5, c = b + 1, d = a + 1;
            if (scheme == Scheme::Triangles) {
                cage.face_vertices.insert(cage.face_vertices.end(), {a, b, c, a, c, d});
            } else {
                cage.face_vertices.insert(cage.face_vertices.end(), {a, b, c, d});
                cage.face_sizes.push_back(4);
            }
        }
    cage.uv_sets = {uv};
    cage.scheme = scheme;
    cage.materials = {material};
    return cage;
}

TexturedFloor::TexturedFloor(Scheme scheme, const std::function<Material(Scene&)>& make)
{
    material = make(scene);
    place(scene, scene.add(floor_of(scene.add(material), scheme)), {0, 0, 0});
    NodeDesc lamp;
    lamp.place.translation = {1, 3, 1};
    lamp.light = scene.add(Light{"lamp", PointLight{Vec3f(30)}});
    scene.add_node(scene.root(), lamp);
}

Image TexturedFloor::picture(Settings settings)
{
    settings.width = 96;
    settings.height = 72;
    settings.spp = 4;
    settings.background = false;
    Job job = renderer.start(scene, Camera::look_at({0, 2.5, 3}, {0, 0, 0}, {0, 1, 0}, 0.9f), settings);
    const Image image = job.image();
    stats = job.stats();
    return image;
}

Image TexturedFloor::picture(render::ShadeAt at, float rate) { return picture({.shading_rate = rate, .shade_at = at}); }

double TexturedFloor::difference(float rate)
{
    return render::compare(picture(render::ShadeAt::Vertex, rate), picture(render::ShadeAt::Hit, rate), "beauty").rmse;
}

namespace {

// Returns the scene, once it is ready to be rendered with these textures.
const Scene& prepared(Scene& scene, TextureStore& textures)
{
    scene.refit();
    textures.prepare(scene);
    return scene;
}

}  // namespace

FloorTracer::FloorTracer(Scene& scene, bool at_vertices)
    : phase_one(textures),
      frame(prepared(scene, textures), topologies, {.pixel = {0, 0.01f}},
            {.textures = &textures, .shading = {at_vertices ? &phase_one : nullptr, 1}}),
      tracer(frame, std::size_t(1) << 28)
{
}

}  // namespace occam::test
