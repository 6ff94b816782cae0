// Small emissive triangles in large cages: scattered rays know with which density a sample lands where they hit.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cmath>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "base/matrix.h"
#include "scenegraph/contents.h"
#include "shade/mesh_lights.h"
#include "tests/support/statistics.h"

namespace occam {
namespace {

constexpr float kAlbedo = 0.8f, kRadiance = 10;

// A floor over [-1, 1] in x and z at y = 0 and, as another slot of the same cage, a lamp of two triangles.
struct Room {
    Vec3f corner[4];  ///< of the lamp, in order
    Vec3d scale;
    Vec3d seen;  ///< the place on the floor that the camera sees, in the cage's axes

    /// is_apart   the lamp is a cage of its own
    float floor_of(IntegratorKind integrator, bool is_apart) const
    {
        Scene scene;
        Material white, glow;
        white.base_color = Vec4f(kAlbedo, kAlbedo, kAlbedo, 1);
        white.specular = glow.specular = 0;
        glow.base_color = Vec4f(0, 0, 0, 1);
        glow.emission = Vec3f(kRadiance);
        Cage floor, apart;
        floor.scheme = apart.scheme = Scheme::Triangles;
        const auto add_quad = [](Cage& to, const Vec3f(&corners)[4], std::uint32_t slot) {
            const auto first = static_cast<std::uint32_t>(to.positions.size());
            to.positions.insert(to.positions.end(), corners, corners + 4);
            for (const std::uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) to.face_vertices.push_back(first + k);
            to.face_slots.insert(to.face_slots.end(), 2, slot);
        };
        add_quad(floor, {{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}}, 0);
        add_quad(is_apart ? apart : floor, corner, is_apart ? 0 : 1);
        floor.materials = {scene.add(white), scene.add(glow)};
        apart.materials = {floor.materials[1]};
        NodeDesc desc;
        desc.place.translation = {0.12345, 0.2, 0.3};
        desc.place.scale = scale;
        desc.cages.push_back(scene.add(std::move(floor)));
        if (is_apart) desc.cages.push_back(scene.add(std::move(apart)));
        scene.add_node(scene.root(), desc);
        const Vec3d at = desc.place.translation + seen * scale;
        const double away = 0.01 * std::abs(scale.y) * size();
        const Camera camera = Camera::look_at(at + Vec3d(0, away, 0), at, {1, 0, 0}, 1e-3f);
        Settings settings;
        settings.width = settings.height = 32;
        settings.spp = 64;
        settings.bounces = integrator == IntegratorKind::Path ? 1 : 0;
        settings.integrator = integrator;
        settings.sky = Sky::Off;
        const std::vector<float> pixels = Renderer({.threads = 2}).render(scene, camera, settings).find("beauty")->pixels;
        double sum = 0;
        for (std::size_t i = 0; i < pixels.size(); i += 4) sum += double(pixels[i]);
        return static_cast<float>(sum * 4 / double(pixels.size()));
    }
    double size() const { return double(glm::length(corner[2] - corner[0])); }
    /// Returns what the floor sends up by Lambert's formula: the integral over the lamp is a sum over its edges.
    double exact() const
    {
        Vec3d to[4];
        for (int i = 0; i < 4; ++i) to[i] = glm::normalize((Vec3d(corner[i]) - seen) * scale);
        double sum = 0;
        for (int i = 0; i < 4; ++i) {
            const Vec3d a = to[i], b = to[(i + 1) % 4], across = glm::cross(a, b);
            sum += std::atan2(glm::length(across), glm::dot(a, b)) * across.y / glm::length(across);
        }
        return double(kAlbedo) * double(kRadiance) * std::abs(sum) / (2 * 3.14159265358979);
    }
};

// The lamp is upright across x or z, or level; the place that is seen lies close beside it, or below.
Room room_of(int axis, float side, Vec3d scale)
{
    const Vec3f at(0.7123f, axis == 1 ? side : side / 64, 0.4567f);
    Vec3f u(0), v(0);
    u[axis == 0 ? 2 : 0] = side;
    v[axis == 1 ? 2 : 1] = side;
    Room room{{at, at + u, at + u + v, at + v}, scale, {}};
    Vec3d off(0.5 * double(side));
    if (axis != 1) off[axis] = 0.4 * double(side);
    room.seen = Vec3d(double(at.x) + off.x, 0, double(at.z) + off.z);
    return room;
}

TEST(SmallLamps, CountOnceWhateverTheSizeOfTheirCage)
{
    const Vec3d scales[] = {Vec3d(0.37), Vec3d(0.61), Vec3d(0.83), {1.7, 0.9, -1.3}, Vec3d(3.1e7), Vec3d(2.3e-7)};
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {3e-2f, 5e-3f, 2e-3f})
            for (const Vec3d scale : scales) {
                const Room room = room_of(axis, side, scale);
                for (const IntegratorKind kind : {IntegratorKind::Direct, IntegratorKind::Path})
                    EXPECT_NEAR(double(room.floor_of(kind, false)) / room.exact(), 1, 6e-3)
                        << "axis " << axis << ", side " << side << ", scale " << scale.x << ' ' << int(kind);
            }
}

// The floor's rays start so far above it that the smallest lamp is seen a little more from above.
TEST(SmallLamps, OfACageOfTheirOwnGiveTheSame)
{
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {3e-2f, 1e-4f}) {
            const Room room = room_of(axis, side, Vec3d(0.83));
            EXPECT_NEAR(double(room.floor_of(IntegratorKind::Path, true)) / room.exact(), 1, side < 1e-3f ? 0.03 : 6e-3);
            EXPECT_NEAR(room.floor_of(IntegratorKind::Path, false) / room.floor_of(IntegratorKind::Path, true), 1, 6e-3)
                << axis << ' ' << side;
        }
}

// Eight emissive triangles in a plane, in the middle of a cage of size 1, which is shown twice.
struct Panel {
    Scene scene;
    Vec3d corner[4], middle;
    Mat4d placement;

    Panel(float side, int axis, test::Numbers& n)
    {
        const Vec3f at(0.4f * n.one() - 0.2f, 0.4f * n.one() - 0.2f, 0.4f * n.one() - 0.2f);
        Vec3f u(0), v(0);
        u[(axis + 1) % 3] = v[(axis + 2) % 3] = side;
        if (axis == 3) u = side * Vec3f(0.6f, 0.64f, 0.48f), v = side * Vec3f(0.8f, -0.48f, -0.36f);
        Cage cage;
        cage.scheme = Scheme::Triangles;
        for (const float sign : {-1.0f, 1.0f}) {
            const auto first = static_cast<std::uint32_t>(cage.positions.size());
            for (const Vec3f far : {Vec3f(-1, -1, 1), Vec3f(1, -1, 1), Vec3f(1, 1, 1)}) cage.positions.push_back(far * sign);
            cage.face_vertices.insert(cage.face_vertices.end(), {first, first + 1, first + 2});
            cage.face_slots.push_back(0);
        }
        for (std::uint32_t j = 0; j < 3; ++j)
            for (std::uint32_t i = 0; i < 3; ++i) cage.positions.push_back(at + u * (float(i) / 2) + v * (float(j) / 2));
        for (std::uint32_t j = 0; j < 2; ++j)
            for (std::uint32_t i = 0; i < 2; ++i) {
                const std::uint32_t a = 6 + 3 * j + i;
                cage.face_vertices.insert(cage.face_vertices.end(), {a, a + 1, a + 4, a, a + 4, a + 3});
                cage.face_slots.insert(cage.face_slots.end(), 2, 1);
            }
        for (const std::uint32_t k : {0u, 2u, 8u, 6u})
            corner[k == 8 ? 2 : k == 6 ? 3 : k / 2] = Vec3d(cage.positions[6 + k]);
        Material dark, glow;
        glow.emission = Vec3f(3);
        cage.materials = {scene.add(dark), scene.add(glow)};
        const double scale = std::exp2(40.0 * double(n.one()) - 20);
        NodeDesc shown;
        shown.place.scale = Vec3d(1, 0.5 + double(n.one()), n.one() < 0.5f ? 1 : -1);
        shown.cages = {scene.add(std::move(cage))};
        NodeDesc moved;
        moved.place.translation = Vec3d(n.one(), n.one(), n.one()) * (3 * scale);
        moved.place.scale = Vec3d(scale);
        const NodeId first = scene.add_node(scene.add_node(scene.root(), moved), shown);
        moved.place.translation.x += 5 * scale;
        moved.place.rotation = {0, 0.6, 0, 0.8};
        moved.instance_of = first;
        scene.add_node(scene.root(), moved);
        scene.refit();
        placement = Mat4d(1);
        scene.for_placements_of(Contents::Emitters, [&](NodeId, const Node&, const Mat4d& m) { placement = m; });
        for (Vec3d& c : corner) c = transform_point(placement, c);
        middle = (corner[0] + corner[2]) * 0.5;
    }
};

TEST(SmallLamps, TheDensityAtAHitIsThatOfTheSampleThatLandsThere)
{
    test::Numbers n(17);
    const TextureStore textures(1 << 20);
    int compared = 0, others = 0;
    for (int pass = 0; pass < 400; ++pass) {
        const float side = std::pow(10.0f, -1 - 4 * n.one());
        Panel panel(side, pass % 4, n);
        shade::MeshLights lights(panel.scene, textures);
        lights.make_tree({});
        lod::TopologyCache topologies;
        const accel::Frame frame(panel.scene, topologies, {.eye = Vec3d(0), .pixel = {0.05f, 0}});
        accel::Tracer tracer(frame, std::size_t(1) << 26);
        const Vec3d across = glm::cross(panel.corner[1] - panel.corner[0], panel.corner[3] - panel.corner[0]);
        const double size = std::sqrt(glm::length(across));
        for (int i = 0; i < 20; ++i) {
            const Vec3d point = panel.middle + Vec3d(n.one() - 0.5f, n.one() - 0.5f, n.one() - 0.5f) * (4 * size);
            const shade::Receiver receiver{lights.tree().relative(point), Vec3f(glm::normalize(panel.middle - point)),
                                           kAllGroups, false};
            const shade::LightSample s = lights.sample(point, receiver, {{n.one(), n.one()}, n.one()});
            if (s.radiance == Vec3f(0)) continue;
            const double along = glm::dot(Vec3d(s.direction), across);
            const double distance = glm::dot(panel.corner[0] - point, across) / along;
            const double cosine = std::abs(along) / glm::length(across);
            if (distance > 100 * size || distance < 0.1 * size || cosine < 0.1) continue;  // of the other placement
            accel::Ray ray;
            ray.origin = point;
            ray.direction = s.direction;
            accel::SurfaceHit hit;
            tracer.closest({&ray, 1}, {&hit, 1});
            if (!hit.is_hit() || hit.material->emission == Vec3f(0)) continue;
            const double off = std::abs(glm::dot(hit.position - panel.corner[0], across)) / glm::length(across);
            EXPECT_LT(off, 0.25 * double(hit.self_distance)) << "what the position is looked for within is more than enough";
            const double wanted = double(s.density) * cosine / (distance * distance);
            const double found = double(lights.area_density(
                {hit.node, hit.cage, hit.material, hit.face, hit.position, hit.self_distance}, receiver));
            ASSERT_GT(found, 0) << "side " << side << ", pass " << pass;
            ++compared;
            others += !(std::abs(found - wanted) <= 1e-2 * wanted);  // at an edge it may be the neighbour
        }
    }
    EXPECT_GT(compared, 2000);
    EXPECT_LT(others, compared / 50);
}

}  // namespace
}  // namespace occam
