#include "tests/support/closed_rooms.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <sstream>

#include "base/error.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

/// Returns a box of quads whose lines lie at the given places along each axis. The edges of the box are creases if
/// `sharpness` is above 0.
Cage box_of(const std::vector<float> (&at)[3], float sharpness)
{
    Cage cage;
    std::map<std::array<std::size_t, 3>, std::uint32_t> known;
    const auto vertex = [&](std::array<std::size_t, 3> k) {
        const auto [found, is_new] = known.try_emplace(k, static_cast<std::uint32_t>(cage.positions.size()));
        if (is_new) cage.positions.push_back({at[0][k[0]], at[1][k[1]], at[2][k[2]]});
        return found->second;
    };
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const bool upper : {false, true}) {
            const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
            for (std::size_t i = 0; i + 1 < at[u].size(); ++i)
                for (std::size_t j = 0; j + 1 < at[v].size(); ++j) {
                    const auto corner = [&](std::size_t di, std::size_t dj) {
                        std::array<std::size_t, 3> k{};
                        k[axis] = upper ? at[axis].size() - 1 : 0;
                        k[u] = i + di;
                        k[v] = j + dj;
                        return vertex(k);
                    };
                    const std::uint32_t a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
                    cage.face_sizes.push_back(4);
                    if (upper) cage.face_vertices.insert(cage.face_vertices.end(), {a, b, c, d});
                    else cage.face_vertices.insert(cage.face_vertices.end(), {a, d, c, b});
                    if (sharpness > 0 && j == 0) cage.creases.push_back({a, b, sharpness});
                    if (sharpness > 0 && j + 2 == at[v].size()) cage.creases.push_back({d, c, sharpness});
                }
        }
    return cage;
}

const std::vector<float> kEven{-1, 1}, kUneven{-1, -0.93f, -0.2f, 0.71f, 0.9f, 1}, kFew{-1, 0.85f, 1};

/// Displaces a cage by noise.
void displace(Cage& cage, Scene& scene)
{
    std::mt19937_64 random(4);
    Texture noise;
    noise.role = TextureRole::Data;
    noise.width = noise.height = 32;
    for (int i = 0; i < 32 * 32; ++i) noise.pixels.push_back(Vec4f(float(random() >> 40) * 0x1p-24f));
    add_charts(cage);
    Displacement displacement;
    displacement.texture.texture = scene.add(std::move(noise));
    displacement.scale = 0.1f;
    displacement.bound = 0.05f;
    cage.displacement = displacement;
}

/// Records how the room moves. The camera moves with it, but not with what bends.
void record(Scene& scene, NodeId node, Camera& camera, Moves how)
{
    const CageId cage = scene.node(node).cages.front();
    const std::vector<Vec3f> rest = scene.cage(cage).cage.positions;
    const Mat4d place = scene.world_from_node(node), eye_from_node = glm::inverse(place) * camera.world_from_camera;
    const auto map_at = [&](double tau) {
        Trs trs;
        if (how == Moves::Slides) trs.translation = Vec3d(1.5, -0.7, 2.1) * tau;
        if (how == Moves::Turns) trs.rotation = glm::normalize(Vec4d(0.3 * tau, -0.2 * tau, 0.4 * tau, 1));
        if (how == Moves::Grows) trs.scale = Vec3d(1 + tau, 1 + tau, 1 + 0.5 * tau);
        return trs.matrix();
    };
    scene.record_shutter(4, [&](double tau) {
        if (how != Moves::Bends) return scene.set_transform(node, place * map_at(tau));
        std::vector<Vec3f> bent = rest;
        for (Vec3f& p : bent) p += float(0.3 * tau) * Vec3f(p.y * p.y, p.z * p.x, p.x * p.x);
        scene.write_vertices(cage, bent);
    });
    for (int key = 0; key <= 4 && how != Moves::Bends; ++key)
        camera.keys.push_back(place * map_at(0.25 * key) * eye_from_node);
}

/// Puts what shines behind the walls, about where the camera's eye sees them.
void shine_from_outside(Scene& scene, const Camera& camera, Vec3d eye, Outside what)
{
    struct Wall {
        Vec3d place, outward;
        double distance;
    };
    std::vector<Wall> walls;
    {
        scene.refit();
        const Query query(scene, camera, 720);
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z) {
                    QueryRay ray{eye, glm::normalize(Vec3d(x + 0.21, y - 0.13, z + 0.08))};
                    // Normals of the finest micropolygons are not exact enough for panels.
                    ray.footprint = RayFootprint{what == Outside::Panels ? 0.05f : 0.0f, 0};
                    if (const auto hit = query.closest(ray))
                        walls.push_back({hit->position, -Vec3d(hit->normal_geometric), hit->distance});
                }
    }
    if (walls.size() != 27) throw Error({}, "a ray from inside meets no wall, so nothing shines behind it");
    for (const Wall& wall : walls) {
        NodeDesc desc;
        if (what == Outside::Lamps) {
            desc.place.translation = wall.place + (wall.place - eye) * 0.02;
            desc.light = scene.add(Light{"lamp", PointLight{Vec3f(1000)}});
        } else {
            const Vec3d x = glm::normalize(glm::cross(wall.outward, Vec3d(0.3, 0.5, 0.8))), y = glm::cross(wall.outward, x);
            Material glowing;
            glowing.emission = Vec3f(1000);
            glowing.double_sided = true;
            Cage panel;
            panel.scheme = Scheme::Triangles;
            for (const auto& [u, v] : {std::pair(-1, -1), std::pair(1, -1), std::pair(0, 1)})
                panel.positions.push_back(Vec3f((x * double(u) + y * double(v)) * (0.2 * wall.distance)));
            panel.face_vertices = {0, 1, 2};
            panel.materials = {scene.add(glowing)};
            desc.place.translation = wall.place + wall.outward * (2e-5 * wall.distance);
            desc.cages = {scene.add(std::move(panel))};
        }
        scene.add_node(scene.root(), desc);
    }
}

}  // namespace

Cage lump(std::uint64_t seed)
{
    std::mt19937_64 random(seed);
    const auto uniform = [&](double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; };
    const auto around = static_cast<std::uint32_t>(uniform(3, 13)), down = static_cast<std::uint32_t>(uniform(1, 7));
    const double rough = uniform(0, 0.45);
    Cage cage;
    const auto add = [&](double polar, double turn) {
        const double r = uniform(1 - rough, 1 + rough);
        cage.positions.push_back({float(r * std::sin(polar) * std::cos(turn)), float(r * std::cos(polar)),
                                  float(r * std::sin(polar) * std::sin(turn))});
    };
    add(0, 0);
    add(3.14159265, 0);
    for (std::uint32_t j = 0; j < down; ++j)
        for (std::uint32_t i = 0; i < around; ++i)
            add(3.14159265 * (j + 1) / (down + 1), 6.2831853 * (i + uniform(-0.3, 0.3)) / around);
    const auto at = [&](std::uint32_t i, std::uint32_t j) { return 2 + j * around + i % around; };
    for (std::uint32_t i = 0; i < around; ++i) {
        cage.face_vertices.insert(cage.face_vertices.end(), {0, at(i + 1, 0), at(i, 0)});
        cage.face_sizes.push_back(3);
        for (std::uint32_t j = 0; j + 1 < down; ++j) {
            const std::uint32_t a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
            if (random() % 4 == 0) {
                cage.face_vertices.insert(cage.face_vertices.end(), {a, b, c, a, c, d});
                cage.face_sizes.insert(cage.face_sizes.end(), {3, 3});
            } else {
                cage.face_vertices.insert(cage.face_vertices.end(), {a, b, c, d});
                cage.face_sizes.push_back(4);
            }
            if (random() % 5 == 0) cage.creases.push_back({a, b, float(uniform(0, 5))});
        }
        cage.face_vertices.insert(cage.face_vertices.end(), {1, at(i, down - 1), at(i + 1, down - 1)});
        cage.face_sizes.push_back(3);
    }
    return cage;
}

std::vector<Room> rooms()
{
    Cage bilinear = box_of({kUneven, kFew, kUneven}, 0);
    bilinear.scheme = Scheme::Bilinear;
    return {{"box of uneven quads", box_of({kUneven, kFew, kUneven}, 0)},
            {"cube with creases", box_of({kEven, kEven, kEven}, 2)},
            {"box with sharp edges", box_of({kUneven, kEven, kFew}, 10)},
            {"bilinear box", bilinear},
            {"bipyramid", spindle(36)},
            {"spindle", spindle(9)},
            {"prism", prism(7)},
            {"torus", torus(), {1, 0.02, 0.05}, {0.9, 0.1, 1}}};
}

std::vector<Room> rooms_with_concave_floors()
{
    const auto room = [](const char* name, const std::vector<Vec2f>& floor, Vec3d eye, Vec3d target) {
        Cage cage;
        const auto n = static_cast<std::uint32_t>(floor.size());
        for (const float y : {0.0f, 1.0f})
            for (const Vec2f p : floor) cage.positions.push_back({p.x, y, p.y});
        cage.face_sizes = {n, n};
        for (std::uint32_t i = 0; i < n; ++i) cage.face_vertices.push_back(i);
        for (std::uint32_t i = 0; i < n; ++i) cage.face_vertices.push_back(2 * n - 1 - i);
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t j = (i + 1) % n;
            cage.face_sizes.push_back(4);
            cage.face_vertices.insert(cage.face_vertices.end(), {i, n + i, n + j, j});
            for (const auto& [a, b] : {std::pair(i, j), std::pair(n + i, n + j), std::pair(i, n + i)})
                cage.creases.push_back({a, b, 10});
        }
        return Room{name, cage, eye, target};
    };
    std::vector<Vec2f> star;
    for (int k = 0; k < 14; ++k) {
        const double r = k % 2 ? 1 : 0.35, angle = 3.14159265 * k / 7;
        star.push_back({float(r * std::cos(angle)), float(r * std::sin(angle))});
    }
    return {
        {room("L", {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}, {0.5, 0.3, 1.7}, {0.6, 0.1, 0.2})},
        {room("long L", {{0, 0}, {4, 0}, {4, 0.5f}, {0.5f, 0.5f}, {0.5f, 4}, {0, 4}}, {0.25, 0.5, 0.25}, {3.8, 0.1, 0.25})},
        {room("U", {{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 0.5f}, {1, 0.5f}, {1, 3}, {0, 3}}, {0.5, 0.5, 2.5},
              {0.5, 0.1, 0.2})},
        {room("star", star, {0, 0.2, 0}, {0.5, 0.9, 0.5})}};
}

Room wedge(double degrees, Scheme scheme)
{
    const double half = degrees * 3.14159265 / 360;
    Cage cage;
    cage.scheme = scheme;
    for (const double z : {-0.5, 0.5})
        for (const double side : {0, -1, 1})
            cage.positions.push_back(Vec3f(Vec3d(side == 0 ? 0 : std::cos(half), side * std::sin(half), z)));
    cage.face_sizes = {3, 3, 4, 4, 4};
    cage.face_vertices = {2, 1, 0, 3, 4, 5, 0, 1, 4, 3, 1, 2, 5, 4, 2, 0, 3, 5};
    if (scheme == Scheme::CatmullClark)
        for (std::uint32_t i = 0; i < 3; ++i)
            cage.creases.insert(cage.creases.end(), {{i, (i + 1) % 3, 10}, {i + 3, (i + 1) % 3 + 3, 10}, {i, i + 3, 10}});
    return {"wedge of " + std::to_string(degrees) + " degrees", cage, {0.7, 0, 0.1}, {0, 0, 0.03}};
}

/// Adds sheets in front of the camera that let all light pass.
void add_veils(Scene& scene, const Camera& camera, double length)
{
    Material clear;
    clear.base_color = Vec4f(1, 1, 1, 0);
    clear.alpha_mode = AlphaMode::Blend;
    const MaterialId material = scene.add(clear);
    for (int i = 1; i <= 12; ++i) {
        Cage sheet;
        sheet.scheme = Scheme::Triangles;
        for (const Vec2d corner : {Vec2d(-1, -1), Vec2d(1, -1), Vec2d(1, 1), Vec2d(-1, 1)})
            sheet.positions.push_back(
                Vec3f(transform_point(camera.world_from_camera, Vec3d(corner * 9.0, -0.1 * i) * length)));
        sheet.face_vertices = {0, 1, 2, 0, 2, 3};
        sheet.materials = {material};
        NodeDesc desc;
        desc.cages = {scene.add(sheet)};
        scene.add_node(scene.root(), desc);
    }
}

/// Adds the light that the walls keep out, or the lamp inside.
void add_light(Scene& scene, const Camera& camera, Vec3d eye, Outside what)
{
    if (what == Outside::Sky) {
        scene.environment.radiance = Vec3f(1000);
    } else if (what == Outside::LampInside) {
        scene.add_node(scene.root(),
                       {.place = {.translation = eye}, .light = scene.add(Light{"lamp", PointLight{Vec3f(9)}})});
    } else {
        shine_from_outside(scene, camera, eye, what);
    }
}

int lit_pixels(const Room& room, const Look& look)
{
    Scene scene;
    Cage cage = room.cage;
    Material white;
    white.base_color = Vec4f(1);
    white.roughness = 1;
    cage.materials = {scene.add(white)};
    if (look.displaced) displace(cage, scene);
    NodeDesc desc;
    desc.place.scale = Vec3d(look.scale);
    desc.place.translation = Vec3d(3, -2, 5) * look.scale;
    if (look.place) desc.place = *look.place;
    Mat4d shear(1);
    if (look.sheared) {
        shear[1] = Vec4d(0.6, 1, 0, 0);
        shear[2] = Vec4d(-0.2, 0.3, 1, 0);
        desc.matrix = desc.place.matrix() * shear;
    }
    const Mat4d world_from_room = desc.place.matrix() * shear;
    desc.cages = {scene.add(cage)};
    if (look.instanced || look.crossed) {
        NodeDesc original;
        original.cages = std::move(desc.cages);
        original.place.translation = Vec3d(500, 300, -200);
        desc.cages.clear();
        desc.instance_of = scene.add_node(scene.root(), original);
        NodeDesc other = desc;
        const Vec3d side = desc.place.scale;
        const double size = std::max({std::abs(side.x), std::abs(side.y), std::abs(side.z)});
        const Vec3d away = (look.crossed ? Vec3d(0.5, 0.1, 0.2) : Vec3d(9, 1, 2)) * size;
        other.place.translation += away;
        if (other.matrix) (*other.matrix)[3] += Vec4d(away, 0);
        scene.add_node(scene.root(), other);
    }
    const NodeId node = scene.add_node(scene.root(), desc);
    Camera camera = Camera::look_at(transform_point(world_from_room, room.eye),
                                    transform_point(world_from_room, room.target), {0, 1, 0}, look.field);
    add_light(scene, camera, transform_point(world_from_room, room.eye), look.outside);
    const double length = std::cbrt(std::abs(glm::determinant(Mat3d(world_from_room))));
    camera.lens.radius = static_cast<float>(look.lens * length);
    camera.lens.focus = static_cast<float>(look.focus * length);
    camera.lens.orthographic = look.parallel;
    camera.lens.height = static_cast<float>(2 * look.lens * length);
    if (look.veiled) add_veils(scene, camera, length);
    Settings settings{.width = look.width, .height = look.height, .spp = look.spp};
    if (look.moves != Moves::Not) record(scene, node, camera, look.moves);
    settings.integrator = look.integrator;
    settings.bounces = 4;
    settings.shading_rate = look.rate;
    settings.lod = look.lod;
    const Image image = Renderer({.threads = 2, .tree = look.tree}).render(scene, camera, settings);
    const Layer& beauty = *image.find("beauty");
    int lit = 0;
    for (std::size_t i = 0; i < beauty.pixels.size(); i += 4)
        lit += beauty.pixels[i] != 0 || beauty.pixels[i + 1] != 0 || beauty.pixels[i + 2] != 0;
    return lit;
}

void expect_dark(const Room& room, const Look& look)
{
    std::ostringstream what;
    what << room.name << ", rate " << look.rate << ", level mode " << int(look.lod) << ", integrator "
         << int(look.integrator) << (look.displaced ? ", displaced" : "") << ", scale " << look.scale
         << (look.instanced ? ", instanced" : "");
    if (look.lens > 0)
        what << ", lens " << look.lens << " focused at " << look.focus << (look.parallel ? ", parallel" : "") << ", tree "
             << int(look.tree) << ", " << look.spp << " samples";
    try {
        EXPECT_EQ(lit_pixels(room, look), 0) << what.str();
    } catch (const Error& error) {
        ADD_FAILURE() << what.str() << ": " << error.what();
    }
}

}  // namespace occam::test
