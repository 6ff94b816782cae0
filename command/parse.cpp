// Defines the grammar of the command line. The options of time are in parse_motion.cpp; no other file uses CLI11.
#include <algorithm>
#include <iostream>
#include <set>

#include "base/printable.h"
#include "idle_options.h"
#include "io/extensions.h"
#include "option_kinds.h"
#include "render/picture_formats.h"
#include "replay_command.h"
#include "usage_message.h"

namespace occam::command {
namespace {

void add_scene(CLI::App& app, SceneArguments& a)
{
    app.add_option("SCENE", a.scene, "File " + extensions_of(scene_formats()) + "; without it the built-in scene")
        ->type_name("")
        ->check([](const std::string& name) { return name.empty() ? "the name of a scene is empty" : std::string(); });
    add_choice<Subdivide>(app, "--subdivide", a.load.subdivide,
                          {{"on", Subdivide::On}, {"off", Subdivide::Off}, {"auto", Subdivide::Auto}},
                          "Polygons are the cage of a Catmull-Clark surface. auto: only those of an OBJ with subdivision "
                          "tags, and those that glTF's extras.occam names; others are rendered as they are, with the "
                          "file's normals, or flat or smooth by the smoothing groups of an OBJ [auto]");
    app.add_flag(
        "--strict", a.load.strict,
        "What is wrong in the scene's files is an error and no warning, such as a missing texture or a dropped primitive");
    app.add_option("--variant", a.load.variant, "Materials of this variant (KHR_materials_variants) [the file's own]")
        ->type_name("NAME");
}

struct Quality {
    int spp;
    float shading_rate;
};
const std::map<std::string, Quality> kQualities{{"fast", {4, 2}}, {"balanced", {16, 1}}, {"high", {64, 0.5f}}};

void add_picture(CLI::App& app, RenderArguments& a)
{
    Settings& s = a.settings;
    add_value(app, "--size", "Pixels of the frame [1280x720, its height from the camera's aspect]", "WxH",
              [&](const std::string& t) {
                  std::tie(s.width, s.height) = size_of(t);
                  a.size_given = true;
              });
    add_value(app, "--crop", "Part of the frame, 0 to 1 from the top left", "X0,X1,Y0,Y1", [&](const std::string& t) {
        const auto n = numbers_of(t, 4);
        s.crop_x0 = float(n[0]), s.crop_x1 = float(n[1]), s.crop_y0 = float(n[2]), s.crop_y1 = float(n[3]);
    });
    add_value(app, "--quality", "A recipe: --spp 4, 16, 64 and --shading-rate 2, 1, 0.5", "fast|balanced|high",
              [](const std::string& t) {
                  if (!kQualities.count(t)) expected("fast, balanced or high", t);
              });
    add_settings(app, s);
    std::string layers = "EXR layers: ";
    for (const render::AovRow& row : render::kAovs) layers.append(row.aov == Aov{} ? "" : ", ").append(row.name);
    add_value(app, "--aov", layers, "A,B,...", [&](const std::string& t) {
        for (std::string_view word : words_of(t)) {
            const auto* row = std::find_if(std::begin(render::kAovs), std::end(render::kAovs),
                                           [&](const auto& r) { return r.name == word; });
            if (row == std::end(render::kAovs)) throw std::invalid_argument("there is no layer '" + std::string(word) + "'");
            s.aovs |= row->aov;
        }
    });
    add_value(app, "--clamp",
              "Limit light scattered twice or more to this radiance a sample: fewer fireflies, some light lost; 0: off; "
              "auto: 2 at the exposure that is shown, and off for EXR and HDR [auto]",
              "X|auto", [&](const std::string& t) {
                  a.clamp_given = t != "auto";
                  s.clamp = a.clamp_given ? float(number_of(t)) : 0;
                  if (!(s.clamp >= 0)) expected("0 or more, or auto", t);
              });
    add_value(app, "--environment",
              "Light from all around: an image, daylight, or none [the scene's own; daylight and a lamp if nothing shines]",
              "FILE|sky|none", [&](const std::string& t) {
                  a.has_environment = t != "sky" && t != "none";
                  s.sky = t == "sky" ? shade::Sky::On : t == "none" ? shade::Sky::Off : shade::Sky::Auto;
                  if (a.has_environment) a.environment = t;
              });
    add_amount(app, "--environment-strength", "Factor of the environment's brightness [1]",
               [&](double v) { a.environment_strength = s.sky_strength = float(v); });
    add_value(app, "--environment-rotation", "Rotation of the environment about +y, degrees [0]", "NUMBER",
              [&](const std::string& t) { a.environment_rotation_deg = float(number_of(t)); });
}

void add_camera(CLI::App& app, RenderArguments& a)
{
    CLI::Option* name = app.add_option("--camera", a.camera,
                                       "A camera of the scene by its name [the first, else one that frames it]")
                            ->type_name("NAME");
    app.add_option("--lod-camera", a.lod_camera,
                   "Camera of the scene whose footprints decide the level of detail [the picture's own]")
        ->type_name("NAME");
    CLI::Option* look_at = add_value(app, "--look-at", "Eye and target", "EX,EY,EZ,TX,TY,TZ", [&](const std::string& t) {
        const auto n = numbers_of(t, 6);
        a.look_at = LookAt{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}};
    });
    look_at->excludes(name);
    const std::map<std::string, ViewFrom> sides{{"three-quarter", ViewFrom::ThreeQuarter},
                                                {"front", ViewFrom::Front},
                                                {"side", ViewFrom::Side},
                                                {"back", ViewFrom::Back},
                                                {"top", ViewFrom::Top},
                                                {"bottom", ViewFrom::Bottom}};
    add_choice<std::optional<ViewFrom>>(app, "--view-from", a.view_from, {sides.begin(), sides.end()},
                                        "Frame the scene from this side of it, whatever cameras it has [three-quarter]")
        ->excludes(name)
        ->excludes(look_at);
    add_value(app, "--up",
              "Which way is up, for --look-at and for framing; without --look-at a new camera is placed [z for STL, else y]",
              "x|y|z|X,Y,Z", [&](const std::string& t) { a.up = axis_of(t); })
        ->excludes(name);
    add_number(app, "--fov", "Whole vertical angle, degrees", "from 0.0006 to 179.9 degrees", [&](double v) {
        a.fov_deg = float(v);
        return v >= 0.0006 && v <= 179.9;
    });
    const auto add_length = [&](const char* option, const char* what, float& length) {
        return add_number(app, option, what, "a length above 0", [&length](double v) {
            length = float(v);
            return length > 0;
        });
    };
    CLI::Option* lens = add_length("--lens", "Radius of a thin lens, world length [a pinhole]", a.lens_radius);
    CLI::Option* focus = add_length("--focus", "Distance of the plane in focus along the view, world length", a.focus);
    lens->needs(focus);
    focus->needs(lens);
    const auto set_blades = [&](const std::string& t) { a.blades = corners_of(t); };
    add_value(app, "--blades", "Corners of the lens's opening, from 3 to 64 [0: round]", "N", set_blades)->needs(lens);
}

void add_checkpoint(CLI::App& app, RenderArguments& a)
{
    add_value(app, "--checkpoint",
              "on: the picture is made in rounds, and one that is stopped leaves IMAGE.checkpoint beside it. This takes 64 "
              "to 200 bytes a pixel beyond --memory [on with --deadline or --resume, else off]",
              "on|off", [&](const std::string& t) { a.checkpoint = is_on(t); });
    app.add_flag("--resume", a.resume, "Continue from IMAGE.checkpoint, if it exists");
}

CLI::Option& add_output(CLI::App& app, RenderArguments& a, const std::string& form)
{
    const std::string what = "Picture to write, by extension " + extensions_of(render::picture_formats(), true);
    CLI::Option* output = app.add_option("-o,--output", a.output, what)->required()->type_name(form);
    add_value(app, "--exposure",
              "Stops, display formats only; auto: by the log-average of the picture, 0 if that is as usual [auto]",
              "EV|auto", [&](const std::string& t) { a.write.exposure_ev = stops_of(t); });
    std::map<std::string, Tonemap> curves;
    for (const render::TonemapRow& row : render::kTonemaps) curves.emplace(row.name, row.value);
    add_choice<Tonemap>(app, "--tonemap", a.write.tonemap, curves, "Curve of display formats [filmic]");
    add_choice<bool>(app, "--exr", a.write.half, {{"half", true}, {"float", false}}, "Colours of an EXR [half]");
    app.add_option("--stats", a.stats, "Statistics as JSON; - is standard output")->type_name("FILE");
    return *output;
}

void add_machine(CLI::App& app, RenderArguments& a)
{
    add_whole(app, "--threads", a.resources.threads, 1, 1024, "Workers [all processors that the process may use]");
    add_value(
        app, "--memory",
        "Budget for what is rebuilt each frame [a quarter of the machine, at most 3 GB, or 512 MB a thread if that is more]",
        "SIZE", [&](const std::string& t) { a.resources.memory_bytes = bytes_of(t); });
    add_choice<accel::TreeKind>(
        app, "--accel", a.resources.tree,
        {{"auto", accel::TreeKind::Auto}, {"kd", accel::TreeKind::Kd}, {"bvh", accel::TreeKind::Bvh}},
        "Tree over the scene: a kd-tree, or boxes eight wide; the picture is the same [auto]");
    add_whole(app, "--share-tree", a.resources.workers_a_tree, 1, 1024,
              "Workers that share one tree, in the memory of one [1: each its own]");
    add_value(app, "--texture-memory",
              "Memory for textures; what does not fit is made smaller, unless occam texture made it [1G]", "SIZE",
              [&](const std::string& t) { a.resources.texture_bytes = bytes_of(t); });
    add_choice<ProgressStyle>(app, "--progress", a.progress,
                              {{"auto", ProgressStyle::Auto},
                               {"plain", ProgressStyle::Plain},
                               {"openjd", ProgressStyle::OpenJd},
                               {"none", ProgressStyle::None}},
                              "A bar on a terminal, lines, Open Job Description lines [auto]");
    app.add_flag("-q,--quiet", a.quiet, "No progress; warnings and notes are printed all the same");
    app.add_flag("-v,--verbose", a.verbose, "All warnings instead of five, and the figures of the frame");
}

void apply_quality(const CLI::App& app, Settings& s)
{
    if (!app.count("--quality")) return;
    const Quality& quality = kQualities.at(app.get_option("--quality")->results().front());
    if (!app.count("--spp")) s.spp = quality.spp;
    if (!app.count("--shading-rate")) s.shading_rate = quality.shading_rate;
}

// Prints on standard error the first option that has no effect, and returns false if there is one.
template <class A>
bool all_have_effect(const CLI::App& app, const A& a)
{
    std::set<std::string> given;
    for (const CLI::Option* option : app.get_options())
        if (option->count() > 0) given.insert(option->get_name());
    try {
        refuse_idle(a, given);
    } catch (const std::invalid_argument& error) {
        std::cerr << "occam: " << printable_line(error.what()) << " (occam " << app.get_name() << " --help)\n";
        return false;
    }
    return true;
}

// Sets what depends on several arguments at once.
Arguments finished(AnimateArguments a, bool has_shard)
{
    try {
        a.pattern = FramePattern(a.output);
    } catch (const std::invalid_argument& error) {
        std::cerr << "occam: --output: " << printable_line(error.what()) << " (occam animate --help)\n";
        return Finished{2};
    }
    if (has_shard) return a;
    const auto slurm = slurm_shard(std::getenv);
    a.shard = slurm.value_or(a.shard);
    a.is_slurms_shard = slurm.has_value();
    a.is_slurms_shard_unclear = !slurm && std::getenv("SLURM_ARRAY_TASK_ID");
    return a;
}

CLI::App& add_render(CLI::App& app, RenderArguments& render)
{
    CLI::App& command = *app.add_subcommand("render", "Render one frame to a picture");
    add_scene(command, render);
    CLI::Option& output = add_output(command, render, "IMAGE");
    add_camera(command, render);
    add_clip(command, render);
    add_moment(command, render);
    add_shutter(command, render);
    add_checkpoint(command, render);
    add_picture(command, render);
    add_machine(command, render);
    add_replay(command, output, render);
    command.footer(
        "A picture that --deadline stops leaves a checkpoint, from which --resume continues. With --checkpoint on, a "
        "picture\n"
        "that Ctrl-C stops leaves one, too.\n"
        "Example: occam render courtyard.glb -o courtyard.exr --size 1920x1080 --spp 64 --aov depth,normal --stats -");
    return command;
}

CLI::App& add_animate(CLI::App& app, AnimateArguments& animate)
{
    CLI::App& command = *app.add_subcommand("animate", "Render a sequence of frames, or continue one that was stopped");
    add_scene(command, animate);
    add_output(command, animate, "IMAGE.####.EXT");
    add_sequence(command, animate);
    add_shutter(command, animate);
    add_clip(command, animate);
    add_camera(command, animate);
    add_picture(command, animate);
    add_machine(command, animate);
    command.footer(
        "Frames that exist already are left alone, so a run that was stopped can be started again with the same arguments.\n"
        "Frames that are cut off are made again; frames of another size or with other settings are refused without "
        "--overwrite.\n"
        "Example: occam animate fox.glb -o fox.####.exr --frames 0-95 --clip Run --shard 1/4");
    return command;
}

CLI::App& add_info(CLI::App& app, InfoArguments& info)
{
    CLI::App& command = *app.add_subcommand("info", "Print what is in a scene");
    add_scene(command, info);
    command.add_flag("--json", info.json, "Print JSON");
    command.footer("Example: occam info courtyard.glb --json");
    return command;
}

CLI::App& add_verify(CLI::App& app, VerifyArguments& verify)
{
    CLI::App& command = *app.add_subcommand("verify", "Check that no ray leaves a closed cage");
    add_scene(command, verify);
    add_clip(command, verify);
    add_moment(command, verify);
    add_shutter(command, verify);
    add_whole(command, "--rays", verify.test.rays, 1, kMostVerifyRays,
              "Rays for each placed cage, in groups of 512 [1000000]");
    add_whole(command, "--seed", verify.test.seed, 0, ~std::uint64_t(0), "Seed of the random numbers [0]");
    command.add_flag("--json", verify.json, "Print JSON");
    add_replay(command, verify);
    command.footer(
        "With --shutter, each ray sees the scene at a moment of its own.\n"
        "Exit code 1 if a ray escapes. Example: occam verify suzanne.obj --subdivide on --rays 10000000 --json");
    return command;
}

// Reads the words of the command line. Returns how it has ended already, if it has.
std::optional<Finished> read_words(CLI::App& app, int argc, char** argv)
{
    if (argc < 2) {
        std::cerr << "occam: a command is needed: render, animate, info, verify, compare, texture or bench (occam --help)\n";
        return Finished{2};
    }
    const auto commands = app.get_subcommands([](const CLI::App*) { return true; });
    const auto named = std::ranges::find(commands, argv[1], [](const CLI::App* command) { return command->get_name(); });
    if (argv[1][0] != '-' && named == commands.end()) {
        std::string line = "there is no command '" + std::string(argv[1]) + "'";
        // A name with an extension is taken for a scene.
        if (const std::filesystem::path scene(argv[1]); scene.has_extension())
            line += "; to render it: occam render " + scene.string() + " -o " + scene.stem().string() + ".png";
        std::cerr << "occam: " << printable_line(line) << " (occam --help)\n";
        return Finished{2};
    }
    const std::span<char*> words(argv, static_cast<std::size_t>(argc));
    try {
        refuse_empty_values(words);
        refuse_values_of_flags(named == commands.end() ? app : **named, words);
        app.parse(argc, argv);
        refuse_empty_values(*app.get_subcommands().front());
    } catch (const CLI::CallForHelp& help) {
        return Finished{app.exit(help)};
    } catch (const CLI::CallForVersion& version) {
        return Finished{app.exit(version)};
    } catch (const CLI::ParseError& error) {
        const CLI::App* used = named == commands.end() ? &app : *named;
        std::cerr << "occam: " << message_of(error, *used, words) << " ("
                  << (used == &app ? "occam" : "occam " + used->get_name()) << " --help)\n";
        return Finished{2};
    }
    return std::nullopt;
}

}  // namespace

Arguments parse(int argc, char** argv)
{
    RenderArguments render;
    AnimateArguments animate;
    InfoArguments info;
    VerifyArguments verify;
    CompareArguments compare;
    TextureArguments texture;
    BenchWords bench;

    CLI::App app("Occam: dynamic multiresolution ray tracing.", "occam");
    app.set_version_flag("--version", std::string("occam ") + render::kVersion + "\nwith " OCCAM_LIBRARIES);
    app.require_subcommand(1);
    app.footer(
        "Scenes: " + extensions_of(scene_formats()) + ". Pictures: " + extensions_of(render::picture_formats()) +
        ".\n"
        "Exit codes: 0 done; 1 a limit of compare or verify does not hold; 2 bad input or usage; 3 output or resources; 130 "
        "interrupted.\n"
        "Example: occam render courtyard.glb -o courtyard.png");

    CLI::App& render_app = add_render(app, render);
    CLI::App& animate_app = add_animate(app, animate);
    CLI::App& info_app = add_info(app, info);
    CLI::App& verify_app = add_verify(app, verify);
    CLI::App& compare_app = add_compare(app, compare);
    CLI::App& texture_app = add_texture(app, texture);
    CLI::App& bench_app = add_bench(app, bench);
    if (const auto finished_already = read_words(app, argc, argv)) return *finished_already;
    if (render_app.parsed()) {
        apply_quality(render_app, render.settings);
        return all_have_effect(render_app, render) ? Arguments(render) : Finished{2};
    }
    if (animate_app.parsed()) {
        apply_quality(animate_app, animate.settings);
        if (!all_have_effect(animate_app, animate)) return Finished{2};
        return finished(std::move(animate), animate_app.count("--shard") > 0);
    }
    if (bench_app.parsed()) return bench.arguments();
    if (info_app.parsed()) return all_have_effect(info_app, info) ? Arguments(info) : Finished{2};
    if (texture_app.parsed()) return texture;
    if (compare_app.parsed()) return all_have_effect(compare_app, compare) ? Arguments(compare) : Finished{2};
    verify.command = words_of_scene({argv, static_cast<std::size_t>(argc)});
    return all_have_effect(verify_app, verify) ? Arguments(verify) : Finished{2};
}

}  // namespace occam::command
