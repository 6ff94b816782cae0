// Tests of boxes at keys of an interval of the shutter (accel/keyed_boxes.h).
#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <vector>

#include "accel/keyed_boxes.h"

namespace occam::accel {
namespace {

// Returns the keys of a part of a shutter with so many segments, as Bvh has them.
KeySpan keys_of(int segments, float begin, float end)
{
    const int own = std::max(1, static_cast<int>((end - begin) * float(segments)));
    return {own, begin, float(own) / (end - begin)};
}

// Returns one group of eight boxes at each key, all of them [key, key + 1] along each axis, and as many groups again after
// the last key, which belong to something else and hold everything.
std::vector<float> groups_of(const KeySpan& keys)
{
    std::vector<float> boxes;
    for (int key = 0; key <= keys.segments; ++key) {
        boxes.insert(boxes.end(), kBoxGroupFloats / 2, float(key));
        boxes.insert(boxes.end(), kBoxGroupFloats / 2, float(key + 1));
    }
    for (int key = 0; key <= keys.segments; ++key) {
        boxes.insert(boxes.end(), kBoxGroupFloats / 2, -FLT_MAX);
        boxes.insert(boxes.end(), kBoxGroupFloats / 2, FLT_MAX);
    }
    return boxes;
}

// A packet may have rays of both halves of a halved interval. Those outside of a half see its boxes at its nearer end.
TEST(KeyedBoxes, OfAnIntervalAreReadWithinItsKeysAtAnyTimesOfRays)
{
    for (const int segments : {1, 2, 4, 8, 16, 32})
        for (int parts = 1; parts <= 64; parts *= 2)
            for (int part = 0; part < parts; ++part) {
                const float begin = float(part) / float(parts), end = float(part + 1) / float(parts);
                const KeySpan keys = keys_of(segments, begin, end);
                const std::vector<float> boxes = groups_of(keys);
                for (const auto& [first, last] : {std::pair(0.0f, 1.0f), {0.25f, 0.75f}, {0.75f, 0.875f}, {0.0f, 0.125f}}) {
                    alignas(32) float at[kLanes];
                    std::fill(std::begin(at), std::end(at), first);
                    at[kLanes - 1] = last;
                    const RayTimes<vfloat> times(vfloat::load(at), segments);
                    alignas(32) float swept[kBoxGroupFloats];
                    KeyedBoxes<vfloat>(boxes.data(), kBoxGroupFloats, keys, times).sweep(swept);
                    const auto expected = [&](float time) { return (std::clamp(time, begin, end) - begin) * keys.per_time; };
                    EXPECT_FLOAT_EQ(swept[0], expected(at[0])) << segments << " segments, " << begin << " to " << end;
                    EXPECT_FLOAT_EQ(swept[kBoxGroupFloats - 1], expected(last) + 1)
                        << segments << " segments, " << begin << " to " << end;
                }
            }
}

}  // namespace
}  // namespace occam::accel
