// Tests of what is written of the types that a person debugs.
#include <gtest/gtest.h>

#include <sstream>

#include "accel/print.h"

namespace occam {
namespace {

template <class T>
std::string text_of(const T& value)
{
    std::ostringstream out;
    out << value;
    return out.str();
}

TEST(Print, TypesThatAPersonDebugsAreReadable)
{
    EXPECT_EQ(text_of(Vec3f(1, -0.5f, 3)), "(1, -0.5, 3)");
    EXPECT_EQ(text_of(Vec2d(1, 2)), "(1, 2)");
    EXPECT_EQ(text_of(Box3f()), "an empty box");
    EXPECT_EQ(text_of(Box3d{Vec3d(0), Vec3d(1)}), "(0, 0, 0) to (1, 1, 1)");
    EXPECT_EQ(text_of(NodeId()), "none");
    EXPECT_EQ(text_of(NodeId{4, 2}), "4.2");
    EXPECT_EQ(text_of(lod::Footprint{0.5f, -0.25f}), "0.5 - 0.25 t");
    EXPECT_EQ(text_of(lod::PatchRef{3, 1}), "patch 1 of face 3");
    EXPECT_EQ(text_of(lod::TileRef{{3, 1}, {}, 16, 0, 8, 4}), "8 x 4 quads from (16, 0) of patch 1 of face 3");
    EXPECT_EQ(text_of(accel::PairRange{-3, -1}), "-3 to -1");
    EXPECT_EQ(text_of(accel::PairRange{2, 2}), "2");
    EXPECT_EQ(text_of(accel::PairRange{1, 0}), "none");
    EXPECT_EQ(text_of(accel::QuadRef{1, 2, 0}), "triangle 0 of quad (1, 2)");
    EXPECT_EQ(text_of(accel::SurfaceHit()), "no hit");
    EXPECT_EQ(text_of(accel::FirstHit()), "no hit");
    accel::Ray ray;
    ray.time = 0.5f;
    EXPECT_EQ(text_of(ray),
              "origin (0, 0, 0), direction (0, 0, -1), t from 0 to inf, footprint 0 + 0 t, time 0.5, kinds 31");
}

}  // namespace
}  // namespace occam
