// The arguments of the command line, checked as far as that is possible without opening a file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "occam/occam.h"
#include "sequence.h"

namespace occam::command {

enum class ProgressStyle : unsigned char { Auto, Plain, OpenJd, None };

/// Says how the scene's file is read.
struct SceneArguments {
    std::filesystem::path scene;  ///< empty: the built-in scene
    LoadOptions load;
};

struct LookAt {
    Vec3d eye{0}, target{0};
};

struct RenderArguments : SceneArguments {
    std::filesystem::path output;
    Settings settings;
    bool size_given = false;   ///< if false, the camera's aspect decides the height
    bool clamp_given = false;  ///< if false, the limit of scattered light follows from the output's format
    Resources resources;
    std::string camera;      ///< name; empty: the first camera
    std::string lod_camera;  ///< name; empty: the picture's own camera
    std::optional<LookAt> look_at;
    std::optional<Vec3d> up;            ///< none: decided by the file's format
    std::optional<ViewFrom> view_from;  ///< if given, the scene is framed from there, whatever cameras it has
    float fov_deg = 0;                  ///< 0: the camera's own, or 39.5
    float lens_radius = 0, focus = 0;   ///< 0: the camera's own
    int blades = 0;
    std::filesystem::path environment;  ///< image that replaces the scene's own; empty: none was given
    float environment_strength = 1, environment_rotation_deg = 0;
    bool has_environment = true;  ///< if false, the scene's own environment is left out
    std::string clip;             ///< name, number or `all`; empty: Scene::clips_together(), if a time is asked for
    std::optional<double> time;   ///< seconds on the clip's own axis
    std::optional<int> frame;     ///< time is frame / fps
    double fps = 24;
    int shutter_segments = 0;  ///< 0: as many as the paths need within a quarter of a pixel
    WriteOptions write;
    ProgressStyle progress = ProgressStyle::Auto;
    bool quiet = false, verbose = false;
    bool resume = false;                  ///< the picture goes on from the file that a stopped one left
    std::optional<bool> checkpoint{};     ///< a picture that is stopped leaves such a file; none: as keeps_checkpoint() says
    std::string stats;                    ///< file, "-" or empty
    std::optional<PixelSample> replay{};  ///< if given, this sample is traced and described, and no picture is made

    /// Rounds over the whole picture cost time, so they are made only where the picture is likely to be stopped.
    bool keeps_checkpoint() const { return checkpoint.value_or(resume || settings.deadline_s > 0); }
};

struct AnimateArguments : RenderArguments {
    FramePattern pattern{"frame.####.exr"};  ///< from `output`
    std::vector<int> frames;
    Shard shard;
    bool is_slurms_shard = false;          ///< Slurm's variables say it, and not the command line
    bool is_slurms_shard_unclear = false;  ///< they should, and do not say which
    bool overwrite = false;
};

struct InfoArguments : SceneArguments {
    bool json = false;
};

struct CompareArguments {
    std::filesystem::path a, b;
    std::string layer = "beauty";  ///< the layer to which the limits and the heat map apply
    bool json = false;
    std::filesystem::path heat;
    double heat_scale = 0;  ///< 0: the largest difference
    std::optional<double> max_mse, max_rmse, max_rel_mse, max_error, max_p999, min_psnr;

    bool has_limit() const { return max_mse || max_rmse || max_rel_mse || max_error || max_p999 || min_psnr; }
};

/// Of what pictures need, only the scene's pose and shutter count.
struct VerifyArguments : RenderArguments {
    VerifySettings test;
    std::string replay;                  ///< a ray that is described instead; empty: all cages are tested
    std::vector<std::string> command{};  ///< the words of the command line, without those that only choose the rays
    bool json = false;
};

struct TextureArguments {
    std::filesystem::path image, out;
    bool is_data = false;  ///< the texels are no colours
};

struct BenchArguments {
    std::vector<std::string> words;  ///< arguments for the benchmark program
};

/// Says that nothing is left to do but to end with that exit code: all messages have been printed.
struct Finished {
    int exit_code;
};

using Arguments = std::variant<Finished, RenderArguments, AnimateArguments, InfoArguments, VerifyArguments, CompareArguments,
                               TextureArguments, BenchArguments>;

/// Parses the command line. Usage errors go to standard error, --help and --version to standard output.
Arguments parse(int argc, char** argv);

int run(const RenderArguments& arguments);
int run(const AnimateArguments& arguments);
int run(const InfoArguments& arguments);
int run(const VerifyArguments& arguments);
int run(const CompareArguments& arguments);
int run(const TextureArguments& arguments);
int run(const BenchArguments& arguments);

/// Returns the scene of a file, or the built-in one.
Scene open_scene(const SceneArguments& arguments);
/// Returns the file as it was given, or "the built-in scene".
std::string name_of_scene(const SceneArguments& arguments);

}  // namespace occam::command
