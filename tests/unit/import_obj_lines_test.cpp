// Tests of the lines of OBJ files and of the numbers in them.
#include <gtest/gtest.h>

#include <algorithm>

#include "scenegraph/scene.h"
#include "tests/support/import_errors.h"
#include "tests/support/temp_folder.h"

namespace occam {
namespace {

using test::error_of;
using test::kQuad;
using test::only_cage;
using test::TempFolder;
using test::warns;

TEST(ImportObjLines, MalformedNumbersAreRefusedWithTheirLine)
{
    const TempFolder folder;
    const auto refusal = [&](const std::string& line) {
        return error_of(folder.write("bad.obj", std::string(kQuad) + "vt 0 \\\n 0\nvn 0 0 1\n" + line + "\nf 1 2 3\n"));
    };
    for (const char* line : {"v 0,5 0 0", "v 0 abc 0", "v 0 0 1.2.3", "v 0 0 1-2", "v 0 0 --1", "v 0 0 .", "v 0 0 1e",
                             "v 0 0 +-1", "vn 0 0 x", "vt 0,5 0", "vt 0 0,5", "v 1#2 0 0"})
        EXPECT_NE(refusal(line).find("bad.obj: a number is malformed (line 8)"), std::string::npos) << line << refusal(line);
    for (const char* line : {"v", "v 1", "v 1 2 ", "v 1 2 # 3", "vn 0 0", "vt", "vt\t# 0"})
        EXPECT_NE(refusal(line).find("a number is missing (line 8)"), std::string::npos) << line << refusal(line);
    for (const char* line :
         {"f 1 2 x", "f 1,2,3", "f 1 2 3.5", "f 1/1/1/1 2 3", "f /1 2 3", "f 1 2 4294967297", "f 1 2 3#4"})
        EXPECT_NE(refusal(line).find("an index of a face is not a whole number (line 8)"), std::string::npos) << line;
    for (const char* line :
         {"v +1 -.5 5. # 0,5", "v 1e-3 1E+2 -0", "v 1e400 1e-400 0", "v 1 2 3 1", "v\t1 2 3 0 0 1\t", "vt 0.5", "vt 0 0 [0]",
          "vp 1,5", "vn 0 0 1 x", "f -1 +2 3", "f 1/ 2/ 3//", "f 1/1/1 2//1 3/1", "f"})
        EXPECT_EQ(refusal(line), "") << line;
}

TEST(ImportObjLines, FacesOfFewerThanThreeCornersAreReported)
{
    const TempFolder folder;
    const std::string quad = std::string(kQuad) + "f 1 2 3 4\n";
    for (const char* line : {"f", "f 1", "f 1 2"}) {
        const Scene scene = load(folder.write("few.obj", quad + line + "\nf 1 2 3\n" + line + "\n"));
        EXPECT_TRUE(warns(scene, "a face of fewer than three corners is left out (line 6, first of 2)")) << line;
        EXPECT_EQ(only_cage(scene).face_count(), 3u) << line;  // a quad is two triangles
    }
}

TEST(ImportObjLines, SlashesAtTheEndOfACornerNameNothing)
{
    const TempFolder folder;
    const auto sets_of_uvs = [&](const std::string& face) {
        const Scene scene = load(
            folder.write("o.obj", std::string(kQuad) + "vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n" + face + "\n"));
        EXPECT_EQ(scene.warnings, std::vector<std::string>()) << face;
        EXPECT_EQ(only_cage(scene).face_count(), 1u) << face;
        return only_cage(scene).uv_sets.size();
    };
    EXPECT_EQ(sets_of_uvs("f 1/ 2/ 3/"), 0u);
    EXPECT_EQ(sets_of_uvs("f 1// 2// 3//"), 0u);
    EXPECT_EQ(sets_of_uvs("f 1/ \\\n2//\t3/ "), 0u);
    EXPECT_EQ(sets_of_uvs("f 1/1/ 2/2/ 3/3/"), 1u) << "and no normals, of which there is only one";
}

TEST(ImportObjLines, WordsAfterAPositionThatAreNoNumbersAreReported)
{
    const TempFolder folder;
    const Scene scene = load(folder.write("o.obj", "v 0 0 0 0,5 0,5 0,5\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
    EXPECT_TRUE(warns(scene, "words after a vertex's position are no numbers (line 1, first of 3)"));
}

TEST(ImportObjLines, StatementsThatAreNotReadAreNamed)
{
    const TempFolder folder;
    const auto read = [&](const std::string& lines) {
        return load(folder.write("a.obj", std::string(kQuad) + lines + "\nf 1 2 3 4\n"));
    };
    for (const char* word : {"fo", "F", "V", "call", "usemap", "vertex", "f\v1"}) {
        const Scene scene = read("\n" + std::string(word) + " 1 2 3");
        EXPECT_TRUE(warns(scene, "statement '" + std::string(word) + "' is not read (line 6)")) << word;
        EXPECT_EQ(only_cage(scene).face_count(), 2u) << word;
    }
    EXPECT_TRUE(warns(read("#MRGB ff0000ffff00ff00"), "colours in comments, as ZBrush writes them (#MRGB), are not read"));
    EXPECT_TRUE(read("g a\no b\nmg off\ns off\nvp 1 2\nvn 0 0 1\nvt 0 0\nlod 1\nbevel on\nc_interp off\n\t\n# x y")
                    .warnings.empty());
}

TEST(ImportObjLines, CommentsMayFollowAStatement)
{
    const TempFolder folder;
    const Scene scene = load(folder.write("c.obj",
                                          "v 0 0 0 # 1 2\nv 1 0 0\t#1 1 1\nv 1 1 0\nv 0 1 0\nvt 0 # 0.5\nvn 0 0 1 # C:\\\n"
                                          "f 1/1/1 2/1/1 3/1/1 # 4\nf 1 \\\r\n 3 \\\n 2 # 2\nf 1 3 \\\n 4 # 2\n"
                                          "t corner 1/1/0 3 # 7\n"),
                             {.subdivide = Subdivide::On});
    const Cage& cage = only_cage(scene);
    EXPECT_EQ(cage.face_sizes, (std::vector<std::uint32_t>{3, 3, 3}));
    EXPECT_EQ(cage.uv_sets.at(0).values.at(0), Vec2f(0, 1));
    EXPECT_TRUE(cage.colors.empty());
    EXPECT_TRUE(cage.corners.empty()) << "its sharpness is in a comment";
    EXPECT_TRUE(warns(scene, "tag not understood"));
}

TEST(ImportObjLines, LinesMayEndWithACarriageReturnAlone)
{
    const TempFolder folder;
    folder.write("red.mtl", "newmtl red\rKd 1 0 0\r");
    const std::string text = "# a comment\nmtllib red.mtl\n" + std::string(kQuad) +
                             "usemtl red\ns 1\nf 1 2 \\\n3 4\nt crease 2/1/0 0 1 2\n";
    std::string with_cr = text;
    std::replace(with_cr.begin(), with_cr.end(), '\n', '\r');
    for (const std::string& lines : {text, with_cr}) {
        const Scene scene = load(folder.write("cr.obj", lines));
        EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
        EXPECT_EQ(scene.counts().materials, 1u);
        EXPECT_EQ(only_cage(scene).face_sizes, std::vector<std::uint32_t>{4});
        EXPECT_EQ(only_cage(scene).creases.size(), 1u);
    }
}

}  // namespace
}  // namespace occam
