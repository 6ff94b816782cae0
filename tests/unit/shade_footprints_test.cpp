// Tests of the footprints of secondary rays beside finite differences of two neighbouring rays that are reflected or
// refracted exactly.
#include "shade/footprints.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/vec.h"

namespace occam::shade {
namespace {

lod::Footprint light_beam(float width, float distance, float density, int samples)
{
    return {width, light_spread(width, distance, density, static_cast<float>(samples))};
}

constexpr float kRadius = 2;

struct Pair {
    Vec3d p, q, dp, dq;  // the points at which two rays of one beam leave the ball, and their directions
};

// Returns two rays at a ball about the origin. A ray in the plane z = 0 hits it at the angle of incidence; the second ray of
// the beam is offset and turned along z, across the plane of incidence.
Pair rays_at_ball(double angle, double offset, double spread, bool hollow)
{
    const double side = hollow ? -1 : 1;
    const Vec3d at(0, kRadius, 0), d = glm::normalize(Vec3d(std::sin(angle), -side * std::cos(angle), 0));
    const Vec3d origin = at - d * 1.0;
    const Vec3d other_origin = origin + Vec3d(0, 0, offset - spread), other = glm::normalize(d + Vec3d(0, 0, spread));
    const double b = glm::dot(other_origin, other), c = glm::dot(other_origin, other_origin) - kRadius * kRadius;
    const double root = std::sqrt(b * b - c);
    const double t = hollow ? -b + root : -b - root;
    return {at, other_origin + other * t, d, other};
}

Vec3d towards(Vec3d normal, Vec3d d) { return glm::dot(normal, d) < 0 ? normal : -normal; }
Vec3d mirror(Vec3d d, Vec3d n) { return d - n * (2 * glm::dot(d, n)); }
Vec3d bend(Vec3d d, Vec3d n, double eta)
{
    const double c = -glm::dot(d, n);
    return d / eta + n * (c / eta - std::sqrt(1 - (1 - c * c) / (eta * eta)));
}

constexpr double kOffset = 1e-5;

TEST(Footprints, AMirrorSpreadsABeamAsItsNeighboursSay)
{
    for (const bool hollow : {false, true})
        for (const double angle : {0.0, 0.4, 1.0})
            for (const double spread : {0.0, 0.3, 2.0}) {
                const Pair r = rays_at_ball(angle, kOffset, spread * kOffset, hollow);
                const Vec3d n0 = towards(glm::normalize(r.p), r.dp), n1 = towards(glm::normalize(r.q), r.dq);
                const double measured = (mirror(r.dq, n1).z - mirror(r.dp, n0).z) / (r.q.z - r.p.z);
                const float w = 0.01f;
                const auto f = mirrored_beam({w, float(spread) * w}, (hollow ? -1.0f : 1.0f) / kRadius,
                                             float(std::cos(angle)));
                EXPECT_EQ(f.a, w);
                EXPECT_NEAR(double(f.b / w), std::max(0.0, measured), 2e-4) << angle << ' ' << spread << ' ' << hollow;
            }
}

TEST(Footprints, ALensSpreadsABeamAsItsNeighboursSay)
{
    for (const bool hollow : {false, true})
        for (const double eta : {1.5, 1 / 1.5})
            for (const double angle : {0.0, 0.3, 0.6})
                for (const double spread : {0.0, 2.0}) {
                    const Pair r = rays_at_ball(angle, kOffset, spread * kOffset, hollow);
                    const Vec3d n0 = towards(glm::normalize(r.p), r.dp), n1 = towards(glm::normalize(r.q), r.dq);
                    const Vec3d out = bend(r.dp, n0, eta);
                    const double measured = (bend(r.dq, n1, eta).z - out.z) / (r.q.z - r.p.z);
                    const float w = 0.01f;
                    const auto f = refracted_footprint({w, float(spread) * w}, (hollow ? -1.0f : 1.0f) / kRadius,
                                                       float(std::cos(angle)), float(-glm::dot(out, n0)), float(eta));
                    EXPECT_NEAR(double(f.b / w), std::max(0.0, measured), 2e-4) << angle << ' ' << eta << ' ' << hollow;
                }
}

// 64 samples of a uniform hemisphere share a solid angle of 2 pi.
TEST(Footprints, AStratumIsTheRootOfItsSolidAngle)
{
    const float density = 1 / 6.2831853f;
    EXPECT_NEAR(scattered_beam({0.1f, 0}, density, 64).b, std::sqrt(6.2831853f / 64), 1e-5f);
    EXPECT_NEAR(scattered_beam({0.1f, 3e-2f}, 1e12f, 64).b, 3e-2f, 1e-5f) << "a mirror's own spread stays";
    EXPECT_LE(scattered_beam({0.1f, 0}, 0, 1).b, 2.51f) << "never more than a hemisphere";
}

TEST(Footprints, ABeamToALightEndsAsWideAsTheLightsShare)
{
    // For a light of area 4 that is seen from above at distance 8, 1 / density is 4 / 64.
    const auto f = light_beam(0.01f, 8, 16, 4);
    EXPECT_EQ(f.at(0), 0.01f);
    EXPECT_NEAR(f.at(8), std::sqrt(4.0f / 4), 1e-4f) << "the side of a fourth of the light";
    const auto point = light_beam(0.8f, 8, 0, 4);
    EXPECT_NEAR(point.at(8), 0.1f, 1e-6f) << "narrowing, but not to nothing";
    EXPECT_EQ(light_beam(0.5f, std::numeric_limits<float>::infinity(), 0, 1).at(100), 0.5f) << "parallel light";
}

TEST(Footprints, ALensIsSharpAtItsFocusAlone)
{
    const LensBeams beams = lens_beams({0, 1e-3f}, 0.4f, 5, 16);
    EXPECT_NEAR(beams.near_side.at(0), 0.1f, 1e-6f);
    EXPECT_NEAR(beams.near_side.at(5), 5e-3f, 1e-6f);
    EXPECT_NEAR(beams.far_side.at(5), 5e-3f, 1e-6f);
    EXPECT_NEAR(beams.far_side.at(10), 0.1f + 1e-2f, 1e-6f);
}

}  // namespace
}  // namespace occam::shade
