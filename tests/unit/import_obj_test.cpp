#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

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

const LoadOptions kSubdivided{.subdivide = Subdivide::On};

// A file that says nothing about subdivision holds the polygons of a modelling program.
TEST(ImportObj, OnlyWhatSaysSoIsSubdivided)
{
    const TempFolder folder;
    const auto file = folder.write("quad.obj", std::string(kQuad) + "f 1 2 3 4\n");
    const Scene quad = load(file);
    EXPECT_EQ(only_cage(quad).scheme, Scheme::Triangles);
    EXPECT_TRUE(only_cage(quad).normals.empty());
    EXPECT_TRUE(quad.warnings.empty());
    ASSERT_EQ(quad.notes.size(), 1u);
    EXPECT_NE(quad.notes[0].find("quad: 1 faces are rendered as they are, flat"), std::string::npos) << quad.notes[0];

    const Scene asked = load(file, kSubdivided);
    EXPECT_EQ(only_cage(asked).scheme, Scheme::CatmullClark);
    EXPECT_EQ(only_cage(asked).boundary, BoundaryRule::EdgeAndCorner);
    EXPECT_NE(asked.notes.at(0).find("Catmull-Clark surface (--subdivide on)"), std::string::npos) << asked.notes[0];

    const auto tagged = folder.write("tagged.obj", std::string(kQuad) + "f 1 2 3 4\nt crease 2/1/0 0 1 2.5\n");
    EXPECT_EQ(only_cage(load(tagged)).scheme, Scheme::CatmullClark);
    EXPECT_EQ(only_cage(load(tagged, {.subdivide = Subdivide::Off})).scheme, Scheme::Triangles);
    EXPECT_NE(load(tagged).notes.at(0).find("subdivision tags"), std::string::npos);
}

TEST(ImportObj, MarksOfUtf8ArePassedAndContinuedLinesAreJoined)
{
    const TempFolder folder;
    folder.write("red.mtl", "\xef\xbb\xbfnewmtl red\nKd 1 0 0\n");
    for (const char* end : {"\n", "\r\n"}) {
        const std::string joined = std::string("\\") + end;
        const auto file = folder.write("quad.obj", std::string("\xef\xbb\xbf# C:\\") + end + kQuad + "mtllib red.mtl" + end +
                                                       "usemtl red" + end + "f 1 2 " + joined + "3" + joined + " 4" + end);
        const Scene scene = load(file, kSubdivided);
        EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
        EXPECT_EQ(only_cage(scene).face_sizes.at(0), 4u);
        EXPECT_EQ(only_cage(scene).positions.size(), 4u);
        EXPECT_EQ(scene.counts().materials, 1u);
    }
}

TEST(ImportObj, TheNameOfAFileSaysItsSchemeAsOpenSubdivsShapesDo)
{
    const TempFolder folder;
    const std::string tagged = std::string(kQuad) + "f 1 2 3\nf 1 3 4\nt crease 2/1/0 0 1 2.5\n";
    const auto loop = folder.write("loop_cube.obj", tagged);
    EXPECT_NE(error_of(loop, kSubdivided).find("Loop"), std::string::npos);
    EXPECT_EQ(only_cage(load(loop)).scheme, Scheme::Triangles);
    EXPECT_TRUE(warns(load(loop), "Loop scheme"));
    EXPECT_EQ(error_of(loop, {.subdivide = Subdivide::Off}), "");
    EXPECT_EQ(only_cage(load(folder.write("bilinear_cube.obj", tagged))).scheme, Scheme::Bilinear);
}

// Holds the two faces of a roof, folded along the edge from vertex 2 to vertex 3.
constexpr const char* kRoof = "v -1 0 0\nv 0 1 0\nv 0 1 1\nv -1 0 1\nv 1 0 0\nv 1 0 1\n";

TEST(ImportObj, FacesWithoutNormalsAreFlatOrSmoothByTheirSmoothingGroups)
{
    const TempFolder folder;
    const auto roof = [&](const std::string& first, const std::string& second) {
        return load(folder.write("roof.obj", kRoof + first + "f 1 4 3 2\n" + second + "f 2 3 6 5\n"));
    };
    EXPECT_TRUE(only_cage(roof("", "")).normals.empty());
    EXPECT_TRUE(only_cage(roof("s 0\n", "s off\n")).normals.empty());

    const Scene smooth = roof("s 1\n", "");
    const Cage& cage = only_cage(smooth);
    ASSERT_EQ(cage.positions.size(), 6u);
    EXPECT_NEAR(cage.normals[1].y, 1, 1e-6);
    EXPECT_NEAR(cage.normals[0].x, -std::sqrt(0.5), 1e-6);
    EXPECT_NE(smooth.notes.at(0).find("smooth"), std::string::npos);

    for (const Scene& folded : {roof("s 1\n", "s 2\n"), roof("s 1\n", "s off\n"), roof("", "s 1\n")}) {
        const Cage& split = only_cage(folded);
        ASSERT_EQ(split.positions.size(), 8u) << "the two vertices of the ridge are split";
        for (const Vec3f n : split.normals) EXPECT_NEAR(n.y, std::sqrt(0.5), 1e-6);
    }
}

TEST(ImportObj, TheFilesNormalsGoBeforeSmoothingGroups)
{
    const TempFolder folder;
    const Scene scene = load(folder.write("n.obj", kRoof + std::string("vn 1 0 0\ns 1\nf 1//1 4//1 3//1 2//1\n"
                                                                       "f 2//9 3 6 5\n")));
    const Cage& cage = only_cage(scene);
    ASSERT_EQ(cage.positions.size(), 8u);
    EXPECT_EQ(cage.normals[0], Vec3f(1, 0, 0));
    EXPECT_GT(cage.normals[4].y, 0.7f) << "made, where the file has none or one that is not there";
    EXPECT_TRUE(warns(scene, "1 corners have no normal: the index is out of range"));
}

TEST(ImportObj, VerticesThatNoFaceUsesNeedNoNormal)
{
    const TempFolder folder;
    const std::string square = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    for (const char* faces : {"vn 0 0 1\nf 2//1 3//1 4//1 5//1\n", "s 1\nf 2 3 4 5\n"}) {
        const Scene scene = load(folder.write("a.obj", square + faces), {.strict = true});
        EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
    }
    const Scene scene = load(folder.write("a.obj", square + "vn 0 0 0\nf 2//1 3//1 4//1 5//1\n"));
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_NE(scene.warnings[0].find("4 normals had no direction"), std::string::npos) << scene.warnings[0];
}

TEST(ImportObj, IndicesOfNormalsAndTextureCoordinatesOutOfRangeAreReported)
{
    const TempFolder folder;
    const auto load_face = [&](const std::string& face) {
        return load(folder.write("n.obj", std::string(kQuad) + "vn 0 0 1\nvt 0 0\n" + face));
    };
    EXPECT_FALSE(warns(load_face("f 1/1/1 2/-1/-1 3//1\n"), "out of range"));
    EXPECT_TRUE(warns(load_face("f 1//1 2//2 3//-2\n"), "2 corners have no normal"));
    EXPECT_TRUE(warns(load_face("f 1//9 2 3\n"), "1 corners have no normal"));
    EXPECT_TRUE(warns(load_face("f 1/-2 2/1 3/-9\n"), "2 corners have no texture coordinates"));
    EXPECT_TRUE(warns(load_face("f 1/2 2/1 3/1\n"), "1 texture coordinates are not finite or out of range"));
}

TEST(ImportObj, MaterialsWithoutALibraryAreReported)
{
    const TempFolder folder;
    folder.write("empty.mtl", "# nothing\n");
    constexpr const char* kNote = "the file names materials but no library: the default material is used";
    const auto notes = [&](const std::string& library, const std::vector<std::string>& warnings) {
        const auto file = folder.write("o.obj", library + kQuad + "usemtl red\nf 1 2 3\nusemtl\nf 1 2 3\n");
        const Scene scene = load(file);
        EXPECT_EQ(scene.warnings, warnings) << library;
        EXPECT_TRUE(only_cage(scene).materials.empty()) << library;
        EXPECT_EQ(error_of(file, {.strict = true}).empty(), warnings.empty()) << library;
        return std::count(scene.notes.begin(), scene.notes.end(), kNote);
    };
    EXPECT_EQ(notes("", {}), 1) << "many files have no library";
    EXPECT_EQ(notes("mtllib\n", {}), 1);
    EXPECT_EQ(notes("mtllib empty.mtl\n", {"material is in no library (red)"}), 0);
    EXPECT_EQ(notes("mtllib none.mtl\n", {"material library is missing, or not in the scene's folder (none.mtl)"}), 0);
    EXPECT_TRUE(load(folder.write("o.obj", std::string(kQuad) + "usemtl\nf 1 2 3\n")).notes.empty());
}

// Each face has a normal of its own at the vertex that all share.
TEST(ImportObj, AVertexOfVeryManyNormalsIsSplitInGoodTime)
{
    constexpr int kFaces = 60'000;
    std::string text = "v 0 0 0\n";
    for (int i = 0; i <= kFaces; ++i) {
        const double angle = 6.28 * i / kFaces;
        text += "v " + std::to_string(std::cos(angle)) + " " + std::to_string(std::sin(angle)) + " 0.5\n";
    }
    for (int i = 0; i < kFaces; ++i) text += "vn 0 0 1\n";
    for (int i = 0; i < kFaces; ++i) {
        const std::string n = "//" + std::to_string(i + 1) + " ";
        text += "f 1" + n + std::to_string(i + 2) + n + std::to_string(i + 3) + n + "\n";
    }
    const TempFolder folder;
    const Scene scene = load(folder.write("fan.obj", text));
    EXPECT_EQ(only_cage(scene).face_count(), std::size_t(kFaces));
}

double area_of(const Cage& cage)
{
    double area = 0;
    for (std::size_t f = 0; f < cage.face_count(); ++f) {
        const auto p = [&](std::size_t c) { return Vec3d(cage.positions[cage.face_vertices[3 * f + c]]); };
        area += glm::cross(p(1) - p(0), p(2) - p(0)).z / 2;
    }
    return area;
}

// Returns a comb, half of whose corners are reflex.
std::string comb(int teeth)
{
    std::ostringstream text;
    for (int i = 0; i < teeth; ++i) text << "v " << 2 * i << " 0 0\nv " << 2 * i + 1 << " 5 0\n";
    text << "v " << 2 * teeth << " 0 0\nv " << 2 * teeth << " 9 0\nv 0 9 0\nf";
    for (int i = 1; i <= 2 * teeth + 3; ++i) text << ' ' << i;
    return text.str() + '\n';
}

TEST(ImportObj, ConcaveFacesOfManyCornersAreCutInside)
{
    const TempFolder folder;
    const Scene small = load(folder.write("comb.obj", comb(200)));
    double absolute = 0;
    const Cage& cage = only_cage(small);
    for (std::size_t f = 0; f < cage.face_count(); ++f) {
        const auto p = [&](std::size_t c) { return Vec3d(cage.positions[cage.face_vertices[3 * f + c]]); };
        absolute += std::abs(glm::cross(p(1) - p(0), p(2) - p(0)).z / 2);
    }
    EXPECT_DOUBLE_EQ(area_of(cage), 400 * 9 - 200 * 5);
    EXPECT_DOUBLE_EQ(absolute, area_of(cage)) << "no triangle is turned over";
    EXPECT_TRUE(small.warnings.empty());
    EXPECT_TRUE(warns(load(folder.write("large.obj", comb(300))), "cut as if it were convex"));
}

TEST(ImportObj, PolygonsAreCutWhenTheyMayNotBeSubdivided)
{
    const TempFolder folder;
    // The corner of this arrow head at (1, 1) is reflex, so a fan from the first corner would leave the polygon.
    const auto file = folder.write("concave.obj", "v 0 0 0\nv 2 0 0\nv 1 1 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4 5\n");
    const Scene scene = load(file, {.subdivide = Subdivide::Off});
    const Cage& cage = only_cage(scene);
    ASSERT_EQ(cage.face_count(), 3u);
    double area = 0;
    for (std::size_t f = 0; f < 3; ++f) {
        const auto p = [&](std::size_t c) { return Vec3d(cage.positions[cage.face_vertices[3 * f + c]]); };
        const double z = glm::cross(p(1) - p(0), p(2) - p(0)).z;
        EXPECT_GT(z, 0) << "every triangle faces as the polygon does";
        area += z / 2;
    }
    EXPECT_DOUBLE_EQ(area, 3.0);
}

TEST(ImportObj, ReadsTagsWithTheirZeroBasedIndices)
{
    const TempFolder folder;
    const Scene scene = load(folder.write("tags.obj", std::string(kQuad) +
                                                          "f 1 2 3 4\nf 1 3 2 4\n"
                                                          "t crease 2/1/0 0 1 2.5\nt crease 4/2/0 0 1 2 3 4 100\n"
                                                          "t corner 1/1/0 3 7\nt hole 1/0/0 1\n"
                                                          "t interpolateboundary 1/0/0 2\nt creasemethod 0/0/1 chaikin\n"));
    const Cage& cage = only_cage(scene);
    ASSERT_EQ(cage.creases.size(), 3u);
    EXPECT_EQ(cage.creases[0].v1, 1u);
    EXPECT_EQ(cage.creases[0].sharpness, 2.5f);
    EXPECT_EQ(cage.creases[2].sharpness, kInfiniteSharpness);
    ASSERT_EQ(cage.corners.size(), 1u);
    EXPECT_EQ(cage.corners[0].vertex, 3u);
    EXPECT_EQ(cage.holes, std::vector<std::uint32_t>{1});
    EXPECT_EQ(cage.boundary, BoundaryRule::EdgeOnly);
    EXPECT_TRUE(warns(scene, "tag not understood"));
    EXPECT_TRUE(warns(scene, "line 12"));
}

// tinyobjloader's own mesh drops such faces, so the hole would lie on another face.
TEST(ImportObj, ADegenerateFaceDoesNotMoveTheHoles)
{
    const TempFolder folder;
    const Scene scene = load(
        folder.write("holes.obj", std::string(kQuad) + "f 1 2\nf 1 2 3 4\nf 4 3 2 1\nt hole 1/0/0 2\n"));
    const Cage& cage = only_cage(scene);
    ASSERT_EQ(cage.face_count(), 2u);
    EXPECT_EQ(cage.holes, std::vector<std::uint32_t>{1});
    EXPECT_TRUE(warns(scene, "1 faces dropped"));
}

// tinyobjloader's own mesh also counts corners in a byte, so 300 would become 44.
TEST(ImportObj, APolygonOfThreeHundredCornersKeepsThemAll)
{
    const TempFolder folder;
    std::string text, face = "f";
    for (int i = 0; i < 300; ++i) {
        text.append("v ").append(std::to_string(i)).append(" ").append(std::to_string(i * i)).append(" 0\n");
        face.append(" ").append(std::to_string(i + 1));
    }
    const Scene scene = load(folder.write("large.obj", text + face + "\nf 1 2 3\n"), kSubdivided);
    EXPECT_EQ(only_cage(scene).face_sizes, (std::vector<std::uint32_t>{300, 3}));
}

TEST(ImportObj, TextureCoordinatesRunDownwardsAndBelongToCorners)
{
    const TempFolder folder;
    const Scene scene = load(
        folder.write("uv.obj", std::string(kQuad) + "vt 0 0\nvt 1 0.25\nf 1/1 2/2 3/2 4/-2\nf 1 2 3/1\n"), kSubdivided);
    const Cage& cage = only_cage(scene);
    ASSERT_EQ(cage.uv_sets.size(), 1u);
    const UvSet& uv = cage.uv_sets[0];
    EXPECT_EQ(uv.values[0], Vec2f(0, 1));
    EXPECT_EQ(uv.values[1], Vec2f(1, 0.75f));
    EXPECT_EQ(uv.indices, (std::vector<std::uint32_t>{0, 1, 1, 0, 2, 2, 0}));
    EXPECT_EQ(uv.values.size(), 3u) << "corners without coordinates share one value";
}

TEST(ImportObj, NegativeIndicesCountBackFromTheFace)
{
    const TempFolder folder;
    const Scene scene = load(
        folder.write("negative.obj", std::string(kQuad) + "f -4 -3 -2 -1\nv 9 9 9\nf -5 -4 -3\nf -99 1 2\nf 0 1 2\n"),
        kSubdivided);
    const Cage& cage = only_cage(scene);
    EXPECT_EQ(cage.face_vertices, (std::vector<std::uint32_t>{0, 1, 2, 3, 0, 1, 2}));
    EXPECT_TRUE(warns(scene, "2 faces dropped: a vertex index is out of range"));
}

TEST(ImportObj, VerticesWithSeveralNormalsAreSplit)
{
    const TempFolder folder;
    const Scene scene = load(
        folder.write("normals.obj", std::string(kQuad) + "vn 0 0 1\nvn 0 1 0\nf 1//1 2//1 3//1\nf 1//2 3//1 4//1\n"));
    const Cage& cage = only_cage(scene);
    ASSERT_EQ(cage.positions.size(), 5u);
    EXPECT_EQ(cage.face_vertices, (std::vector<std::uint32_t>{0, 1, 2, 4, 2, 3}));
    EXPECT_EQ(cage.normals[4], Vec3f(0, 1, 0));
    EXPECT_EQ(cage.positions[4], cage.positions[0]);
}

TEST(ImportObj, MaterialsBecomeSlots)
{
    const TempFolder folder;
    folder.write("a b.mtl", "newmtl red\nKd 1 0 0\nNs 2\nKe 2 2 2\nnewmtl glass\nd 0.5\nPr 0.25\nPm 1\nmap_Kd tex.png\n");
    folder.write("tex.png", "");
    const Scene scene = load(
        folder.write("mtl.obj", "mtllib a b.mtl\n" + std::string(kQuad) +
                                    "f 1 2 3 4\nusemtl glass \nf 1 2 3 4\nusemtl red\nf 1 2 3 4\nusemtl nope\nf 1 2 3 4\n"),
        kSubdivided);
    const Cage& cage = only_cage(scene);
    EXPECT_EQ(cage.face_slots, (std::vector<std::uint16_t>{0, 1, 2, 0}));
    ASSERT_EQ(cage.materials.size(), 3u);
    EXPECT_EQ(scene.find(cage.materials[0]), nullptr) << "no material: the default one";
    const Material& glass = scene.material(cage.materials[1]);
    EXPECT_EQ(glass.base_color, Vec4f(1, 1, 1, 0.5f));
    EXPECT_EQ(glass.alpha_mode, AlphaMode::Blend);
    EXPECT_EQ(glass.metallic, 1);
    EXPECT_EQ(glass.roughness, 0.25f);
    EXPECT_EQ(scene.texture(glass.base_color_texture.texture).path.filename(), "tex.png");
    const Material& red = scene.material(cage.materials[2]);
    EXPECT_EQ(red.base_color, Vec4f(1, 0, 0, 1));
    EXPECT_EQ(red.emission, Vec3f(2));
    EXPECT_TRUE(warns(scene, "material is in no library (nope)"));
}

TEST(ImportObj, NothingOutsideOfTheFolderIsOpened)
{
    const TempFolder folder;
    folder.write("secret.mtl", "newmtl m\nKd 1 0 0\n");
    folder.write("scene/own.mtl", "newmtl m\nmap_Kd ../secret.png\n");
    const Scene scene = load(folder.write(
        "scene/o.obj", "mtllib ../secret.mtl\nmtllib own.mtl\n" + std::string(kQuad) + "usemtl m\nf 1 2 3 4\n"));
    EXPECT_TRUE(warns(scene, "material library is missing"));
    EXPECT_TRUE(warns(scene, "texture is not in the scene's folder"));
    EXPECT_EQ(scene.counts().textures, 0u);
}

TEST(ImportObj, SaysWhatIsWrong)
{
    const TempFolder folder;
    EXPECT_NE(error_of(folder.path() / "missing.obj").find("missing.obj: no such file"), std::string::npos);
    EXPECT_NE(error_of(folder.path()).find("is a folder"), std::string::npos);
    EXPECT_NE(error_of(folder.write("text.txt", "x")).find("not a scene file"), std::string::npos);
    EXPECT_NE(error_of(folder.write("empty.obj", "")).find("empty.obj: the file is empty"), std::string::npos);
    EXPECT_NE(error_of(folder.write("blank.obj", "\n")).find("no face"), std::string::npos);
    EXPECT_NE(error_of(folder.write("points.obj", "v 0 0 0\np 1\n")).find("no face"), std::string::npos);
    std::filesystem::create_directory(folder.path() / "folder.obj");
    EXPECT_NE(error_of(folder.path() / "folder.obj").find("is a folder"), std::string::npos);
    const auto bad = folder.write("bad.obj", std::string(kQuad) + "f 1 2 3 4\nf 1 2 9\n");
    EXPECT_EQ(error_of(bad), "");
    EXPECT_NE(error_of(bad, {.strict = true}).find("out of range"), std::string::npos) << "strict makes an error of it";
}

TEST(ImportObj, CoordinatesThatAreNotFiniteAreDropped)
{
    const TempFolder folder;
    const Scene scene = load(
        folder.write("inf.obj", std::string(kQuad) + "v 1e300 0 0\nv 1e17 0 0\nf 1 2 3 4\nf 1 2 5\nf 1 2 6\n"), kSubdivided);
    EXPECT_EQ(only_cage(scene).face_count(), 1u);
    EXPECT_TRUE(warns(scene, "not finite"));

    for (const char* word : {"nan", "-nan(ind)", "inf", "1.#IND", "-1.#QNAN00"}) {
        const std::string elements = std::string("v 0 ") + word + " 0\nvt 0 " + word + "\nvn " + word + " 0 1\n";
        const Scene other = load(folder.write("nan.obj", std::string(kQuad) + elements + "f 1/1/1 2/1/1 3/1/1\nf 1 2 5\n"));
        EXPECT_EQ(only_cage(other).face_count(), 1u) << word;
        EXPECT_TRUE(warns(other, "1 faces dropped: a vertex is not finite")) << word;
        EXPECT_TRUE(warns(other, "1 texture coordinates are not finite")) << word;
        EXPECT_TRUE(warns(other, "normals had no direction")) << word;
    }
}

}  // namespace
}  // namespace occam
