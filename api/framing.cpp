#include "base/error_without_file.h"
#include "lod/extent.h"
#include "occam/occam.h"
#include "render/camera_rays.h"
#include "scenegraph/content_rules.h"
#include "scenegraph/shutter.h"

namespace occam {

Camera framing(Scene& scene, float aspect, ViewFrom from, Vec3d up)
{
    check_aspect(aspect, "framing");
    scene.refit();
    CameraFit fit(from, up, CameraLens().fov, aspect);
    lod::Extent().visit_points(scene, [&](Vec3d point) { fit.add(point); });
    return fit.camera();
}

Camera record_shutter(Scene& scene, const std::function<void(double tau)>& pose, const std::function<Camera()>& camera,
                      int height, int segments)
{
    if (height < 1 || height > render::kMaxSide)
        throw error_without_file("it must be from 1 to " + std::to_string(render::kMaxSide) + " pixels", "image height");
    if (!camera) throw error_without_file("a shutter needs something that returns the camera");
    constexpr double kPixels = 0.25;
    // The camera takes part in the finest recording: its keys cost nothing in the scene.
    int finest = segments != 0 ? segments : kMaxShutterSegments;
    const auto is_recorded = [&] {
        try {
            scene.record_shutter(finest, pose);
            return true;
        } catch (const ShutterTooLarge&) {
            if (segments != 0 || finest == 1) throw;
            return false;
        }
    };
    while (!is_recorded()) finest /= 2;
    Camera moving;
    try {
        moving = camera();
        check(moving);
    } catch (...) {
        scene.clear_shutter();
        throw;
    }
    if (segments != 0) return moving;
    scene.refit();
    const lod::Footprint pixel = render::CameraRays(moving, height, height).pixel();
    PathTolerance tolerance{moving.eye(), kPixels * double(pixel.a), kPixels * double(pixel.b)};
    for (const Mat4d& key : moving.keys) tolerance.eyes.push_back(Vec3d(key[3]));
    const int needed = needed_segments(scene, tolerance);
    if (needed > 0 && needed < finest) scene.record_shutter(needed, pose);
    return moving;
}

}  // namespace occam
