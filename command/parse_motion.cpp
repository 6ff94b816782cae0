// The options that say at which time, or for how long, a scene is seen.
#include <bit>
#include <cmath>

#include "option_kinds.h"
#include "scenegraph/content_rules.h"

namespace occam::command {

void add_clip(CLI::App& app, RenderArguments& a)
{
    app.add_option(
           "--clip", a.clip,
           "Animation by name or number, or all at once [if a frame or a time is given: the first, and all others that move "
           "other objects]")
        ->type_name("NAME|INDEX|all");
    add_number(app, "--fps", "Frames a second [24]", "more than 0", [&](double v) {
        a.fps = v;
        return v > 0;
    });
}

void add_shutter(CLI::App& app, RenderArguments& a)
{
    CLI::Option* shutter = add_value(app, "--shutter",
                                     "Motion blur: when the shutter opens and closes, in frames from the frame's time; "
                                     "-0.25,0.25 is half a frame [closed]",
                                     "OPEN,CLOSE", [&](const std::string& t) {
                                         const auto n = numbers_of(t, 2);
                                         a.settings.shutter = {n[0], n[1]};
                                         try {
                                             check(a.settings.shutter);
                                         } catch (const Error&) {
                                             expected("moments within a million frames, OPEN not after CLOSE", t);
                                         }
                                     });
    add_value(
        app, "--shutter-segments",
        "Straight pieces by which motion is followed: 1, 2, 4, 8, 16 or 32 [the fewest that stay within a quarter of a "
        "pixel]",
        "N",
        [&](const std::string& t) {
            const std::uint64_t n = whole_of(t, 1, kMaxShutterSegments);
            if (!std::has_single_bit(n)) expected("1, 2, 4, 8, 16 or 32", t);
            a.shutter_segments = static_cast<int>(n);
        })
        ->needs(shutter);
}

void add_moment(CLI::App& app, RenderArguments& a)
{
    CLI::Option* time = add_value(app, "--time", "Seconds on the clip's own axis [the file's pose]", "NUMBER",
                                  [&](const std::string& t) { a.time = real_of(t); });
    CLI::Option* frame = add_value(app, "--frame", "The same as a frame's number: time * fps", "N",
                                   [&](const std::string& t) {
                                       constexpr double kMost = 1e9;
                                       const double number = real_of(t);
                                       if (std::fabs(number) > kMost || number != std::floor(number))
                                           expected("a whole number from -1000000000 to 1000000000", t);
                                       a.frame = static_cast<int>(number);
                                   });
    frame->excludes(time);
}

void add_sequence(CLI::App& app, AnimateArguments& a)
{
    add_value(app, "--frames", "Frames of the sequence", "A-BxSTEP,C,...", [&](const std::string& t) {
        a.frames = frames_of(t);
    })->required();
    app.add_flag("--overwrite", a.overwrite, "Make frames again whose pictures exist already");
    add_value(app, "--shard", "Every N-th frame, from the K-th [what Slurm's array variables say, else all]", "K/N",
              [&](const std::string& t) { a.shard = shard_of(t); });
}

}  // namespace occam::command
