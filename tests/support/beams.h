// Widths of rays for tests of their tables of transitions.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "lod/ray_levels.h"

namespace occam::test {

inline constexpr float kFar = lod::RayLevels<float>::kFar;

/// A width a + b t and the part of the ray that is in the scene; see lod::RayWidth for `start` and `focus`.
struct Beam {
    float a, b, t_end, t_in = 0, start = 0, focus = 0;
};

/// Returns the table of a beam.
inline lod::RayLevels<float> table_of(const Beam& beam, const lod::LevelSettings& settings)
{
    lod::RayLevels<float> table;
    EXPECT_TRUE(table.set({beam.a, beam.b, beam.start, beam.focus}, beam.t_in, beam.t_end, beam.t_end, settings));
    table.make();
    return table;
}

/// Returns beams that widen, narrow and keep their width, over many sizes.
inline std::vector<Beam> beams(int count)
{
    std::mt19937_64 random(3);
    const auto uniform = [&](double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; };
    std::vector<Beam> all{{1, 0, 10},      {0, 0.01f, 100}, {0, 0.5f, 1e6f}, {1, -0.01f, 100},
                          {1, -0.5f, 100}, {0, 0, 10},      {1e-20f, 0, 10}, {1e20f, 0, 10}};
    for (int i = 0; i < count; ++i) {
        const double b = std::exp2(uniform(-12, -1)), end = std::exp2(uniform(-3, 12)),
                     a = random() & 1 ? 0 : std::exp2(uniform(-8, 8));
        all.push_back({float(a), float(random() & 1 ? b : -b), float(end)});
    }
    return all;
}

/// Returns the same beams, each from a point of a mesh whose edges are about as long as the beam asks for, or much finer.
inline std::vector<Beam> beams_with_starts(int count)
{
    std::vector<Beam> all = beams(count);
    for (std::size_t i = 0; i < all.size(); ++i) {
        const float width = std::max(all[i].a, 1e-3f);
        const int level = std::ilogb(width) + static_cast<int>(i % 5) - 3;
        all[i].start = lod::edge_length(std::clamp(level, lod::kFinestLevel, lod::kCoarsestLevel));
    }
    return all;
}

/// Returns beams that narrow up to a focus and end there, and beams that widen from there on, each with the level of its
/// width at the focus, or of one beside it. For a beam that widens, `a` is below 0.
inline std::vector<Beam> beams_with_a_focus(int count)
{
    std::mt19937_64 random(5);
    const auto uniform = [&](double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; };
    std::vector<Beam> all;
    for (int i = 0; i < count; ++i) {
        const double b = std::exp2(uniform(-12, 1)), width = std::exp2(uniform(-8, 2)), focus = std::exp2(uniform(-3, 8));
        const float start = lod::edge_length(std::ilogb(width) + int(random() % 3) - 1);
        const auto at_focus = static_cast<float>(focus);
        all.push_back({float(width + b * focus), float(-b), at_focus, 0, start, at_focus});
        all.push_back({float(width - b * focus), float(b), at_focus * float(uniform(1.1, 50)), at_focus, start, at_focus});
    }
    return all;
}

/// Returns beams whose width at an end is a power of two, or an ulp or two beside it: rounding then places a transition
/// there or not.
inline std::vector<Beam> beams_with_ends_at_levels(int count)
{
    std::mt19937_64 random(11);
    const auto uniform = [&](double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; };
    std::vector<Beam> all;
    while (all.size() < std::size_t(count)) {
        const auto b = static_cast<float>(std::exp2(uniform(-12, -1)) * (random() & 1 ? 1 : -1));
        float at_end = std::exp2(static_cast<float>(int(random() % 8) - 4));
        for (int ulps = int(random() % 5) - 2; ulps != 0; ulps += ulps < 0 ? 1 : -1)
            at_end = std::nextafterf(at_end, ulps < 0 ? 0.0f : kFar);
        const auto end = static_cast<float>(std::exp2(uniform(-3, 6)));
        const float a = at_end - b * end;
        if (a > 0) all.push_back({a, b, end});
    }
    return all;
}

}  // namespace occam::test
