// Tests that rooms without an opening stay dark: no secondary ray leaves a closed cage through a wall, and no pixel is lit.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <map>
#include <optional>
#include <random>
#include <sstream>

#include "base/error.h"
#include "tests/support/campaign.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/made_cages.h"
#include "tests/support/refined_cages.h"
#include "tests/support/shape_builders.h"
#include "tests/support/shapes.h"
#include "verify/closed.h"

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

/// Returns a sphere of quads with two poles. Its vertices are moved in and out, and some of its edges are creased.
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

struct Room {
    std::string name;
    Cage cage;
    Vec3d eye{0.13, 0.07, 0.11}, target{-0.4, 0.2, -1};
};

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

/// How a room and the camera in it move while the shutter is open.
enum class Moves { Not, Slides, Turns, Grows, Bends };

struct Look {
    float rate = 1;
    render::Lod lod = render::Lod::On;
    IntegratorKind integrator = IntegratorKind::Path;
    bool displaced = false;
    double scale = 1;
    std::optional<Trs> place{};  ///< instead of `scale`
    bool sheared = false;        ///< what is placed leans along x, as a matrix tells
    bool instanced = false;      ///< the room is one of three instances of a node that stands elsewhere
    bool crossed = false;        ///< the room is crossed by another instance of it
    Moves moves = Moves::Not;
    int width = 24, height = 18, spp = 4;
};

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

/// Returns the number of pixels that are not black in a picture from inside the room, with a bright sky outside.
int lit_pixels(const Room& room, const Look& look)
{
    Scene scene;
    Cage cage = room.cage;
    Material white;
    white.base_color = Vec4f(1);
    white.roughness = 1;
    cage.materials = {scene.add(white)};
    if (look.displaced) {
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
    scene.environment.radiance = Vec3f(1000);
    Camera camera = Camera::look_at(transform_point(world_from_room, room.eye),
                                    transform_point(world_from_room, room.target), {0, 1, 0}, 1.5f);
    Settings settings{.width = look.width, .height = look.height, .spp = look.spp};
    if (look.moves != Moves::Not) record(scene, node, camera, look.moves);
    settings.integrator = look.integrator;
    settings.bounces = 4;
    settings.shading_rate = look.rate;
    settings.lod = look.lod;
    const Image image = Renderer({.threads = 2}).render(scene, camera, settings);
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
    try {
        EXPECT_EQ(lit_pixels(room, look), 0) << what.str();
    } catch (const Error& error) {
        ADD_FAILURE() << what.str() << ": " << error.what();
    }
}

constexpr IntegratorKind kBoth[] = {IntegratorKind::Path, IntegratorKind::Ao};

TEST(ClosedRooms, AreDarkAtEveryShadingRate)
{
    for (const Room& room : rooms())
        for (const float rate : {0.25f, 1.0f, 8.0f, 16.0f})
            for (const IntegratorKind kind : kBoth) expect_dark(room, {.rate = rate, .integrator = kind});
}

TEST(ClosedRooms, AreDarkInEveryLevelMode)
{
    for (const Room& room : rooms())
        for (const render::Lod lod : {render::Lod::Off, render::Lod::Frozen})
            for (const float rate : {2.0f, 8.0f})
                for (const IntegratorKind kind : kBoth) expect_dark(room, {.rate = rate, .lod = lod, .integrator = kind});
}

TEST(ClosedRooms, AreDarkDisplacedAndAtEveryScale)
{
    for (const Room& room : rooms()) {
        if (room.name != "bipyramid") expect_dark(room, {.rate = 4, .displaced = true});
        for (const double scale : {1e-3, 1e4}) expect_dark(room, {.rate = 6, .scale = scale});
    }
}

/// The node that the rooms are instances of is as large as ten thousand rooms, and millions of rooms away.
TEST(ClosedRooms, AreDarkWhileTheyMove)
{
    for (const Room& room : rooms())
        for (const Moves how : {Moves::Slides, Moves::Turns, Moves::Grows, Moves::Bends})
            for (const Look& look : {Look{}, Look{.rate = 8}, Look{.displaced = true}}) {
                SCOPED_TRACE("motion " + std::to_string(int(how)));
                Look moving = look;
                moving.moves = how;
                expect_dark(room, moving);
            }
}

TEST(ClosedRooms, AreDarkInAMuchLargerWorld)
{
    for (const Room& room : rooms())
        for (const render::Lod lod : {render::Lod::On, render::Lod::Off, render::Lod::Frozen})
            expect_dark(room, {.rate = 0.5f, .lod = lod, .scale = 1e-4, .instanced = true});
}

TEST(ClosedRooms, AreDarkWhateverTheCage)
{
    const int count = is_long() ? 100 : 8;
    for (int seed = 0; seed < count; ++seed) {
        const std::string name = "lump " + std::to_string(seed);
        const Room room{name, lump(static_cast<std::uint64_t>(seed)), {0.03, 0.02, 0.01}};
        expect_dark(room,
                    {.rate = std::exp2(float(seed % 7) - 2), .lod = render::Lod(seed % 3), .integrator = kBoth[seed % 2]});
    }
}

/// Returns a point inside of the cage, as far from its surface as few trials find; none for a cage that is thin everywhere.
std::optional<Vec3d> point_inside(const Cage& cage, std::mt19937_64& random)
{
    DicedCage diced(cage, 0);
    diced.level_of_largest_exponent(3);
    std::vector<Vec3f> corners;
    Box3d box;
    for (const MeshTriangle& t : diced.triangles())
        for (const Vec3f v : t.v) {
            corners.push_back(v);
            box.add(Vec3d(v));
        }
    const auto uniform = [&] { return double(random() >> 11) * 0x1p-53; };
    double best = 0.12 * box.radius();
    std::optional<Vec3d> found;
    for (int trial = 0; trial < 60; ++trial) {
        const Vec3d p = box.lo + box.extent() * Vec3d(uniform(), uniform(), uniform());
        double clear = box.radius();
        for (const Vec3f v : corners) clear = std::min(clear, glm::distance(Vec3d(v), p));
        if (clear <= best || winding_number(corners, p) < 0.9) continue;
        best = clear;
        found = diced.posed.anchor + p;
    }
    return found;
}

/// Returns a look from inside a room, with everything that may be set drawn at random.
Look random_look(std::mt19937_64& random)
{
    const auto uniform = [&](double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; };
    Look look;
    look.rate = std::exp2(float(random() % 7) - 2);
    look.lod = render::Lod(random() % 3);
    look.integrator = kBoth[random() % 2];
    look.displaced = random() % 3 == 0;
    look.instanced = random() % 2 == 0;
    look.sheared = random() % 2 == 0;
    look.place = Trs();
    look.place->translation = Vec3d(uniform(-50, 50), uniform(-50, 50), uniform(-50, 50));
    look.place->rotation = glm::normalize(Vec4d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(0.1, 1)));
    look.place->scale = Vec3d(uniform(0.5, 2), uniform(0.5, 2), uniform(0.5, 2) * (random() % 2 ? -1 : 1)) *
                        std::exp2(uniform(-20, 20));
    return look;
}

/// Where two cages cross, a ray that starts on one of them may start behind the other: its start is moved to the mesh of one
/// level, while its parent saw both cages between two levels. No more than one pixel in twenty may be lit by that, and none
/// where there is one level only.
TEST(ClosedRooms, ThatCrossEachOtherLetLittleLightIn)
{
    for (const Room& room : rooms())
        for (const render::Lod lod : {render::Lod::On, render::Lod::Off, render::Lod::Frozen})
            for (const IntegratorKind kind : kBoth) {
                const Look look{.rate = 4, .lod = lod, .integrator = kind, .crossed = true};
                const int most = lod == render::Lod::Off ? 0 : look.width * look.height / 20;
                EXPECT_LE(lit_pixels(room, look), most) << room.name << ", level mode " << int(lod);
            }
}

/// The closed cages of the shared data are rooms, too: one in five by default, and all of them four times if OCCAM_LONG
/// is 1.
TEST(ClosedRooms, AreDarkForEverySharedCageHoweverItIsPlaced)
{
    std::mt19937_64 random(9);
    int number = 0, tested = 0;
    for (const std::string& name : closed_shapes()) {
        if (name.starts_with("made:") || (!is_long() && ++number % 5 != 0)) continue;
        Room room{name, load_cage(name)};
        if (room.cage.face_count() > 3000 && !is_long()) continue;
        // The lengths of displacement are those of rooms of about this size.
        const Box3d box = room.cage.bounds();
        for (Vec3f& p : room.cage.positions) p = Vec3f((Vec3d(p) - box.centre()) * (1.5 / box.radius()));
        const std::optional<Vec3d> eye = point_inside(room.cage, random);
        if (!eye) continue;
        room.eye = *eye;
        room.target = *eye + Vec3d(0.3, -0.1, 0.8);
        for (int look = 0; look < (is_long() ? 4 : 1); ++look) {
            expect_dark(room, random_look(random));
            ++tested;
        }
    }
    // The rooms of the other tests are made in code, and are tested without the shared data, too.
    if (tested == 0) GTEST_SKIP() << "the shared folder is absent: its closed cages are not tested as rooms";
}

/// Every closed cage of the tests is a room, and so are what refining it gives and its mix of quads and triangles: turned,
/// stretched, mirrored, displaced and instanced, with settings that change from one to the next.
TEST(ClosedRooms, AreDarkForEveryMadeCageHoweverItIsPlaced)
{
    std::mt19937_64 random(8);
    const auto uniform = [&](double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; };
    int number = 0, tested = 0;
    for (const MadeCage& made : made_cages()) {
        ++number;
        if (!made.is_closed || (!is_long() && number % 4 != 0)) continue;
        const int kind = number / (is_long() ? 1 : 4) % 3;
        Room room{made.name + (kind == 1   ? ", refined"
                               : kind == 2 ? ", with triangles"
                                           : ""),
                  kind == 1   ? refined(made.cage, true)
                  : kind == 2 ? with_triangles(made.cage, std::uint32_t(number))
                              : made.cage};
        const std::optional<Vec3d> eye = point_inside(room.cage, random);
        if (!eye) continue;
        room.eye = *eye;
        room.target = *eye + Vec3d(uniform(-1, 1), uniform(-0.5, 0.5), uniform(-1, 1));
        Look look;
        look.rate = std::exp2(float(number / 4 % 7) - 2);
        look.lod = render::Lod(number / 4 % 3);
        look.integrator = kBoth[number / 4 % 2];
        look.instanced = number / 4 % 2 == 1;
        look.place = Trs();
        look.place->translation = Vec3d(uniform(-50, 50), uniform(-50, 50), uniform(-50, 50));
        look.place->rotation = glm::normalize(Vec4d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(0.1, 1)));
        look.place->scale = Vec3d(uniform(0.5, 2), uniform(0.5, 2), uniform(0.5, 2) * (number / 4 % 3 == 1 ? -1 : 1));
        expect_dark(room, look);
        ++tested;
    }
    EXPECT_GE(tested, is_long() ? 25 : 6);
}

}  // namespace
}  // namespace occam::test
