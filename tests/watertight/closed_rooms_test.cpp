// Tests that rooms without an opening stay dark: no secondary ray leaves a closed cage through a wall, and no pixel is lit.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <optional>
#include <random>

#include "tests/support/campaign.h"
#include "tests/support/closed_rooms.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/made_cages.h"
#include "tests/support/refined_cages.h"
#include "tests/support/shapes.h"
#include "verify/closed.h"

namespace occam::test {
namespace {

constexpr IntegratorKind kBoth[] = {IntegratorKind::Path, IntegratorKind::Ao};

TEST(ClosedRooms, AreDarkAtEveryShadingRate)
{
    EveryNth tested(3);
    for (const Room& room : rooms())
        for (const float rate : {0.25f, 1.0f, 8.0f, 16.0f})
            for (const IntegratorKind kind : kBoth)
                if (tested.takes()) expect_dark(room, {.rate = rate, .integrator = kind});
}

TEST(ClosedRooms, AreDarkInEveryLevelMode)
{
    EveryNth tested(3);
    for (const Room& room : rooms())
        for (const render::Lod lod : {render::Lod::Off, render::Lod::Frozen})
            for (const float rate : {2.0f, 8.0f})
                for (const IntegratorKind kind : kBoth)
                    if (tested.takes()) expect_dark(room, {.rate = rate, .lod = lod, .integrator = kind});
}

TEST(ClosedRooms, AreDarkDisplacedAndAtEveryScale)
{
    for (const Room& room : rooms()) {
        if (room.name != "bipyramid") expect_dark(room, {.rate = 4, .displaced = true});
        for (const double scale : {1e-3, 1e4}) expect_dark(room, {.rate = 6, .scale = scale});
    }
}

TEST(ClosedRooms, AreDarkWhileTheyMove)
{
    EveryNth tested(5);
    for (const Room& room : rooms())
        for (const Moves how : {Moves::Slides, Moves::Turns, Moves::Grows, Moves::Bends})
            for (const Look& look : {Look{}, Look{.rate = 8}, Look{.displaced = true}}) {
                if (!tested.takes()) continue;
                SCOPED_TRACE("motion " + std::to_string(int(how)));
                Look moving = look;
                moving.moves = how;
                expect_dark(room, moving);
            }
}

/// The node that the rooms are instances of is as large as ten thousand rooms, and millions of rooms away.
TEST(ClosedRooms, AreDarkInAMuchLargerWorld)
{
    EveryNth tested(4);
    for (const Room& room : rooms())
        for (const render::Lod lod : {render::Lod::On, render::Lod::Off, render::Lod::Frozen})
            if (tested.takes()) expect_dark(room, {.rate = 0.5f, .lod = lod, .scale = 1e-4, .instanced = true});
}

/// Returns the radius of a lens that has room within the walls wherever they are seen from: the tube of the torus is narrow.
float lens_of(const Room& room) { return room.name == "torus" ? 0.02f : 0.1f; }

/// A camera ray through a lens is two pieces, which meet at the focus. A wall that crosses the plane of focus is seen by
/// both, and has to be the same mesh there.
TEST(ClosedRooms, AreDarkThroughALens)
{
    EveryNth tested(7);
    for (const Room& room : rooms())
        for (const float rate : {0.25f, 1.0f, 4.0f, 16.0f})
            for (const float focus : {0.25f, 0.5f, 0.8f, 1.1f})
                for (const TreeKind tree : {TreeKind::Kd, TreeKind::Bvh}) {
                    if (!tested.takes()) continue;
                    Look look{.rate = rate, .lens = lens_of(room), .focus = focus, .tree = tree};
                    look.spp = rate < 1 ? 4 : 16;
                    expect_dark(room, look);
                }
}

TEST(ClosedRooms, AreDarkThroughALensInEveryLevelMode)
{
    EveryNth tested(3);
    for (const Room& room : rooms())
        for (const render::Lod lod : {render::Lod::Off, render::Lod::Frozen})
            for (const float focus : {0.3f, 0.7f})
                for (const IntegratorKind kind : kBoth) {
                    if (!tested.takes()) continue;
                    expect_dark(room, {.rate = 4, .lod = lod, .integrator = kind, .lens = lens_of(room), .focus = focus});
                }
}

TEST(ClosedRooms, AreDarkThroughALensHoweverTheyArePlacedAndMove)
{
    EveryNth tested(5);
    for (const Room& room : rooms())
        for (const float focus : {0.3f, 0.7f}) {
            const Look look{.rate = 4, .lens = lens_of(room), .focus = focus};
            std::vector<Look> looks(4, look);
            looks[0].scale = 1e-3;
            looks[1].instanced = looks[1].sheared = true;
            looks[2].parallel = true;
            looks[3].displaced = room.name != "bipyramid";
            for (const Moves how : {Moves::Slides, Moves::Turns, Moves::Grows, Moves::Bends}) {
                looks.push_back(look);
                looks.back().moves = how;
            }
            for (const Look& each : looks)
                if (tested.takes()) expect_dark(room, each);
        }
}

/// A ray that passes a sheet goes on behind it, and sees the walls there as it saw them in front of the sheet.
TEST(ClosedRooms, AreDarkBehindVeils)
{
    EveryNth tested(5);
    for (const Room& room : rooms())
        for (const float rate : {1.0f, 4.0f, 16.0f})
            for (const float lens : {0.0f, lens_of(room)})
                for (const bool is_displaced : {false, true}) {
                    if (!tested.takes() || (is_displaced && room.name == "bipyramid")) continue;
                    expect_dark(room,
                                {.rate = rate, .displaced = is_displaced, .lens = lens, .focus = 0.55f, .veiled = true});
                }
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

/// Brings a cage to the size of rooms for which the lengths of displacement are meant.
void fit_lengths(Cage& cage)
{
    const Box3d box = cage.bounds();
    for (Vec3f& p : cage.positions) p = Vec3f((Vec3d(p) - box.centre()) * (1.5 / box.radius()));
}

/// Counts what random looks have been.
struct Looks {
    int all = 0, displaced = 0, instanced = 0, sheared = 0, mirrored = 0, paths = 0, modes[3] = {};

    void add(const Look& look)
    {
        ++all;
        displaced += look.displaced;
        instanced += look.instanced;
        sheared += look.sheared;
        mirrored += look.place->scale.z < 0;
        paths += look.integrator == IntegratorKind::Path;
        ++modes[int(look.lod)];
    }
    /// Each of them has been so at least once, and otherwise at least once.
    void expect_all_kinds() const
    {
        for (const int count : {displaced, instanced, sheared, mirrored, paths}) {
            EXPECT_GT(count, 0);
            EXPECT_LT(count, all);
        }
        for (const int count : modes) EXPECT_GT(count, 0);
    }
};

/// The patches of a flat face that is not convex overlap, and some reach beyond its border, at each level in another way.
TEST(ClosedRooms, AreDarkOverFloorsThatAreNotConvex)
{
    EveryNth tested(5);
    for (const Room& room : rooms_with_concave_floors())
        for (const float rate : {1.0f, 4.0f, 16.0f})
            for (const render::Lod lod : {render::Lod::On, render::Lod::Frozen})
                if (tested.takes()) expect_dark(room, {.rate = rate, .lod = lod, .width = 120, .height = 90});
}

/// Close to an edge the walls of an acute corner are less apart than what secondary rays start off a wall by. These start
/// on the ray that found the wall, which has come from inside; along the wall's normal they would start behind the other
/// one.
TEST(ClosedRooms, AreDarkInAcuteCorners)
{
    for (const double degrees : {1.0, 4.0, 10.0, 14.0})
        for (const Scheme scheme : {Scheme::CatmullClark, Scheme::Bilinear})
            for (const float field : {1e-3f, 1e-5f})
                for (const IntegratorKind kind : kBoth) {
                    Look look{.integrator = kind, .place = Trs()};
                    look.place->rotation = glm::normalize(Vec4d(0.3, -0.2, 0.5, 0.7));
                    look.field = field;
                    SCOPED_TRACE(field);
                    expect_dark(wedge(degrees, scheme), look);
                }
}

/// A shadow ray starts beside the place where its parent saw the surface. It leads to the light all the same: one that kept
/// the direction from that place would end beside the light, within the room.
TEST(ClosedRooms, AreDarkThoughLightsAreJustOutside)
{
    EveryNth tested(3);
    for (const Room& room : rooms()) {
        if (room.name == "torus") continue;  // this is not convex
        const bool is_flat = room.name == "bilinear box" || room.name == "box with sharp edges";
        for (const Outside what : is_flat ? std::vector{Outside::Lamps, Outside::Panels} : std::vector{Outside::Lamps})
            for (const float rate : {1.0f, 8.0f})
                for (const render::Lod lod : {render::Lod::On, render::Lod::Off}) {
                    if (!tested.takes()) continue;
                    SCOPED_TRACE(what == Outside::Lamps ? "lamps" : "panels");
                    expect_dark(room, {.rate = rate, .lod = lod, .outside = what});
                }
    }
}

/// The rooms of these tests are dark because of their walls: a lamp inside lights them, also through veils.
TEST(ClosedRooms, AreLitFromInside)
{
    for (const Room& room : rooms())
        for (const bool is_veiled : {false, true}) {
            const Look look{.outside = Outside::LampInside, .veiled = is_veiled};
            EXPECT_EQ(lit_pixels(room, look), look.width * look.height) << room.name << (is_veiled ? ", veiled" : "");
        }
}

/// Where two cages cross, a ray that starts on one of them may start behind the other: its start is moved to the mesh of one
/// level, while its parent saw both cages between two levels. So it is moved to the level that is nearer at the hit. Few
/// pixels may be lit all the same, and none where there is one level only.
TEST(ClosedRooms, ThatCrossEachOtherLetLittleLightIn)
{
    int lit = 0, seen = 0;
    EveryNth tested(3);
    for (const Room& room : rooms())
        for (const float rate : {1.0f, 4.0f})
            for (const IntegratorKind kind : kBoth) {
                if (!tested.takes()) continue;
                Look look{.rate = rate, .integrator = kind, .crossed = true};
                for (const render::Lod lod : {render::Lod::On, render::Lod::Frozen}) {
                    look.lod = lod;
                    lit += lit_pixels(room, look);
                    seen += look.width * look.height;
                }
                look.lod = render::Lod::Off;
                EXPECT_EQ(lit_pixels(room, look), 0) << room.name << ", rate " << rate;
            }
    EXPECT_LE(lit, seen / 2000);
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
        fit_lengths(room.cage);
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
/// stretched, mirrored, displaced and instanced, with settings that are drawn at random, each apart from the others.
TEST(ClosedRooms, AreDarkForEveryMadeCageHoweverItIsPlaced)
{
    std::mt19937_64 random(8);
    int number = 0, tested = 0;
    Looks seen;
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
        fit_lengths(room.cage);
        const std::optional<Vec3d> eye = point_inside(room.cage, random);
        if (!eye) continue;
        room.eye = *eye;
        room.target = *eye + Vec3d(0.3, -0.1, 0.8);
        const Look look = random_look(random);
        expect_dark(room, look);
        seen.add(look);
        ++tested;
    }
    EXPECT_GE(tested, is_long() ? 25 : 6);
    seen.expect_all_kinds();
}

}  // namespace
}  // namespace occam::test
