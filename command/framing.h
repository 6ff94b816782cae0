// What commands that make pictures share: the pose and the camera that were asked for, waiting for a frame, saying what it
// cost.
#pragma once

#include "arguments.h"
#include "lod/extent.h"
#include "progress.h"
#include "scenegraph/camera_fit.h"

namespace occam::command {

/// The camera and the pose of each frame of one scene.
class Framing {
public:
    /// Throws Error for a clip that is not there.
    Framing(Scene& scene, const RenderArguments& arguments);

    /// Has camera() see the scene throughout its clip, with one camera for all frames. Changes the pose.
    void fit_clip();

    /// Poses the scene: at `frame` of a sequence, or without one as the arguments say.
    void pose(std::optional<int> frame = std::nullopt);
    /// The camera that was asked for, else the first one of the file, else one that fits the scene as it is posed, or the
    /// whole clip after fit_clip(). Throws Error for a camera that is not there, or a view that has no direction.
    Camera camera();
    Camera camera_named(const std::string& name) const;
    /// The arguments' settings, their height from a camera's aspect where no size was given.
    Settings settings(const Camera& camera) const;

private:
    bool is_fitted() const;  ///< neither the arguments nor the file name a camera
    Vec3d up() const;
    void fit_pose();

    Scene& scene_;
    const RenderArguments& arguments_;
    ClipId clip_;
    lod::Extent extent_;
    CameraFit fit_;
    bool is_clip_fitted_ = false;
};

/// The frame, watched; true if it was interrupted. The progress shown is that of part `done` of `all` equal ones.
bool wait_for(Job& job, ProgressDisplay& display, std::size_t done = 0, std::size_t all = 1);

/// To a file, or to standard output for "-". Throws Error.
void write_text(const std::string& file, const std::string& text);

/// Warnings and the figures of a frame, as --verbose asks.
void report(const FrameStats& stats, bool quiet, bool verbose);

}  // namespace occam::command
