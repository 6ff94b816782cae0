// Functions that all commands that make pictures share: they set the requested pose and camera, wait for a frame and print
// its cost.
#pragma once

#include <functional>
#include <span>

#include "arguments.h"
#include "interrupt.h"
#include "lod/extent.h"
#include "progress.h"
#include "scenegraph/camera_fit.h"

namespace occam::command {

/// Chooses the camera and the pose of each frame of one scene.
class Framing {
public:
    /// Throws Error if the clip does not exist. If a time is asked for and nothing moves, or a rotation and the environment
    /// has no image, that is a warning of the scene, or an Error if the arguments are strict.
    Framing(Scene& scene, const RenderArguments& arguments);

    /// If nothing in the scene is animated, adds a warning to it that says so, or throws Error if the arguments are strict.
    void note_stillness(const std::string& consequence);
    /// Makes camera() see the scene throughout its clip, with one camera for all frames. Changes the pose.
    void fit_clip();

    /// Returns the time of that pose, in seconds on the clip's axis; none if the file's own pose is kept.
    std::optional<double> moment(std::optional<int> frame = std::nullopt) const;
    /// Poses the scene at the middle of the shutter: at `frame` of a sequence, or without one as the arguments say.
    void pose(std::optional<int> frame = std::nullopt);
    /// After pose() of the same frame: records what moves while the shutter is open, unless it is closed, and returns the
    /// camera with its own motion. Throws Error if the scene has no animation.
    Camera open_shutter(const Camera& camera, std::optional<int> frame = std::nullopt);
    /// Returns for how long the shutter is open, or none if it is closed.
    std::optional<float> exposure_seconds() const;
    /// Returns the requested camera, else the first one of the file, else one that fits the scene as it is posed, or the
    /// whole clip after fit_clip(). Throws Error if the camera does not exist, or for a view that has no direction.
    Camera camera();
    Camera camera_named(const std::string& name) const;
    /// Returns the settings of the arguments. Their height follows from the aspect of a camera where no size was given.
    /// Throws Error if they are not valid, or if the format of the output cannot hold a picture of that size.
    Settings settings(const Camera& camera) const;

    /// Adds a warning to the figures of a frame if a factor of the environment's brightness was asked for and the frame had
    /// neither an environment nor a sky, which is known only after it.
    void note_idle_strength(FrameStats& stats) const;

private:
    /// Adds a warning to the scene about an option that does nothing there, or throws Error if the arguments are strict.
    void note_idle(std::string warning);
    bool is_fitted() const;  ///< neither the arguments nor the file name a camera
    Vec3d up() const;
    void fit_pose();
    void pose_at(double seconds);
    /// Poses the scene at a moment of the shutter: it opens at 0 and closes at 1. There has to be a moment() of the frame.
    void pose_in_shutter(std::optional<int> frame, double tau);

    Scene& scene_;
    const RenderArguments& arguments_;
    std::vector<ClipId> clips_;  // the clips that play at the same time
    lod::Extent extent_;
    CameraFit fit_;
    bool is_clip_fitted_ = false;
    bool has_environment_;  ///< the scene's own or the given one, whatever its factor is
};

/// Says how waiting for a frame ended.
enum class Ending : unsigned char {
    Whole,        ///< it was not interrupted
    Interrupted,  ///< it was interrupted, and the job has ended with what is done
    Abandoned     ///< it was interrupted with nothing to keep; the job may still run, so the process has to end without it
};

/// Waits for the frame and shows its progress, as part `done` of `all` equal ones.
/// keeps_part   true if a picture that is done in parts is worth waiting for; `held` then allows the time for that
Ending wait_for(Job& job, ProgressDisplay& display, HeldInterrupts& held, bool keeps_part, std::size_t done = 0,
                std::size_t all = 1);

/// Writes the statistics, if they are asked for. Whoever reads a pipe may do so when he likes, so after a signal the process
/// waits no longer than a second for him, while a regular file gets the time that it needs.
/// json   makes the text, and is called only if it is asked for: a picture that is there must not fail for lack of memory
void write_stats(const RenderArguments& arguments, HeldInterrupts& held, const std::function<std::string()>& json);

/// Checks, before minutes of work, that pictures and statistics can be written, and removes what killed runs left of
/// these pictures. The pictures are in one folder and of one format. Throws Error. Whether a picture that is there can be
/// replaced is not checked, since it need not be if it is a finished frame (check_replaceable()).
/// pictures   those of this run; none if its part of the sequence has no frames
/// all        the pictures of all parts of the sequence, or the picture and its checkpoint, in one folder: over these the
///            statistics must not be written under any name
void check_outputs(const RenderArguments& arguments, std::span<const std::filesystem::path> pictures,
                   std::span<const std::filesystem::path> all);
/// Checks, without reading them, that the scene's file is one of a scene and that the environment can be read. Throws Error.
void check_inputs(const RenderArguments& arguments);
/// Opens the scene. Throws Error if it cannot be read, or if one of the outputs is a file of it.
Scene open_scene(const RenderArguments& arguments, std::span<const std::filesystem::path> pictures);

/// Prints what the importer chose on standard error.
void print_notes(const Scene& scene);
/// Prints the first five warnings and the number of the rest, or all of them, on standard error.
void print_warnings(const std::vector<std::string>& warnings, bool all);
/// Says on standard error that the default light was added although the scene has emissive surfaces.
void print_light(const FrameStats& stats);
/// Prints size, time and checksum of a frame on standard error.
void print_figures(const FrameStats& stats);
/// Adds what the command has measured around a frame to the frame's own figures.
void add_seconds(FrameStats& stats, double load, double edit, double write);

}  // namespace occam::command
