// What commands that make pictures share: the pose and the camera that were asked for, waiting for a frame, saying what it
// cost.
#pragma once

#include "arguments.h"
#include "progress.h"

namespace occam::command {

/// Camera and pose of each frame of one scene.
class Framing {
public:
    /// Looks at the scene as the file has it: what frames it does so at all times.
    /// Throws Error for a clip that is not there.
    Framing(Scene& scene, const RenderArguments& arguments);

    /// Poses the scene: at `frame` of a sequence, or without one as the arguments say.
    void pose(std::optional<int> frame = std::nullopt);
    /// Throws Error for a camera that is not there, or a view that has no direction.
    Camera camera() const;
    Camera camera_named(const std::string& name) const;
    /// The arguments' settings, their height from a camera's aspect where no size was given.
    Settings settings(const Camera& camera) const;

private:
    Scene& scene_;
    const RenderArguments& arguments_;
    Camera whole_;
    ClipId clip_;
};

/// The frame, watched; true if it was interrupted. The progress shown is that of part `done` of `all` equal ones.
bool wait_for(Job& job, ProgressDisplay& display, std::size_t done = 0, std::size_t all = 1);

/// To a file, or to standard output for "-". Throws Error.
void write_text(const std::string& file, const std::string& text);

/// Warnings and the figures of a frame, as --verbose asks.
void report(const FrameStats& stats, bool quiet, bool verbose);

}  // namespace occam::command
