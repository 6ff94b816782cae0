// Runs scene files of the shared data through the executable: valid files give pictures; the others give one line or a
// picture, within 20 s and one GiB. Every twelfth file is run by default, and all of them with OCCAM_LONG=1.
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/campaign.h"
#include "tests/support/child_process.h"
#include "tests/support/scene_files.h"
#include "tests/support/shared_data.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kSeconds = 20;
constexpr std::size_t kPeakBytes = std::size_t(1) << 30;

// These two ask for a later version of glTF, and for an extension that does not exist.
const std::map<std::string, std::string> kRefused = {{"Compatibility_04", "2.1"},
                                                     {"Compatibility_05", "FAKE_materials_quantumRendering"}};

class SceneFiles : public testing::TestWithParam<const char*> {
protected:
    void SetUp() override
    {
        if (kIsSanitized) GTEST_SKIP() << "sanitizers take more time and memory than the limits allow";
        if (shared_data().empty() || !fs::exists(folder()))
            GTEST_SKIP() << "the shared folder is absent: its scene files are not run";
    }
    fs::path folder() const { return shared_data() / "data" / GetParam(); }

    std::vector<fs::path> files() const
    {
        const std::vector<fs::path> all = scene_files_below(folder());
        std::vector<fs::path> some;
        for (std::size_t i = 0; i < all.size(); i += is_long() ? 1 : 12) some.push_back(all[i]);
        return some;
    }

    ChildOutcome render(const fs::path& scene) const
    {
        fs::remove(picture_);
        return run_occam({"render", scene.string(), "-o", picture_.string(), "--size", "32x24", "--spp", "1"}, kSeconds);
    }
    bool has_picture() const { return fs::exists(picture_); }

private:
    const TempFolder temp_;
    const fs::path picture_ = temp_.path() / "picture.png";
};

bool is_one_line(const std::string& text) { return !text.empty() && text.find('\n') == text.size() - 1; }

// Returns true if there are only notes and warnings: five warnings at most, and the number of the rest.
bool has_few_lines(const std::string& text)
{
    std::istringstream lines(text);
    int count = 0;
    for (std::string line; std::getline(lines, line); ++count)
        if (!line.starts_with("occam: ")) return false;
    return count <= 8;
}

class ValidFiles : public SceneFiles {};
TEST_P(ValidFiles, GiveAPicture)
{
    for (const fs::path& file : files()) {
        const ChildOutcome outcome = render(file);
        if (const auto refused = kRefused.find(file.stem().string()); refused != kRefused.end()) {
            EXPECT_EQ(outcome.exit_code, 2) << file;
            EXPECT_NE(outcome.err.find(refused->second), std::string::npos) << outcome.err;
            continue;
        }
        EXPECT_EQ(outcome.exit_code, 0) << file << " signal " << outcome.signal << ": " << outcome.err;
        EXPECT_TRUE(has_picture()) << file;
        EXPECT_TRUE(has_few_lines(outcome.err)) << file << ": " << outcome.err;
    }
}
INSTANTIATE_TEST_SUITE_P(Shared, ValidFiles, testing::Values("gltf", "subdiv", "scenes", "motion"));

class HostileFilesInAProcess : public SceneFiles {};
TEST_P(HostileFilesInAProcess, EndInOneLineOrAPictureWithinLimits)
{
    for (const fs::path& file : files()) {
        const ChildOutcome outcome = render(file);
        if (outcome.exit_code == 2) {
            EXPECT_TRUE(is_one_line(outcome.err)) << file << ": " << outcome.err;
            EXPECT_EQ(outcome.err.find("occam: " + file.string()), 0u) << outcome.err;
        } else {
            EXPECT_EQ(outcome.exit_code, 0) << file << " signal " << outcome.signal << ": " << outcome.err;
            EXPECT_TRUE(has_picture()) << file;
        }
        EXPECT_NE(outcome.signal, SIGALRM) << file << " takes more than " << kSeconds << " s";
        EXPECT_LE(outcome.peak_bytes, kPeakBytes) << file;
    }
}
INSTANTIATE_TEST_SUITE_P(Shared, HostileFilesInAProcess,
                         testing::Values("hostile/assimp", "hostile/gltf-validator", "hostile/missing-images",
                                         "hostile/tinygltf", "hostile/tinyobj"));

// A hit that is scattered no further draws as many directions as a light has samples, each a path if a surface glows.
TEST(CommandLimits, ManyLightSamplesTakeNoMemoryWithoutEnd)
{
    if (kIsSanitized) GTEST_SKIP() << "sanitizers take more memory than the limit allows";
    const TempFolder temp;
    std::ofstream(temp.path() / "glow.mtl") << "newmtl lamp\nKd 1 1 1\nKe 5 5 5\nnewmtl floor\nKd 0.5 0.5 0.5\n";
    std::ofstream(temp.path() / "glow.obj")
        << "mtllib glow.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 -1 1\nv -1 1 1\nv -0.8 0 1.5\n"
           "usemtl floor\nf 1 2 3 4\nusemtl lamp\nf 5 6 7\n";
    const std::string scene = (temp.path() / "glow.obj").string(), picture = (temp.path() / "a.exr").string();
    const ChildOutcome outcome = run_occam({"render", scene, "-o", picture, "--size", "32x32", "--spp", "4", "--integrator",
                                            "direct", "--light-samples", "512", "--threads", "1", "--look-at=0,0,3,0,0,0"},
                                           60);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_LE(outcome.peak_bytes, std::size_t(256) << 20);
}

}  // namespace
}  // namespace occam::test
