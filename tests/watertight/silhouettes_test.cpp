// Tests of rays from inside that meet outlines of ridges, and of poles of very many faces, which are full of ridges.
#include <gtest/gtest.h>

#include "lod/topology_cache.h"
#include "tests/support/campaign.h"
#include "tests/support/shape_builders.h"
#include "verify/silhouettes.h"
#include "verify/verify.h"

namespace occam::test {
namespace {

/// A cage with flat faces, which rays see at one level.
class RayBesideOutline : public testing::Test {
protected:
    static constexpr float kRadius = 1.7322f;

    explicit RayBesideOutline(Cage cage = creased_cube(10))
    {
        place(scene_, scene_.add(std::move(cage)), {0, 0, 0});
        scene_.refit();
        levels_.pixel = {0.25, 0};
        levels_.mode = lod::LevelMode::PerInstance;
    }
    bool is_explained(Vec3d origin, Vec3f direction)
    {
        accel::Ray ray;
        ray.origin = origin;
        ray.direction = glm::normalize(direction);
        return Silhouettes(scene_, topologies_, levels_, nullptr, kRadius).explain(ray);
    }

    Scene scene_;
    lod::TopologyCache topologies_;
    lod::LevelSettings levels_;
};

TEST_F(RayBesideOutline, IsExplainedWhereOnlyBackSidesAreAround) { EXPECT_TRUE(is_explained({0, 0, 0}, {1, 0, 0})); }

TEST_F(RayBesideOutline, IsNotExplainedBeforeAFrontSide) { EXPECT_FALSE(is_explained({-3, 0.1, 0.2}, {1, 0, 0})); }

// Half of the rays around it hit the front side, and the others pass.
TEST_F(RayBesideOutline, IsNotExplainedAtTheOutlineSeenFromOutside)
{
    EXPECT_FALSE(is_explained({-3, 1, 0}, {1, 0, 0}));
    EXPECT_FALSE(is_explained({-3, 1, 1}, {1, 0, 0}));
}

/// A box of two units a side with a groove along the middle of its lower side, which reaches half-way up.
Cage box_with_groove(float width)
{
    Cage cage;
    // The profile in x and y is extruded along z.
    const float x = width / 2;
    const Vec2f profile[] = {{-1, -1}, {-x, -1}, {-x, 0}, {x, 0}, {x, -1}, {1, -1}, {1, 1}, {-1, 1}};
    constexpr std::uint32_t kCount = 8;
    for (const float z : {-1.0f, 1.0f})
        for (const Vec2f p : profile) cage.positions.push_back({p.x, p.y, z});
    const auto add = [&](std::initializer_list<std::uint32_t> face) {
        cage.face_vertices.insert(cage.face_vertices.end(), face);
        cage.face_sizes.push_back(static_cast<std::uint32_t>(face.size()));
    };
    for (std::uint32_t i = 0; i < kCount; ++i) {
        const std::uint32_t j = (i + 1) % kCount;
        add({i, i + kCount, j + kCount, j});
        cage.creases.push_back({i, i + kCount, 10});
        cage.creases.push_back({i, j, 10});
        cage.creases.push_back({i + kCount, j + kCount, 10});
    }
    add({0, 1, 2, 3, 4, 5, 6, 7});
    add({15, 14, 13, 12, 11, 10, 9, 8});
    return cage;
}

class RayInGroove : public RayBesideOutline {
protected:
    RayInGroove() : RayBesideOutline(box_with_groove(0x1p-19f)) {}
};

// The ray begins in the groove, outside of the box, and hits the end of it; the rays beside the groove begin inside the box.
TEST_F(RayInGroove, IsNotExplainedThoughTheGrooveIsNarrow) { EXPECT_FALSE(is_explained({0, -0.5, 0}, {0, 1, 0})); }

Cage pole(std::uint32_t valence, bool is_even)
{
    Cage cage = spindle(valence);
    for (std::size_t v = 2; is_even && v < cage.positions.size(); ++v) cage.positions[v].y = 0;
    return cage;
}

/// The limit surface around a pole has ridges that are the steeper the more faces there are (LargePoles.HaveRidges*), so
/// rays meet their outlines. No front side is wider than rounding.
/// far_alone   tests the cage far away only, unless the long form is run; otherwise at the origin only
void expect_no_front_side(const Cage& cage, const std::string& what, bool far_alone, int largest_rate = 8)
{
    Mat4d far(1);
    far[3] = Vec4d(1e5, 2e4, -1e5, 1);
    VerifySettings settings;
    settings.rays = is_long() ? 100'000 : 4096;
    settings.largest_rate = largest_rate;
    for (const Mat4d& place : {Mat4d(1), far}) {
        if (!is_long() && far_alone != (place == far)) continue;
        settings.overlap_ulps = place == Mat4d(1) ? 4.0f : 0.0f;
        const VerifiedCage found = verify(cage, place, settings);
        ASSERT_GT(found.rays, 0u) << what << ": " << found.not_testable;
        EXPECT_EQ(found.front_side, 0u) << what << ", of " << found.rays << " rays at " << place[3].x;
        EXPECT_EQ(found.escaped, 0u) << what << ", at " << place[3].x;
        EXPECT_EQ(found.not_finite, 0u) << what;
        EXPECT_LE(found.outside, found.rays / 10'000) << what;
        EXPECT_LE(found.silhouettes, found.rays / 50) << what;  // otherwise the test covers too little
    }
}

TEST(LevelsOfPoles, ShowNoFrontSideThatIsWiderThanRounding)
{
    for (const std::uint32_t valence : {50u, 500u})
        expect_no_front_side(pole(valence, valence < 500), "pole of " + std::to_string(valence), valence < 500);
    expect_no_front_side(prism(130), "faces of 130 corners, with creases", false);
}

TEST(LevelsOfPoles, WithCreasesShowNoFrontSideThatIsWiderThanRounding)
{
    Cage cage = pole(100, true);
    cage.creases = {{0, 2, 10}, {0, 9, 2.5f}, {2, 3, 2.5f}, {4, 1, 0.7f}, {3, 4, 10}};
    expect_no_front_side(cage, "creased pole of 100", true);
}

TEST(LevelsOfPoles, OfThousandsOfFacesShowNoFrontSideThatIsWiderThanRounding)
{
    if (!is_long()) GTEST_SKIP() << "it takes a minute";
    for (const std::uint32_t valence : {1000u, 2000u, 4090u})
        expect_no_front_side(pole(valence, true), "even pole of " + std::to_string(valence), false, 16);
    expect_no_front_side(pole(1000, false), "pole of 1000", false);
    expect_no_front_side(prism(500), "faces of 500 corners, with creases", false);
}

}  // namespace
}  // namespace occam::test
