// Tests of the kernels of rays and micropolygons, number by number.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "accel/triangle.h"
#include "base/simd_groups.h"

namespace occam::test {
namespace {

using accel::ShearedVertex;

struct Lanes {
    float at[kLanes];
    explicit Lanes(vfloat x) { x.store(at); }
};

// A quad whose triangles share edge functions gives the same bits as two triangles with edge functions of their own, even
// where vertices coincide, lie on the ray, or are so far away that products overflow.
TEST(Triangle, AQuadHasTheBitsOfItsTwoTriangles)
{
    std::mt19937 random(3);
    std::uniform_real_distribution<float> near(-1, 1);
    accel::RayLanes ray{};
    ray.shift = 0.25f;
    int hits = 0, misses = 0;
    for (int n = 0; n < 20'000; ++n) {
        float corner[4][3][kLanes];
        for (auto& of : corner)
            for (auto& axis : of)
                for (float& x : axis) x = near(random);
        for (int lane = 0; lane < kLanes; ++lane) switch (random() % 8) {
                case 0:
                    corner[1][0][lane] = corner[0][0][lane], corner[1][1][lane] = corner[0][1][lane];
                    break;
                case 1:
                    corner[3][0][lane] = corner[0][0][lane], corner[3][1][lane] = corner[0][1][lane];
                    break;
                case 2:
                    corner[random() % 4][0][lane] = 0;
                    break;
                case 3:
                    corner[random() % 4][0][lane] = corner[random() % 4][1][lane] = 0;
                    break;
                case 4:
                    for (auto& of : corner) of[1][lane] = of[0][lane];
                    break;
                case 5:
                    corner[random() % 4][0][lane] = 3e38f, corner[random() % 4][1][lane] = -3e38f;
                    break;
                default:
                    break;
            }
        ShearedVertex v[4];
        for (int c = 0; c < 4; ++c)
            v[c] = {vfloat::load(corner[c][0]), vfloat::load(corner[c][1]), vfloat::load(corner[c][2])};
        const auto& [v00, v10, v01, v11] = v;
        const accel::TriangleHit alone[2] = {intersect(ray, v00, v10, v11), intersect(ray, v00, v11, v01)};
        accel::TriangleHit shared[2] = {{vmask(false), 0.0f}, {vmask(false), 0.0f}};
        intersect_quad(ray, {v00, v10, v01, v11}, {{v00, v01}, {v10, v11}, {v10, v00}, {v11, v01}},
                       [&](const accel::TriangleHit& hit, int triangle) { shared[triangle] = hit; });
        for (int t = 0; t < 2; ++t) {
            ASSERT_EQ(bits(alone[t].is_hit), bits(shared[t].is_hit)) << "quad " << n << ", triangle " << t;
            const Lanes a(alone[t].t), b(shared[t].t);
            for (int lane = 0; lane < kLanes; ++lane) {
                const bool is_hit = bits(alone[t].is_hit) >> lane & 1;
                (is_hit ? hits : misses) += 1;
                if (is_hit) {
                    ASSERT_EQ(std::bit_cast<std::uint32_t>(a.at[lane]), std::bit_cast<std::uint32_t>(b.at[lane]))
                        << "quad " << n;
                }
            }
        }
    }
    EXPECT_GT(hits, 1000);
    EXPECT_GT(misses, 1000);
}

// Several vfloats used as one do what each would do by itself, for NaN too, and return the least and the greatest of all.
TEST(SimdGroups, AreTheirParts)
{
    constexpr int kParts = 2, kAll = kParts * kLanes;
    std::mt19937 random(5);
    std::uniform_real_distribution<float> near(-2, 2);
    for (int n = 0; n < 1000; ++n) {
        float x[kAll], y[kAll];
        for (int i = 0; i < kAll; ++i) x[i] = near(random), y[i] = near(random);
        const auto a = vfloats<kParts>::load(x);
        EXPECT_EQ(lowest(a), *std::min_element(x, x + kAll));
        EXPECT_EQ(highest(a), *std::max_element(x, x + kAll));
        if (n % 2 == 1) {
            x[random() % kAll] = std::numeric_limits<float>::quiet_NaN();
            y[random() % kAll] = std::numeric_limits<float>::quiet_NaN();
        }
        const auto c = vfloats<kParts>::load(x), d = vfloats<kParts>::load(y);
        const auto expect = [&](const char* what, const vfloats<kParts>& all, auto&& one) {
            float found[kAll];
            all.store(found);
            for (int i = 0; i < kAll; ++i) {
                const float wanted = Lanes(one(vfloat(x[i]), vfloat(y[i]))).at[0];
                ASSERT_EQ(std::isnan(found[i]), std::isnan(wanted)) << what;
                if (!std::isnan(wanted)) {
                    ASSERT_EQ(std::bit_cast<std::uint32_t>(found[i]), std::bit_cast<std::uint32_t>(wanted)) << what;
                }
            }
        };
        expect("+", c + d, [](vfloat p, vfloat q) { return p + q; });
        expect("-", c - d, [](vfloat p, vfloat q) { return p - q; });
        expect("*", c * d, [](vfloat p, vfloat q) { return p * q; });
        expect("/", c / d, [](vfloat p, vfloat q) { return p / q; });
        expect("min", min(c, d), [](vfloat p, vfloat q) { return min(p, q); });
        expect("max", max(c, d), [](vfloat p, vfloat q) { return max(p, q); });
        expect("abs", abs(c), [](vfloat p, vfloat) { return abs(p); });
        expect("fma", fma(c, d, c), [](vfloat p, vfloat q) { return fma(p, q, p); });
        expect("select", select(c < d, c, d), [](vfloat p, vfloat q) { return select(p < q, p, q); });
        unsigned less = 0, at_most = 0;
        for (int i = 0; i < kAll; ++i) {
            less |= unsigned(x[i] < y[i]) << i;
            at_most |= unsigned(x[i] <= y[i]) << i;
        }
        EXPECT_EQ(bits(c < d), less);
        EXPECT_EQ(bits(d > c), less);
        EXPECT_EQ(bits(c <= d), at_most);
        EXPECT_EQ(bits(d >= c), at_most);
        EXPECT_EQ(bits((c < d) & (d <= c)), 0u);
        EXPECT_EQ(bits((c < d) | (c <= d)), at_most);
        EXPECT_EQ(bits(andnot(c <= d, c < d)), at_most & ~less);
        EXPECT_EQ(any(c < d), less != 0);
        EXPECT_EQ(none(c < d), less == 0);
    }
}

// Values are transposed and transposed back. In between, lane i of vector f holds field f of element i, wherever elements
// lie.
TEST(SimdTurned, LanesAreThingsThereAndBack)
{
    constexpr std::size_t kStride = 7, kOffset = 3;
    float from[kLanes * kStride], to[kLanes * kStride]{};
    for (std::size_t i = 0; i < std::size(from); ++i) from[i] = 0.5f + float(i);
    const float* read[kLanes];
    float* written[kLanes];
    for (std::size_t i = 0; i < kLanes; ++i) {
        read[i] = from + i * kStride + kOffset;
        written[i] = to + (kLanes - 1 - i) * kStride;
    }
    vfloat fours[4];
    load_turned(read, fours);
    for (std::size_t f = 0; f < 4; ++f)
        for (std::size_t i = 0; i < kLanes; ++i) EXPECT_EQ(Lanes(fours[f]).at[i], read[i][f]);
    store_turned(fours, written, kOffset);
    for (std::size_t i = 0; i < kLanes; ++i)
        for (std::size_t f = 0; f < kStride; ++f) EXPECT_EQ(written[i][f], f < kOffset ? 0 : read[i][f - kOffset]);
}

}  // namespace
}  // namespace occam::test
