#include "io/builtin/pieces.h"

#include "base/maths.h"
#include "io/builtin/panelled_ball.h"
#include "io/builtin/shapes.h"

namespace occam::builtin {
namespace {

using maths::kPi;

constexpr float kSharp = kInfiniteSharpness;

/// Describes a circle on a path in the plane z = 0.
struct Bead {
    Vec2f at;
    float radius;
};

// Returns rings perpendicular to the path through the beads.
std::vector<Ring> strung(const std::vector<Bead>& beads)
{
    std::vector<Ring> rings;
    for (std::size_t i = 0; i < beads.size(); ++i) {
        const Vec2f before = beads[i > 0 ? i - 1 : 0].at, after = beads[i + 1 < beads.size() ? i + 1 : i].at;
        const Vec2f along = glm::normalize(after - before);
        rings.push_back(
            {Vec3f(beads[i].at, 0), Vec3f(-along.y, along.x, 0) * beads[i].radius, Vec3f(0, 0, beads[i].radius)});
    }
    return rings;
}

Cage spout()
{
    std::vector<Ring> rings = strung({{{0.62f, 0.40f}, 0.30f},
                                      {{0.95f, 0.44f}, 0.25f},
                                      {{1.22f, 0.62f}, 0.17f},
                                      {{1.38f, 0.88f}, 0.125f},
                                      {{1.52f, 1.12f}, 0.11f},
                                      {{1.72f, 1.25f}, 0.12f}});
    // The profile goes over the rim and back inside.
    const auto inner = [&](std::size_t of, float share) {
        return Ring{rings[of].centre, rings[of].x * share, rings[of].y * share, 0};
    };
    rings.back().sharpness = 1.5f;
    for (const Ring& r : {inner(5, 0.72f), inner(4, 0.6f), inner(3, 0.5f)}) rings.push_back(r);
    return tube("teapot spout", rings, 8, Cap::Face, Cap::Face);
}

Cage handle()
{
    return tube("teapot handle",
                strung({{{-0.70f, 0.98f}, 0.08f},
                        {{-0.95f, 1.05f}, 0.09f},
                        {{-1.30f, 1.10f}, 0.10f},
                        {{-1.58f, 0.95f}, 0.10f},
                        {{-1.62f, 0.68f}, 0.10f},
                        {{-1.42f, 0.42f}, 0.09f},
                        {{-1.05f, 0.30f}, 0.08f},
                        {{-0.80f, 0.28f}, 0.08f}}),
                6, Cap::Face, Cap::Face);
}

}  // namespace

Cage vase()
{
    return lathe("vase",
                 {{0.44f, 0, kSharp},
                  {0.50f, 0.10f, 1},
                  {0.72f, 0.50f},
                  {0.99f, 1.10f},
                  {0.99f, 1.60f},
                  {0.70f, 2.15f},
                  {0.36f, 2.50f},
                  {0.32f, 2.80f},
                  {0.48f, 3.05f},
                  {0.58f, 3.12f, 2},
                  {0.50f, 3.12f, 1},
                  {0.25f, 2.80f},
                  {0.29f, 2.45f},
                  {0.60f, 2.05f}},
                 16, Cap::Face, Cap::Point);
}

Cage pawn()
{
    return lathe("pawn",
                 {{0.52f, 0, kSharp},
                  {0.52f, 0.13f, 1.5f},
                  {0.43f, 0.18f, 3},
                  {0.42f, 0.26f, 1.5f},
                  {0.27f, 0.40f},
                  {0.20f, 0.64f},
                  {0.17f, 0.84f, 2},
                  {0.31f, 0.90f, 2.5f},
                  {0.31f, 0.96f, 2.5f},
                  {0.17f, 1.01f, 2},
                  {0.27f, 1.13f},
                  {0.32f, 1.30f},
                  {0.24f, 1.48f},
                  {0.09f, 1.54f}},
                 12, Cap::Face, Cap::Point);
}

std::vector<Cage> teapot()
{
    std::vector<Cage> parts;
    parts.push_back(lathe("teapot body",
                          {{0.56f, 0, kSharp},
                           {0.60f, 0.08f, 2},
                           {0.98f, 0.30f},
                           {1.14f, 0.66f},
                           {0.98f, 1.02f},
                           {0.60f, 1.22f},
                           {0.50f, 1.24f, 2},
                           {0.46f, 1.16f},
                           {0.60f, 0.95f}},
                          12, Cap::Face, Cap::Point));
    parts.push_back(lathe("teapot lid",
                          {{0.42f, 1.16f},
                           {0.46f, 1.22f, 1},
                           {0.52f, 1.25f, 2},
                           {0.48f, 1.30f, 1},
                           {0.22f, 1.40f},
                           {0.09f, 1.45f},
                           {0.09f, 1.52f},
                           {0.18f, 1.60f},
                           {0.16f, 1.71f},
                           {0.05f, 1.75f}},
                          12, Cap::Face, Cap::Point));
    parts.push_back(spout());
    parts.push_back(handle());
    return parts;
}

Cage knot()
{
    constexpr std::uint32_t kRings = 72;
    constexpr float kAbout = 0.62f, kWinding = 0.27f, kThick = 0.145f;
    const auto point = [](float angle) {
        const float out = kAbout + kWinding * maths::cos(3 * angle);
        return Vec3f(out * maths::cos(2 * angle), kWinding * maths::sin(3 * angle), out * maths::sin(2 * angle));
    };
    std::vector<Ring> rings;
    for (std::uint32_t i = 0; i < kRings; ++i) {
        const float angle = 2 * kPi * float(i) / kRings;
        // The frames follow the torus that the knot winds around, so that the last frame meets the first.
        const Vec3f core(kAbout * maths::cos(2 * angle), 0, kAbout * maths::sin(2 * angle)), at = point(angle);
        const Vec3f along = glm::normalize(point(angle + 1e-2f) - point(angle - 1e-2f));
        const Vec3f away = at - core;
        const Vec3f x = glm::normalize(away - along * glm::dot(along, away));
        rings.push_back({at, x * kThick, glm::cross(along, x) * kThick});
    }
    return closed_tube("knot", rings, 8);
}

std::vector<Cage> closed_pieces()
{
    std::vector<Cage> all = teapot();
    all.push_back(vase());
    all.push_back(pawn());
    all.push_back(knot());
    all.push_back(panelled_ball("ball", 0.6f, 0.04f, 2));
    all.push_back(box("block", Vec3f(0.95f), 0.2f, 1.5f));
    all.push_back(jack("jack", 0.4f, 0.15f));
    return all;
}

}  // namespace occam::builtin
