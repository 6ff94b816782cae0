#include <algorithm>
#include <functional>
#include <vector>

#include "base/default_floats.h"
#include "base/error_without_file.h"
#include "lod/extent.h"
#include "occam/occam.h"
#include "render/camera_rays.h"
#include "scenegraph/content_rules.h"
#include "scenegraph/shutter.h"

namespace occam {

Camera framing(Scene& scene, float aspect, ViewFrom from, Vec3d up)
{
    const DefaultFloats floats;
    check_aspect(aspect, "framing");
    scene.refit();
    CameraFit fit(from, up, CameraLens().fov, aspect);
    lod::Extent().visit_points(scene, [&](Vec3d point) { fit.add(point); });
    return fit.camera();
}

namespace {

/// Records the scene, and the camera beside it: both are asked for at each key.
class Recording {
public:
    Recording(Scene& scene, const std::function<void(double tau)>& pose, const std::function<Camera()>& camera)
        : scene_(scene), pose_(pose), camera_(camera)
    {
    }

    /// Throws ShutterTooLarge if the keys of so many segments take too much memory.
    void record(int segments)
    {
        path_.clear();
        scene_.record_shutter(segments, [&](double tau) {
            pose_(tau);
            if (path_.size() > std::size_t(segments)) return;  // after the keys, the scene is posed at mid-shutter
            const Camera at_key = camera_();
            check(at_key);
            path_.push_back(at_key.world_from_camera);
            has_keys_of_its_own_ |= !at_key.keys.empty();
        });
    }

    /// Returns the camera of mid-shutter. Keys that the application gave it are kept, and else they are where it was, as
    /// those of a camera of a node are.
    Camera camera() const
    {
        Camera moving = camera_();
        if (!has_keys_of_its_own_ && moving.keys != path_) {
            const bool stands = std::adjacent_find(path_.begin(), path_.end(), std::not_equal_to<>()) == path_.end();
            moving.keys = stands ? std::vector<Mat4d>() : path_;
        }
        check(moving);
        return moving;
    }

private:
    Scene& scene_;
    const std::function<void(double tau)>& pose_;
    const std::function<Camera()>& camera_;
    std::vector<Mat4d> path_;
    bool has_keys_of_its_own_ = false;
};

}  // namespace

Camera record_shutter(Scene& scene, const std::function<void(double tau)>& pose, const std::function<Camera()>& camera,
                      int height, int segments)
{
    if (height < 1 || height > render::kMaxSide)
        throw error_without_file(
            "it must be from 1 to " + std::to_string(render::kMaxSide) + " pixels, not " + std::to_string(height), "height");
    const DefaultFloats floats;
    if (!pose) throw error_without_file("a shutter needs something that poses the scene");
    if (!camera) throw error_without_file("a shutter needs something that returns the camera");
    constexpr double kPixels = 0.25;
    // The camera takes part in the finest recording: its keys cost nothing in the scene.
    int finest = segments != 0 ? segments : kMaxShutterSegments;
    Recording recording(scene, pose, camera);
    const auto is_recorded = [&] {
        try {
            recording.record(finest);
            return true;
        } catch (const ShutterTooLarge&) {
            if (segments != 0 || finest == 1) throw;
            return false;
        }
    };
    while (!is_recorded()) finest /= 2;
    Camera moving;
    try {
        moving = recording.camera();
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
