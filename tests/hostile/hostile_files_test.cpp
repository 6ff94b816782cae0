// Every hostile file of the shared data is refused with one line, or loads with its repairs counted. By default every third
// one is read.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "occam/occam.h"
#include "tests/support/campaign.h"
#include "tests/support/file_outcome.h"
#include "tests/support/import_errors.h"
#include "tests/support/scene_files.h"
#include "tests/support/shared_data.h"

namespace occam {
namespace {

namespace fs = std::filesystem;

TEST(HostileFiles, EachIsRefusedInOneLineOrLoads)
{
    const fs::path folder = test::shared_data() / "data" / "hostile";
    if (test::shared_data().empty() || !fs::exists(folder)) GTEST_SKIP() << "the shared test data is not there";
    const auto files = test::scene_files_below(folder);
    EXPECT_GT(files.size(), 300u);
    test::EveryNth some(3);
    for (const fs::path& file : files) {
        if (!some.takes()) continue;
        const test::FileOutcome outcome = test::outcome_of(file);
        EXPECT_EQ(outcome.error.find('\n'), std::string::npos) << outcome.error;
        const bool names_it = outcome.error.empty() || outcome.error.find(file.filename().string()) != std::string::npos;
        EXPECT_TRUE(names_it) << outcome.error;
    }
}

// The reports are those of the Khronos glTF-Validator; severity 0 is an error.
TEST(HostileFiles, WhatTheValidatorCallsAnErrorNeverPassesInSilence)
{
    const fs::path folder = test::shared_data() / "data" / "hostile" / "gltf-validator";
    if (test::shared_data().empty() || !fs::exists(folder)) GTEST_SKIP() << "the shared test data is not there";
    int judged = 0;
    for (const fs::path& file : test::scene_files_below(folder)) {
        std::ifstream report(file.string() + ".report.json");
        std::stringstream text;
        text << report.rdbuf();
        if (text.str().find("\"numErrors\": 0") != std::string::npos || !report) continue;
        ++judged;
        const test::FileOutcome outcome = test::outcome_of(file);
        EXPECT_TRUE(!outcome.error.empty() || !outcome.warnings.empty()) << file;
    }
    EXPECT_GT(judged, 100);
}

TEST(SharedData, EveryModelThatIsNotHostileLoads)
{
    const fs::path folder = test::shared_data() / "data";
    if (test::shared_data().empty() || !fs::exists(folder)) GTEST_SKIP() << "the shared test data is not there";
    test::EveryNth some(2);
    for (const char* part : {"gltf", "subdiv", "scenes"})
        for (const fs::path& file : test::scene_files_below(folder / part)) {
            if (!some.takes()) continue;
            const std::string error = test::error_of(file);
            // These two ask for a later version of glTF and an extension that does not exist, so refusing them is correct.
            const std::string name = file.stem().string();
            const std::string expected = name == "Compatibility_04"   ? "2.1"
                                         : name == "Compatibility_05" ? "FAKE_materials_quantumRendering"
                                                                      : "";
            EXPECT_EQ(error.empty(), expected.empty()) << file << ": " << error;
            EXPECT_NE(error.find(expected), std::string::npos) << error;
        }
}

TEST(SharedData, TheChessSetSharesItsCages)
{
    const fs::path file = test::shared_data() / "data" / "subdiv" / "chess" / "chess_set.gltf";
    if (test::shared_data().empty() || !fs::exists(file)) GTEST_SKIP() << "the shared test data is not there";
    const Scene scene = load(file);
    EXPECT_EQ(scene.counts().cages, 7u);
    EXPECT_EQ(scene.placed_faces(), 723'568u);
    EXPECT_TRUE(scene.warnings.empty());
}

}  // namespace
}  // namespace occam
