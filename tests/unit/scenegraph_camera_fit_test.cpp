#include "scenegraph/camera_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.h"

namespace occam {
namespace {

// Returns where a point lies in the picture; both coordinates are from -1 to 1 inside the picture.
Vec2d in_picture(const Camera& camera, double aspect, Vec3d p)
{
    const double k = std::tan(double(camera.lens.fov) / 2);
    const Vec3d d = p - camera.eye();
    const double depth = -glm::dot(d, Vec3d(camera.world_from_camera[2]));
    EXPECT_GT(depth, 0);
    return {glm::dot(d, Vec3d(camera.world_from_camera[0])) / (depth * k * aspect),
            glm::dot(d, Vec3d(camera.world_from_camera[1])) / (depth * k)};
}

TEST(Camera, AFitTouchesTwoOppositeSidesAndNoPointIsOutside)
{
    const std::vector<Vec3d> points{{1e5, 2, 5}, {1e5 + 4, 3, 9}, {1e5 - 1, 2.5, 7}, {1e5 + 2, 9, 8}};
    for (const ViewFrom side :
         {ViewFrom::ThreeQuarter, ViewFrom::Front, ViewFrom::Side, ViewFrom::Back, ViewFrom::Top, ViewFrom::Bottom})
        for (const Vec3d up : {Vec3d(0, 1, 0), Vec3d(0, 0, 1), Vec3d(1, 0, 0), Vec3d(1, 2, 3)})
            for (const float aspect : {0.5f, 1.0f, 2.0f}) {
                CameraFit fit(side, up, 0.6f, aspect);
                for (const Vec3d p : points) fit.add(p);
                fit.add(Vec3d(std::nan(""), 0, 0));
                const Camera camera = fit.camera();
                Vec2d lo(9), hi(-9);
                for (const Vec3d p : points) {
                    const Vec2d at = in_picture(camera, double(aspect), p);
                    lo = glm::min(lo, at), hi = glm::max(hi, at);
                }
                const double width = hi.x - lo.x, height = hi.y - lo.y;
                EXPECT_LE(std::max({-lo.x, -lo.y, hi.x, hi.y}), 0.95);
                EXPECT_GT(std::max(width, height), 1.8) << int(side);
            }
}

TEST(Camera, AFitLooksFromTheSideThatFilesFace)
{
    const auto eye = [](ViewFrom side, Vec3d up) {
        CameraFit fit(side, up, 0.6f, 1);
        fit.add(Vec3d(0));
        return fit.camera();
    };
    EXPECT_EQ(eye(ViewFrom::Front, {0, 1, 0}).eye(), Vec3d(0, 0, 1));   // the convention of glTF
    EXPECT_EQ(eye(ViewFrom::Front, {0, 0, 2}).eye(), Vec3d(0, -1, 0));  // z is up
    EXPECT_EQ(eye(ViewFrom::Side, {0, 1, 0}).eye(), Vec3d(1, 0, 0));
    EXPECT_EQ(eye(ViewFrom::Side, {0, 0, 1}).eye(), Vec3d(1, 0, 0));
    EXPECT_EQ(eye(ViewFrom::Back, {0, 0, 1}).eye(), Vec3d(0, 1, 0));
    const Camera top = eye(ViewFrom::Top, {0, 1, 0});
    EXPECT_EQ(top.eye(), Vec3d(0, 1, 0));
    EXPECT_EQ(Vec3d(top.world_from_camera[1]), Vec3d(0, 0, -1));  // the front is at the lower border
    EXPECT_THROW(CameraFit(ViewFrom::Front, Vec3d(0), 0.6f, 1), Error);
}

// The test fits one point, no point, and a needle that points at the eye.
TEST(Camera, AFitOfAlmostNothingIsACamera)
{
    CameraFit fit(ViewFrom::Front, {0, 1, 0}, 0.6f, 1);
    EXPECT_TRUE(fit.is_empty());
    EXPECT_GT(fit.camera().eye().z, 1);
    fit.add({0, 0, -100});
    fit.add({0, 0, 5});
    EXPECT_GT(fit.camera().eye().z, 7);
    fit.clear();
    fit.add(Vec3d(1e12));
    EXPECT_GT(fit.camera().eye().z, 1e12);
}

// At 1e16 the next number is 2 away.
TEST(Camera, FramesWhatLiesFarAwayAsItFramesWhatIsNear)
{
    const Camera near = Camera::framing({Vec3d(-1), Vec3d(1)});
    for (const double at : {0.0, 1e6, 1e13, 1e15, 1e16, 1e100}) {
        const Box3d box{Vec3d(at), Vec3d(at * 1.5 + 1)};
        const Camera camera = Camera::framing(box);
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_EQ(camera.world_from_camera[axis], near.world_from_camera[axis]) << at << ", axis " << axis;
        const Vec3d to_eye = camera.eye() - box.centre(), back(camera.world_from_camera[2]);
        EXPECT_NEAR(glm::dot(to_eye, back) / glm::length(to_eye), 1, 1e-12) << at;
    }
    EXPECT_NO_THROW(Camera::framing({Vec3d(1e16), Vec3d(1e16)}));
    const double infinity = std::numeric_limits<double>::infinity();
    EXPECT_THROW(Camera::framing({Vec3d(0), Vec3d(infinity)}), Error);
    EXPECT_THROW(Camera::framing({Vec3d(-infinity), Vec3d(infinity)}), Error);
    EXPECT_THROW(Camera::framing({Vec3d(-1.7e308), Vec3d(1.7e308)}), Error) << "their extent is not finite";
}

}  // namespace
}  // namespace occam
