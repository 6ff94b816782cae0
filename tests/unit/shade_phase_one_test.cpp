// Tests of materials that are looked up at the vertices of grids: the surface is the same as with lookups at hits where
// textures are smooth, it never pops, and only values that may be interpolated are made at vertices.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cmath>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "shade/bump.h"
#include "shade/material_values.h"
#include "shade/surface.h"
#include "tests/support/textured_floor.h"

namespace occam::test {
namespace {

Texture checks()
{
    return texture_of(
        [](float x, float y) { return int(x / 8 + std::floor(y / 8)) % 2 ? Vec4f(1) : Vec4f(0.2f, 0.2f, 0.2f, 0); });
}

/// Returns a material with a map for every value that may have one.
Material all_maps(Scene& scene)
{
    Material m;
    float phase = 0;
    for (TextureUse* use :
         {&m.base_color_texture, &m.metallic_roughness_texture, &m.emission_texture, &m.specular_texture,
          &m.specular_color_texture, &m.transmission_texture, &m.clearcoat_texture, &m.clearcoat_roughness_texture})
        use->texture = scene.add(waves(phase++));
    const Texture flat = texture_of([](float x, float) { return Vec4f(0.5f + 0.1f * std::sin(0.2f * x), 0.5f, 1, 1); });
    m.normal_texture.texture = m.clearcoat_normal_texture.texture = scene.add(flat);
    m.bump_texture.texture = m.occlusion_texture.texture = scene.add(waves(phase));
    m.bump_scale = 0.05f;
    m.emission = Vec3f(0.3f);
    m.metallic = 0.5f;
    m.transmission = m.clearcoat = 0.5f;
    m.clearcoat_roughness = 0.4f;
    return m;
}

// Adds the maps that change the picture most, so that other tests do without them.
Material every_map(Scene& scene)
{
    Material m = all_maps(scene);
    m.alpha_mode = AlphaMode::Blend;
    m.sheen_color = Vec3f(0.2f);
    m.sheen_roughness = m.anisotropy = 0.5f;
    for (TextureUse* use : {&m.alpha_texture, &m.sheen_color_texture, &m.sheen_roughness_texture, &m.anisotropy_texture})
        use->texture = m.base_color_texture.texture;
    return m;
}

TEST(PhaseOne, PacksWhatHasAMapAndGivesItBack)
{
    Scene scene;
    const Material m = every_map(scene);
    TextureStore textures(std::size_t(1) << 24);
    textures.prepare(scene);
    const shade::PhaseOne phase_one(textures);
    // There are two by two vertices, and the test checks the first.
    const lod::VertexToShade at{{Vec2f(0.3f, 0.6f), Vec2f(0)}, {0.01f, 0}};
    std::vector<lod::VertexToShade> vertices(4, at);
    vertices[1].uv[0].x = vertices[3].uv[0].x = 0.31f;
    vertices[2].uv[0].y = vertices[3].uv[0].y = 0.61f;
    const lod::LatticeToShade lattice{vertices, 2};
    float floats[4 * lod::VertexShader::kMaxChannels] = {};
    ASSERT_LE(phase_one.channels(m), lod::VertexShader::kMaxChannels);
    EXPECT_EQ(phase_one.channels(m), lod::VertexShader::kMaxChannels);
    phase_one.shade(m, lattice, floats);
    shade::MaterialValues made(m);
    made.look_up_color(m, at, textures);
    made.look_up_rest(m, at, textures);
    made.look_up_occlusion(m, at, textures);
    const shade::MaterialValues back = shade::unpack(m, floats);
    for (int c = 0; c < 4; ++c) EXPECT_FLOAT_EQ(back.base_color[c], made.base_color[c]) << "weighted by alpha in between";
    EXPECT_EQ(back.metallic, made.metallic);
    EXPECT_EQ(back.roughness, made.roughness);
    EXPECT_EQ(back.emission, made.emission);
    EXPECT_EQ(back.normal, made.normal);
    EXPECT_EQ(back.rise, shade::BumpLattice(m, lattice, textures).rise(0, 0));
    EXPECT_NE(back.rise, Vec2f(0));
    EXPECT_EQ(back.occlusion, made.occlusion);
    EXPECT_LT(back.occlusion, 1);
    EXPECT_EQ(back.alpha, made.alpha);
    EXPECT_EQ(back.sheen_color, made.sheen_color);
    EXPECT_EQ(back.sheen_roughness, made.sheen_roughness);
    EXPECT_EQ(back.anisotropy, made.anisotropy);
    EXPECT_EQ(back.specular, made.specular);
    EXPECT_EQ(back.specular_color, made.specular_color);
    EXPECT_EQ(back.transmission, made.transmission);
    EXPECT_EQ(back.coat, made.coat);
    EXPECT_EQ(back.coat_roughness, made.coat_roughness);
    EXPECT_EQ(back.coat_normal, made.coat_normal);

    Material plain;
    EXPECT_EQ(phase_one.channels(plain), 0);
    plain.base_color_texture = m.base_color_texture;
    EXPECT_EQ(phase_one.channels(plain), 4);
    plain.alpha_mode = AlphaMode::Mask;
    EXPECT_EQ(phase_one.channels(plain), 0) << "a mask's edge is a hit's own";
}

// Normal maps of a surface and of its coat: x and y are scaled before the vector is made a unit vector (glTF 2.0,
// sec. 3.9.3).
TEST(PhaseOne, NormalMapsOfSurfaceAndCoatAreScaled)
{
    Scene scene;
    const Texture slanted = texture_of([](float, float) { return Vec4f(0.8f, 0.5f, 0.9f, 1); });
    Material m;
    m.specular = 0;
    m.clearcoat = 1;
    m.normal_texture.texture = m.clearcoat_normal_texture.texture = scene.add(slanted);
    TextureStore textures(1 << 24);
    textures.prepare(scene);
    for (const float scale : {0.0f, 0.5f, 1.0f}) {
        m.normal_scale = scale;
        m.clearcoat_normal_scale = 1 - scale;
        shade::ShadePoint p;
        p.material = &m;
        p.axes.along = {1, 0, 0};
        const shade::Surface s = shade::evaluate(p, textures);
        const auto expect = [](Vec3f normal, float by) {
            const Vec3f wanted = glm::normalize(Vec3f(0.6f * by, 0, 0.8f));
            EXPECT_NEAR(normal.x, wanted.x, 1e-3f) << by;
            EXPECT_NEAR(normal.z, wanted.z, 1e-3f) << by;
        };
        expect(s.normal, scale);
        expect(s.coat_normal, 1 - scale);
    }
}

TEST(PhaseOne, ConvergesToWhatHitsLookUpAsVerticesComeCloser)
{
    TexturedFloor world(Scheme::Bilinear, all_maps);
    const double coarse = world.difference(8), middle = world.difference(2), fine = world.difference(0.5f);
    EXPECT_LT(middle, 0.5 * coarse);
    EXPECT_LT(fine, 0.5 * middle);
    EXPECT_LT(fine, 2e-3);
    world.picture(render::ShadeAt::Vertex, 2);
    EXPECT_EQ(world.stats.built.hits_looked_up, 0u);
    EXPECT_GT(world.stats.built.vertices_looked_up, 0u);
    EXPECT_LT(world.stats.built.vertices_looked_up, std::uint64_t(96 * 72 * 4) / 4);
}

TEST(PhaseOne, OfTriangleMeshesIsDoneAtHits)
{
    TexturedFloor world(Scheme::Triangles, all_maps);
    EXPECT_EQ(world.picture(render::ShadeAt::Vertex).checksum(), world.picture(render::ShadeAt::Hit).checksum());
}

TEST(PhaseOne, LeavesTheEdgesOfMasksToHits)
{
    TexturedFloor world(Scheme::Bilinear, [](Scene& scene) {
        Material m;
        m.base_color_texture.texture = scene.add(checks());
        m.metallic_roughness_texture.texture = scene.add(waves(0));
        m.alpha_mode = AlphaMode::Mask;
        return m;
    });
    const Image at_vertices = world.picture(render::ShadeAt::Vertex, 4), at_hits = world.picture(render::ShadeAt::Hit, 4);
    const auto &a = at_vertices.find("beauty")->pixels, &b = at_hits.find("beauty")->pixels;
    std::size_t covered = 0;
    for (std::size_t p = 3; p < a.size(); p += 4) {
        ASSERT_EQ(a[p], b[p]);
        covered += a[p] > 0 && a[p] < 1;
    }
    EXPECT_GT(covered, 50u);
    EXPECT_GT(world.stats.built.hits_looked_up, 0u);
}

/// A strip stays a row of quads at the coarsest level, so one igrid serves all coarse pairs. What a ray finds in it must not
/// depend on which of them asked for it first.
TEST(PhaseOne, DoesNotDependOnWhichRayCameFirst)
{
    Scene scene;
    Material m;
    m.base_color_texture.texture = scene.add(waves(0));
    Cage cage;
    cage.positions = {{-32, 0, 0.5f}, {32, 0, 0.5f}, {32, 0, -0.5f}, {-32, 0, -0.5f}};
    cage.face_sizes = {4};
    cage.face_vertices = {0, 1, 2, 3};
    cage.scheme = Scheme::Bilinear;
    cage.uv_sets.resize(1);
    for (const Vec3f p : cage.positions) cage.uv_sets[0].values.push_back({3 * p.x, 3 * p.z});
    cage.materials = {scene.add(m)};
    scene.add_node(scene.root(), {.cages = {scene.add(cage)}});
    scene.refit();
    TextureStore textures(std::size_t(1) << 24);
    textures.prepare(scene);
    const shade::PhaseOne phase_one(textures);
    lod::TopologyCache topologies;
    const accel::Frame frame(scene, topologies, {.pixel = {0.01f, 0}}, {.textures = &textures, .shading = {&phase_one, 1}});
    accel::Ray ray;
    ray.origin = {0.31, 1, 0.17};
    ray.direction = {0, -1, 0};
    const auto hit_after = [&](std::vector<float> widths) {
        accel::Tracer tracer(frame, std::size_t(1) << 26);
        accel::SurfaceHit hit;
        for (const float width : widths) {
            ray.footprint = {width, 0};
            tracer.closest({&ray, 1}, {&hit, 1});
        }
        return hit;
    };
    for (const float width : {0.1f, 0.3f, 0.6f, 1.0f, 2.0f, 4.0f, 20.0f}) {
        const accel::SurfaceHit alone = hit_after({width});
        for (const float other : {0.5f, 1.0f, 3.0f, 10.0f, 100.0f}) {
            const accel::SurfaceHit later = hit_after({other, width});
            ASSERT_TRUE(alone.is_hit() && later.is_hit());
            EXPECT_EQ(alone.level, later.level) << width << " after " << other;
            ASSERT_EQ(alone.phase_one_channels, later.phase_one_channels) << width << " after " << other;
            for (int c = 0; c < alone.phase_one_channels; ++c)
                EXPECT_EQ(alone.phase_one[c], later.phase_one[c]) << width << " after " << other;
        }
    }
}

// A ray's origin moves back by a hundredth of its distance at a time, from where vertices are closer than texels to where a
// face is one quad. Values go over from level to level, and from the last of them to lookups at hits. Each time the distance
// doubles, a value may go through its whole range by a smoothstep, whose steepest slope is 1.5, so the bound is 0.8 * 1.5 *
// log2(1.01) = 0.017.
TEST(PhaseOne, DoesNotPopFromLevelToLevel)
{
    TexturedFloor world(Scheme::Bilinear, [](Scene& scene) {
        Material m;
        m.base_color_texture.texture = scene.add(waves(0));
        return m;
    });
    world.scene.refit();
    TextureStore textures(std::size_t(1) << 24);
    textures.prepare(world.scene);
    const shade::PhaseOne phase_one(textures);
    lod::TopologyCache topologies;
    const accel::Frame frame(world.scene, topologies, {.pixel = {0, 0.01f}},
                             {.textures = &textures, .shading = {&phase_one, 1}});
    accel::Tracer tracer(frame, std::size_t(1) << 28);
    constexpr int kPlaces = 40;
    std::vector<accel::Ray> rays(kPlaces);
    std::vector<accel::SurfaceHit> before(kPlaces), hits(kPlaces);
    int changes = 0;
    float farthest = 0;
    for (double distance = 0.5; distance < 30; distance *= 1.01) {
        for (int k = 0; k < kPlaces; ++k) {
            rays[std::size_t(k)].origin = {-1.9 + 0.0971 * k, distance, 1.83 - 0.0873 * k};
            rays[std::size_t(k)].direction = {0, -1, 0};
            rays[std::size_t(k)].footprint = {0, 0.01f};
        }
        tracer.closest(rays, hits);
        for (std::size_t k = 0; k < kPlaces; ++k) {
            ASSERT_TRUE(hits[k].is_hit());
            ASSERT_EQ(hits[k].phase_one_channels, 4);
            if (distance > 0.5)
                for (int c = 0; c < 4; ++c)
                    farthest = std::max(farthest, std::fabs(hits[k].phase_one[c] - before[k].phase_one[c]));
        }
        changes += distance > 0.5 && hits[0].level != before[0].level;
        before = hits;
    }
    EXPECT_GE(changes, 5);
    EXPECT_LT(farthest, 0.017f);
}

}  // namespace
}  // namespace occam::test
