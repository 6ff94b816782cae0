// Tests of how names in a scene become files: by the same rules as std::filesystem has, and in time for any name.
#include <gtest/gtest.h>

#include <ctime>
#include <filesystem>
#include <optional>
#include <string>

#include "io/import/folder.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

namespace fs = std::filesystem;

// Returns what the names meant before each of them was looked for by few questions.
std::optional<fs::path> by_the_library(const fs::path& folder, const std::string& relative)
{
    if (relative.empty() || fs::path(relative).is_absolute()) return std::nullopt;
    std::error_code error;
    const fs::path root = fs::weakly_canonical(folder, error);
    const fs::path target = fs::weakly_canonical(root / relative, error);
    if (error) return std::nullopt;
    const fs::path rest = target.lexically_relative(root);
    if (rest.empty() || *rest.begin() == ".." || rest == ".") return std::nullopt;
    return target;
}

TEST(ImportFolder, NamesMeanWhatTheLibrarySays)
{
    const TempFolder folder;
    const fs::path scene = fs::path(folder.write("scene/a.png", "a")).parent_path();
    folder.write("scene/sub/deep/b.png", "b");
    folder.write("outside/c.png", "c");
    fs::create_directory_symlink("../outside", scene / "out");
    fs::create_directory_symlink("sub/deep", scene / "in");
    fs::create_symlink("../outside/c.png", scene / "link.png");
    fs::create_symlink("none", scene / "broken");
    fs::create_symlink("loop", scene / "loop");
    const std::string parts[] = {"a.png", "sub", "deep", "b.png", "out", "in", "link.png",           "broken",
                                 "loop",  "..",  ".",    "c.png", "",    "no", std::string(300, 'x')};
    import::Folder known(scene);
    std::size_t found = 0;
    for (const std::string& first : parts)
        for (const std::string& second : parts)
            for (const std::string& third : parts)
                for (const std::string& name : {first, first + "/" + second, first + "/" + second + "/" + third}) {
                    const auto expected = by_the_library(scene, name);
                    EXPECT_EQ(import::inside(scene, name), expected) << name;
                    EXPECT_EQ(known.find(name).path, expected) << name;
                    found += known.find(name).is_file;
                }
    EXPECT_GT(found, 100u);
}

TEST(ImportFolder, LongNamesTakeNoLongerThanTheirLength)
{
    const TempFolder folder;
    const fs::path scene = fs::path(folder.write("scene/a.png", "a")).parent_path();
    std::string there, missing;
    for (int i = 0; i < 1900; ++i) there += "./", missing += i % 2 ? "./" : "/";
    const std::clock_t start = std::clock();
    for (int i = 0; i < 100; ++i) {
        EXPECT_TRUE(import::inside(scene, there + "a.png"));
        EXPECT_TRUE(import::inside(scene, "./" + missing + "none.png"));
    }
    EXPECT_LT(double(std::clock() - start) / CLOCKS_PER_SEC, 5) << "the library takes tens of seconds";
}

}  // namespace
}  // namespace occam::test
