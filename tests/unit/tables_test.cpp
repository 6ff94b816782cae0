// Tests that what is one row in the sources is also in the help and in the pages of docs/.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "io/extensions.h"
#include "render/picture_formats.h"
#include "render/setting_rows.h"
#include "tests/support/command_test.h"
#include "tests/support/shared_data.h"

namespace occam {
namespace {

using namespace test;

std::string page(const std::string& name) { return text_of(source_folder() / "docs" / name); }

void expect_line(const std::string& text, const std::string& line) { EXPECT_NE(text.find(line), std::string::npos) << line; }

// Returns "`.jpg`, `.jpeg`" for ".jpg .jpeg".
std::string quoted(std::string_view extensions)
{
    std::string text = "`";
    for (const char c : extensions) text += c == ' ' ? std::string("`, `") : std::string(1, c);
    return text + '`';
}

// A frame of a sequence is known by this text.
TEST(Tables, TheStatisticsTellAllCamerasOfTheLevelOfDetailApart)
{
    std::vector<Camera> cameras(9);
    cameras[1].lens.fov = 0.5f;
    cameras[2].lens.aspect = 1.5f;
    cameras[3].lens.orthographic = true;
    cameras[4].lens.height = 200;
    cameras[5].lens.radius = 0.1f;
    cameras[6].lens.focus = 3;
    cameras[7].lens.blades = 6;
    cameras[8].world_from_camera[3].z = 5;
    std::set<std::string> texts{render::to_json(Settings())};
    for (const Camera& camera : cameras) texts.insert(render::to_json(Settings{.lod_camera = camera}));
    EXPECT_EQ(texts.size(), cameras.size() + 1);
}

TEST(Tables, EverySettingIsInTheStatisticsAndInTheDocumentation)
{
    const std::string settings = page("settings.md");
    const auto json = nlohmann::json::parse(render::to_json(Settings()));
    for (const render::SettingRow& row : render::kSettings) {
        EXPECT_TRUE(json.contains(row.name)) << row.name;
        std::string values = render::range_of(row);
        std::visit(
            [&]<class T>(T Settings::*) {
                if constexpr (std::is_same_v<T, bool>) values = "on, off";
                else if constexpr (std::is_enum_v<T>)
                    for (const auto& choice : render::choices_of(T()))
                        values.append(values.empty() ? "" : ", ").append(choice.name);
            },
            row.member);
        const std::string option = row.help.empty() ? "" : "`--" + render::option_of(row) + "`";
        expect_line(settings, "| " + option + " | `" + std::string(row.name) + "` | " + values + " | " +
                                  render::default_of(row) + " | " + std::string(row.help) + " |\n");
    }
}

TEST(Tables, ValuesOutsideOfARangeAreRefusedByName)
{
    for (const render::SettingRow& row : render::kSettings)
        std::visit(
            [&]<class T>(T Settings::*member) {
                if constexpr (std::is_floating_point_v<T> || std::is_same_v<T, int>) {
                    for (const double wrong : {row.least - 1, row.most + 1, row.most * 2}) {
                        if (std::is_same_v<T, int> && !(std::abs(wrong) < 1e9)) continue;
                        Settings settings;
                        settings.*member = static_cast<T>(wrong);
                        if (double(settings.*member) >= row.least && double(settings.*member) <= row.most) continue;
                        try {
                            render::check(settings);
                            ADD_FAILURE() << row.name << " = " << wrong;
                        } catch (const Error& error) {
                            const std::string rule = render::range_of(row) + ", not " + render::text_of(row, settings) +
                                                     " (" + std::string(row.name) + ")";
                            EXPECT_NE(std::string(error.what()).find(rule), std::string::npos) << error.what();
                        }
                    }
                } else if constexpr (std::is_enum_v<T>) {
                    Settings settings;
                    settings.*member = static_cast<T>(200);
                    EXPECT_THROW(render::check(settings), Error) << row.name;
                }
            },
            row.member);
}

TEST(Tables, AKindOfTreeThatDoesNotExistIsRefused)
{
    Resources resources;
    resources.tree = static_cast<accel::TreeKind>(9);
    EXPECT_THROW(resources.resolved(), Error);
}

TEST(Tables, SettingsAreWrittenAsTheyDifferFromTheUsualOnes)
{
    std::ostringstream out;
    out << Settings{
        .width = 64, .height = 36, .spp = 4, .integrator = IntegratorKind::Ao, .view = View::Level, .back_faces = false};
    EXPECT_EQ(out.str(), "64x36, spp 4, back_faces off, view level, integrator ao");
    std::ostringstream of_seed;
    of_seed << Settings{.seed = 12345678901234567890u};
    EXPECT_NE(of_seed.str().find("seed 12345678901234567890"), std::string::npos) << of_seed.str();
}

TEST(Tables, EveryFormatViewAndLayerIsInTheDocumentation)
{
    const std::string files = page("files.md"), outputs = page("outputs.md");
    for (const SceneFormat& f : scene_formats())
        expect_line(files, "| " + quoted(f.extensions) + " | " + std::string(f.name) + " | " + std::string(f.contents) +
                               " | " + std::string(f.up));
    for (const render::PictureFormat& f : render::picture_formats())
        expect_line(files,
                    "| " + quoted(f.extensions) + " | " + std::string(f.name) + " | " + std::string(f.contents) + " |\n");
    for (const render::ViewRow& row : render::kViews)
        expect_line(outputs, "| `" + std::string(row.name) + "` | " + std::string(row.help) + " |\n");
    for (const render::AovRow& row : render::kAovs) expect_line(outputs, "| `" + std::string(row.name) + "` | ");
}

TEST(Tables, FilesAreKnownByTheirExtensionsInAnyCase)
{
    EXPECT_EQ(scene_format_of("a/B.GLB")->name, "glTF 2.0");
    EXPECT_EQ(scene_format_of("a.Stl")->up, "z");
    for (const char* none : {"a", "a.", "a.gl", "a.glbb", "glb", "a. "}) EXPECT_EQ(scene_format_of(none), nullptr) << none;
    EXPECT_EQ(render::picture_format_of("x.JPEG")->name, "JPEG");
    EXPECT_EQ(render::picture_format_of("x.jp"), nullptr);
    EXPECT_TRUE(Image::has_layers("x.EXR"));
    EXPECT_FALSE(Image::is_for_display("x.hdr"));
    EXPECT_FALSE(Image::is_for_display("x"));
}

class TablesOfHelp : public CommandTest {};

TEST_F(TablesOfHelp, HaveEveryOptionChoiceAndFormat)
{
    const std::string render_help = run({"render", "--help"}).out, all = run({"--help"}).out;
    for (const render::SettingRow& row : render::kSettings)
        if (!row.help.empty()) expect_line(render_help, "--" + render::option_of(row) + " ");
    for (const render::ViewRow& row : render::kViews) expect_line(render_help, std::string(row.name));
    for (const SceneFormat& f : scene_formats()) expect_line(all, std::string(f.extensions));
    for (const render::PictureFormat& f : render::picture_formats()) expect_line(all, std::string(f.extensions));
}

// Returns the words of a help that are names of options.
std::vector<std::string> options_in(const std::string& help)
{
    static const std::regex kName("(^|[ ,])(--?[a-z][a-z0-9-]*)");
    std::vector<std::string> names;
    std::istringstream lines(help);
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with("  -")) continue;
        const std::string first = line.substr(2, line.find(' ', 2) - 2);
        for (std::sregex_iterator found(first.begin(), first.end(), kName), end; found != end; ++found)
            names.push_back((*found)[2]);
    }
    return names;
}

// Returns the row of a table that begins with that option, which another command may have, too.
std::string row_of(const std::string& text, const std::string& option, const std::string& command)
{
    std::istringstream lines(text);
    for (std::string line, cell = "`" + option + "`"; std::getline(lines, line);) {
        const std::string first = line.substr(0, line.find(" | "));
        if (!line.starts_with("| ") || first.find(cell) == std::string::npos) continue;
        const std::string second = line.substr(first.size() + 3, line.find(" | ", first.size() + 3) - first.size() - 3);
        const bool is_of_others = second.starts_with("`") && second.find("`" + command + "`") == std::string::npos &&
                                  std::regex_search(second, std::regex("`(info|verify|compare|texture|bench)`"));
        if (!is_of_others) return line;
    }
    return {};
}

TEST_F(TablesOfHelp, NameOptionsThatAreAllInTheDocumentation)
{
    const std::string settings = page("settings.md");
    std::size_t count = 0;
    for (const std::string command : {"", "render", "animate", "info", "verify", "compare", "texture", "bench"}) {
        std::vector<std::string> words{command, "--help"};
        if (command.empty()) words.erase(words.begin());
        for (const std::string& option : options_in(run(words).out)) {
            ++count;
            EXPECT_NE(row_of(settings, option, command), "") << "occam " << command << ' ' << option;
        }
    }
    EXPECT_GT(count, 150u) << "the helps were read";
    const auto expect_in = [&](const char* option, const char* command, std::uint64_t number) {
        const std::string row = row_of(settings, option, command);
        EXPECT_NE(row.find(std::to_string(number)), std::string::npos) << row;
    };
    expect_in("--size", "render", render::kMaxSide);
    expect_in("--size", "render", render::kMaxPixels);
    expect_in("--rays", "verify", kMostVerifyRays);
    expect_in("--shutter-segments", "render", kMaxShutterSegments);
    const std::string quality = row_of(settings, "--quality", "render");
    EXPECT_NE(run({"render", "--help"}).out.find("--spp 4, 16, 64 and --shading-rate 2, 1, 0.5"), std::string::npos);
    EXPECT_NE(quality.find("`--spp` 4, 16, 64 and `--shading-rate` 2, 1, 0.5"), std::string::npos) << quality;
}

}  // namespace
}  // namespace occam
