#include "tests/support/reference_compare.h"

#include <gtest/gtest.h>

#include <cmath>

namespace occam::test {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Returns a picture that a wall at depth 2 fills, facing +z.
ReferencePicture wall(int width, int height)
{
    ReferencePicture p;
    p.width = width;
    p.height = height;
    const std::size_t n = p.pixel_count();
    p.depth.assign(n, 2);
    for (std::size_t i = 0; i < n; ++i) {
        p.normal_geometric.insert(p.normal_geometric.end(), {0, 0, 1});
        p.albedo.insert(p.albedo.end(), {0.5f, 0.25f, 0.125f, 1});
        p.uv.insert(p.uv.end(), {0.5f, 0.25f});
    }
    p.normal_shading = p.normal_geometric;
    return p;
}

TEST(ReferenceCompare, EqualPicturesAgreeEverywhere)
{
    const ReferenceShares s = compare(wall(6, 5), wall(6, 5), {});
    EXPECT_EQ(s.hits, 30u);
    EXPECT_EQ(s.interior, 12u) << "without the picture's border";
    EXPECT_EQ(s.coverage_mismatch, 0);
    for (const auto& share : {s.depth, s.normal_geometric, s.normal_shading, s.uv, s.albedo}) EXPECT_EQ(share, 1.0);
    EXPECT_EQ(s.albedo_mean_absolute, 0.0);
}

TEST(ReferenceCompare, WhatTheReferenceDoesNotHaveIsNotCompared)
{
    ReferencePicture reference = wall(5, 5);
    reference.normal_shading.clear();
    reference.albedo.clear();
    reference.uv.clear();
    const ReferenceShares s = compare(wall(5, 5), reference, {});
    EXPECT_FALSE(s.normal_shading || s.uv || s.albedo || s.albedo_mean_absolute);
    EXPECT_EQ(s.normal_geometric, 1.0);
}

TEST(ReferenceCompare, InteriorEndsAtMissesStepsAndLeftOutPixels)
{
    ReferencePicture p = wall(12, 3);  // one inner row: x = 1 to 10
    p.depth[2] = 0;                    // x = 1, 2, 3
    p.depth[2 * 12 + 7] = 2.11f;       // x = 6, 7, 8: a factor of 1.055
    p.exclude.assign(p.pixel_count(), 0);
    p.exclude[12 + 10] = 1;  // only this pixel
    const auto interior = interior_pixels(p);
    for (std::size_t x = 0; x < 12; ++x) EXPECT_EQ(interior[12 + x], x == 4 || x == 5 || x == 9) << x;
    p.depth[2 * 12 + 7] = 2.09f;
    EXPECT_EQ(interior_pixels(p)[12 + 7], 1) << "a factor of 1.045";
}

TEST(ReferenceCompare, CoverageCountsBothWaysOverTheHitsOfTheReference)
{
    ReferencePicture reference = wall(10, 10), ours = wall(10, 10);
    for (std::size_t i = 0; i < 20; ++i) reference.depth[i] = 0;
    for (std::size_t i = 0; i < 17; ++i) ours.depth[i] = kInfinity;  // three hits too many
    ours.depth[99] = kInfinity;                                      // and one too few
    EXPECT_DOUBLE_EQ(compare(ours, reference, {}).coverage_mismatch, 4.0 / 80);
    reference.exclude.assign(100, 0);
    reference.exclude[99] = 1;
    EXPECT_DOUBLE_EQ(compare(ours, reference, {}).coverage_mismatch, 3.0 / 79);
}

// Of 16 interior pixels of 6 x 6, four are changed to just within or just outside each limit.
TEST(ReferenceCompare, SharesFollowTheLimits)
{
    const ReferencePicture reference = wall(6, 6);
    const ReferenceLimits limits{
        .depth_relative = 1e-3, .normal_geometric_degrees = 1, .normal_shading_degrees = 2, .uv_absolute = 2e-3};
    const auto changed = [&](double part) {
        ReferencePicture p = reference;
        for (std::size_t i = 7; i < 11; ++i) {
            const auto tilted = [&](double degrees, std::vector<float>& normals) {
                normals[3 * i] = float(3 * std::sin(degrees * 0.017453292519943295));  // lengths do not matter
                normals[3 * i + 2] = float(3 * std::cos(degrees * 0.017453292519943295));
            };
            p.depth[i] = float(2 * (1 - part * 1e-3));
            tilted(part * 1, p.normal_geometric);
            tilted(part * 2, p.normal_shading);
            p.uv[2 * i + 1] += float(part * 2e-3);
            p.albedo[4 * i + 2] -= float(part * 0.05);
        }
        return compare(p, reference, limits);
    };
    const ReferenceShares within = changed(0.99), outside = changed(1.01);
    for (const auto& share : {within.depth, within.normal_geometric, within.normal_shading, within.uv, within.albedo})
        EXPECT_EQ(share, 1.0);
    for (const auto& share : {outside.depth, outside.normal_geometric, outside.normal_shading, outside.uv, outside.albedo})
        EXPECT_EQ(share, 0.75);
    EXPECT_NEAR(*outside.albedo_mean_absolute, 4 * 1.01 * 0.05 / 48, 1e-8);
}

TEST(ReferenceCompare, MissesAndWhatIsNoNumberDisagree)
{
    const ReferencePicture reference = wall(4, 4);  // four interior pixels: 5, 6, 9, 10
    ReferencePicture ours = reference;
    ours.depth[5] = kInfinity;
    ours.depth[6] = NAN;
    for (std::size_t c = 0; c < 3; ++c) ours.normal_geometric[3 * 9 + c] = 0;
    ours.normal_shading[3 * 9] = NAN;
    ours.uv[2 * 9] = NAN;
    const ReferenceShares s = compare(ours, reference, {});
    EXPECT_EQ(s.depth, 0.5);
    for (const auto& share : {s.normal_geometric, s.normal_shading, s.uv}) EXPECT_EQ(share, 0.25);
}

TEST(ReferenceCompare, NormalsUnknownToTheReferenceAreLeftOut)
{
    ReferencePicture reference = wall(4, 4), ours = reference;
    for (std::size_t c = 0; c < 3; ++c) reference.normal_shading[3 * 5 + c] = 0;
    ours.normal_shading[3 * 6 + 2] = -1;
    EXPECT_NEAR(*compare(ours, reference, {}).normal_shading, 2.0 / 3, 1e-12);
}

}  // namespace
}  // namespace occam::test
