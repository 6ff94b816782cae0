#include <gtest/gtest.h>

#include <bit>
#include <cstring>

#include "scenegraph/scene.h"
#include "tests/support/import_errors.h"
#include "tests/support/temp_folder.h"

namespace occam {
namespace {

using test::error_of;
using test::only_cage;
using test::TempFolder;
using test::warns;

class Bytes {
public:
    explicit Bytes(bool big_endian) : big_endian_(big_endian) {}
    template <class T>
    Bytes& add(T value)
    {
        char raw[sizeof(T)];
        std::memcpy(raw, &value, sizeof(T));
        for (std::size_t i = 0; i < sizeof(T); ++i) text_ += raw[big_endian_ ? sizeof(T) - 1 - i : i];
        return *this;
    }
    const std::string& text() const { return text_; }

private:
    bool big_endian_;
    std::string text_;
};

std::string ply_header(const std::string& format, const std::string& elements)
{
    return "ply\nformat " + format + " 1.0\ncomment anything element vertex 9\n" + elements + "end_header\n";
}
constexpr const char* kSquare =
    "element vertex 4\nproperty float x\nproperty double y\nproperty short z\nelement face 1\nproperty list uchar int "
    "vertex_indices\n";

TEST(ImportPly, ReadsTheSameFromAllThreeEncodings)
{
    const TempFolder folder;
    const auto ascii = folder.write("a.ply", ply_header("ascii", kSquare) + "0 0 0 1 0 0\n1 1 0 0 1 -7 4 0 1 2 3");
    const auto binary = [&](bool big) {
        Bytes b(big);
        const float x[] = {0, 1, 1, 0};
        const double y[] = {0, 0, 1, 1};
        for (int i = 0; i < 4; ++i) b.add(x[i]).add(y[i]).add(static_cast<std::int16_t>(i == 3 ? -7 : 0));
        b.add(std::uint8_t(4)).add(0).add(1).add(2).add(3);
        return b.text();
    };
    const auto little = folder.write("l.ply", ply_header("binary_little_endian", kSquare) + binary(false));
    const auto big = folder.write("b.ply", ply_header("binary_big_endian", kSquare) + binary(true));
    for (const auto& file : {ascii, little, big}) {
        EXPECT_EQ(only_cage(load(file)).scheme, Scheme::Triangles) << "nothing in it speaks of subdivision";
        const Scene scene = load(file, {.subdivide = Subdivide::On});
        const Cage& cage = only_cage(scene);
        ASSERT_EQ(cage.positions.size(), 4u) << file;
        EXPECT_EQ(cage.positions[3], Vec3f(0, 1, -7)) << file;
        EXPECT_EQ(cage.face_vertices, (std::vector<std::uint32_t>{0, 1, 2, 3})) << file;
        EXPECT_EQ(cage.scheme, Scheme::CatmullClark);
    }
}

TEST(ImportPly, ReadsNormalsCoordinatesAndColours)
{
    const TempFolder folder;
    const Scene scene = load(folder.write(
        "v.ply",
        ply_header("ascii",
                   "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\n"
                   "property float ny\nproperty float nz\nproperty float s\nproperty float t\nproperty uchar red\n"
                   "property uchar green\nproperty uchar blue\nproperty list uchar float ignored\n"
                   "element face 1\nproperty list uchar uint vertex_index\n") +
            "0 0 0 0 0 1 0 0 255 0 128 2 7 7\n1 0 0 0 0 1 1 0 255 0 128 0\n0 1 0 0 0 1 0 1 255 0 128 1 3\n3 0 1 2\n"));
    const Cage& cage = only_cage(scene);
    EXPECT_EQ(cage.scheme, Scheme::Triangles);
    EXPECT_EQ(cage.normals[2], Vec3f(0, 0, 1));
    EXPECT_EQ(cage.uv_sets.at(0).values[2], Vec2f(0, 0)) << "v runs upwards in the file";
    EXPECT_EQ(cage.colors[0].x, 1.0f);
    EXPECT_NEAR(cage.colors[0].z, 0.21586f, 1e-4f) << "bytes are sRGB";
}

std::string colored_ply(const std::string& type, const std::string& color, const std::string& prefix = "")
{
    std::string elements = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    for (const char* part : {"red", "green", "blue"}) elements += "property " + type + " " + prefix + part + "\n";
    std::string rows;
    for (const char* place : {"0 0 0 ", "1 0 0 ", "0 1 0 "}) rows += place + color + "\n";
    return ply_header("ascii", elements + "element face 1\nproperty list uchar int vertex_indices\n") + rows + "3 0 1 2\n";
}

TEST(ImportPly, ColoursAreWhatTheirTypeSays)
{
    const TempFolder folder;
    const auto read = [&](const std::string& text) { return load(folder.write("c.ply", text)); };
    for (const Scene& scene :
         {read(colored_ply("ushort", "65535 0 32896")), read(colored_ply("int", "255 0 128")),
          read(colored_ply("short", "255 0 128")), read(colored_ply("uchar", "255 0 128", "diffuse_"))}) {
        ASSERT_EQ(only_cage(scene).colors.size(), 3u);
        const Vec4f color = only_cage(scene).colors[1];
        EXPECT_EQ(color, Vec4f(1, 0, color.z, 1));
        EXPECT_NEAR(color.z, 0.21586f, 1e-4f) << "integers are sRGB";
        EXPECT_TRUE(scene.warnings.empty());
    }
    const Scene floats = read(colored_ply("float", "255 0 0.5"));
    EXPECT_EQ(only_cage(floats).colors[1], Vec4f(1, 0, 0.5f, 1));
    EXPECT_TRUE(warns(floats, "colours are not between 0 and 1"));
    EXPECT_TRUE(warns(read(colored_ply("int", "256 0 0")), "colours are not between 0 and 1"));
}

TEST(ImportPly, FacesMayHaveColours)
{
    const TempFolder folder;
    const std::string faces =
        "element face 3\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        "property list uchar int vertex_indices\nproperty list uchar float texcoord\n";
    const std::string vertices = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string places = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    const std::string rows = "255 0 0 4 0 1 2 3 0\n7 7 7 2 0 1 0\n0 0 255 3 0 1 2 6 0 0 0 0 0 0\n";
    const auto file = folder.write("f.ply",
                                   ply_header("ascii", "comment TextureFile a.png\n" + vertices + faces) + places + rows);
    for (const Subdivide subdivide : {Subdivide::Off, Subdivide::On}) {
        const Scene scene = load(file, {.subdivide = subdivide});
        const Cage& cage = only_cage(scene);
        const std::size_t first = subdivide == Subdivide::On ? 4 : 6;
        ASSERT_EQ(cage.color_indices.size(), first + 3);
        for (std::size_t c = 0; c < first + 3; ++c)
            EXPECT_EQ(cage.colors[cage.color_indices[c]], c < first ? Vec4f(1, 0, 0, 1) : Vec4f(0, 0, 1, 1));
        EXPECT_TRUE(warns(scene, "texture coordinates of faces are not read (3 times)"));
        EXPECT_TRUE(warns(scene, "texture files are not read"));
    }
}

TEST(ImportPly, DeclaredSizesAreCheckedBeforeAnythingIsAllocated)
{
    const TempFolder folder;
    const std::string vertices = "element vertex 2000000000\nproperty float x\nproperty float y\nproperty float z\n";
    EXPECT_NE(error_of(folder.write("a.ply", ply_header("ascii", vertices) + "0 0 0\n")).find("more than the file holds"),
              std::string::npos);
    EXPECT_NE(error_of(folder.write("b.ply", ply_header("binary_little_endian", vertices) + "0000"))
                  .find("more than the file holds"),
              std::string::npos);
    const std::string list = "element face 1\nproperty list uint int vertex_indices\n";
    EXPECT_NE(error_of(folder.write("c.ply", ply_header("binary_little_endian", list) + std::string(8, '\xff')))
                  .find("longer than the file"),
              std::string::npos);
    const std::string nothing = "element vertex 4000000000\n";
    EXPECT_NE(error_of(folder.write("d.ply", ply_header("ascii", nothing))).find("no face"), std::string::npos);
}

TEST(ImportPly, ElementsOfVerticesHaveTheSameProperties)
{
    const std::string more[] = {"property float nx\nproperty float ny\nproperty float nz\n",
                                "property float u\nproperty float v\n",
                                "property uchar red\nproperty uchar green\nproperty uchar blue\n"};
    const std::string values[] = {" 0 0 1", " 0.5 0.5", " 255 0 0"};
    const TempFolder folder;
    const auto error = [&](const std::string& first, const std::string& first_values, const std::string& second,
                           const std::string& second_values) {
        const std::string place = "property float x\nproperty float y\nproperty float z\n";
        return error_of(folder.write(
            "two.ply", "ply\nformat ascii 1.0\nelement vertex 1\n" + place + first + "element vertex 2\n" + place + second +
                           "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0" + first_values +
                           "\n1 0 0" + second_values + "\n0 1 0" + second_values + "\n3 0 1 2\n"));
    };
    const std::string why = "elements 'vertex' with different properties";
    EXPECT_EQ(error("", "", "", ""), "");
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(error(more[i], values[i], more[i], values[i]), "");
        EXPECT_NE(error(more[i], values[i], "", "").find(why), std::string::npos) << i;
        EXPECT_NE(error("", "", more[i], values[i]).find(why), std::string::npos) << i;
    }
}

TEST(ImportPly, RefusesWhatItDoesNotUnderstand)
{
    const TempFolder folder;
    EXPECT_NE(error_of(folder.write("a.ply", "plx\n")).find("'ply'"), std::string::npos);
    EXPECT_NE(error_of(folder.write("b.ply", "ply\nformat ascii 1.0\nelement vertex -1\n")).find("line 3"),
              std::string::npos);
    EXPECT_NE(error_of(folder.write("c.ply", "ply\nformat ascii 1.0\n")).find("header has no end"), std::string::npos);
    EXPECT_NE(error_of(folder.write("d.ply", ply_header("ascii", kSquare) + "0 0 x 1 0 0 1 1 0 0 1 0 4 0 1 2 3"))
                  .find("number is missing"),
              std::string::npos);
}

TEST(ImportOff, ReadsPlainAndPrefixedFiles)
{
    const TempFolder folder;
    const Scene plain = load(
        folder.write("a.off", "OFF # comment\n4 1 0\n0 0 0\n1 0 0\n1 1 0 # here too\n0 1 0\n4 0 1 2 3 0.5 0.5 0.5\n"),
        {.subdivide = Subdivide::On});
    EXPECT_EQ(only_cage(plain).face_vertices, (std::vector<std::uint32_t>{0, 1, 2, 3}));
    const Scene colored = load(
        folder.write("b.off", "CNOFF\n3 1 0\n0 0 0 0 0 1 1 0 0 1\n1 0 0 0 0 1 1 0 0 1\n0 1 0 0 0 1 1 0 0 1\n3 0 1 2"));
    EXPECT_EQ(only_cage(colored).normals.at(1), Vec3f(0, 0, 1));
    EXPECT_EQ(only_cage(colored).colors.at(1), Vec4f(1, 0, 0, 1));
}

TEST(ImportOff, ColoursWithoutAPointAreBytesIfOneIsAboveOne)
{
    const TempFolder folder;
    const auto read = [&](const std::string& color, const std::string& face_color = "") {
        std::string text = "COFF\n3 1 3\n";
        for (const char* place : {"0 0 0 ", "1 0 0 ", "0 1 0 "}) text += place + color + " # a comment\n";
        return load(folder.write("c.off", text + "3 0 1 2 " + face_color + "\n"));
    };
    const auto color_of = [](const Scene& scene) { return only_cage(scene).colors.at(1); };
    const Scene bytes = read("255 0 128 51");
    EXPECT_EQ(Vec2f(color_of(bytes)), Vec2f(1, 0));
    EXPECT_NEAR(color_of(bytes).z, 0.21586f, 1e-4f) << "bytes are sRGB";
    EXPECT_EQ(color_of(bytes).w, 0.2f);
    EXPECT_TRUE(bytes.warnings.empty());
    const Scene without_alpha = read("255 0 128");
    EXPECT_EQ(color_of(without_alpha), Vec4f(Vec3f(color_of(bytes)), 1));
    EXPECT_EQ(color_of(read("0.5 0.25 1")), Vec4f(0.5f, 0.25f, 1, 1));
    EXPECT_EQ(color_of(read("0 1 0 1")), Vec4f(0, 1, 0, 1));
    const Scene above = read("255.0 0 0.5 1");
    EXPECT_EQ(color_of(above), Vec4f(1, 0, 0.5f, 1));
    EXPECT_TRUE(warns(above, "colours are not between 0 and 1"));
    const Scene both = read("0.5 0.5 0.5 1", "1.0 0 0");
    EXPECT_EQ(color_of(both), Vec4f(0.5f, 0.5f, 0.5f, 1));
    EXPECT_TRUE(warns(both, "colours of faces are ignored"));
    EXPECT_NE(error_of(folder.write("d.off", "COFF\n3 1 3\n0 0 0 1 0 0 x\n1 0 0 1 0 0 x\n0 1 0 1 0 0 x\n3 0 1 2\n")), "");
}

TEST(ImportOff, FacesMayHaveColours)
{
    const TempFolder folder;
    const auto file = folder.write("f.off",
                                   "OFF\n4 5 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n2 0 1 7 7 7\n"
                                   "3 0 1 2 0.5 0.25 1 0.75\n3 1 2 3 4\n3 0 2 3 1 2\n");
    for (const Subdivide subdivide : {Subdivide::Off, Subdivide::On}) {
        const Scene scene = load(file, {.subdivide = subdivide});
        const Cage& cage = only_cage(scene);
        const std::size_t first = subdivide == Subdivide::On ? 4 : 6;
        ASSERT_EQ(cage.color_indices.size(), first + 9);
        const auto color = [&](std::size_t corner) { return cage.colors[cage.color_indices[corner]]; };
        EXPECT_EQ(color(first - 1), Vec4f(1, 0, 0, 1));
        EXPECT_EQ(color(first), Vec4f(0.5f, 0.25f, 1, 0.75f));
        EXPECT_EQ(color(first + 3), Vec4f(1));
        EXPECT_TRUE(warns(scene, "numbers in a colour map are not read"));
        EXPECT_TRUE(warns(scene, "is not a colour"));
    }
}

TEST(ImportOff, WordsAfterAFaceThatAreNoNumbersAreNoColour)
{
    const TempFolder folder;
    for (const char* words : {"red green blue", "0,5 0,5 0,5", "1 0 0 x"}) {
        const Scene scene = load(
            folder.write("f.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 " + std::string(words) + "\n2 0 1 0 0 0\n"));
        EXPECT_TRUE(warns(scene, "what follows the corners of a face is not a colour")) << words;
        EXPECT_FALSE(warns(scene, "is not a colour (2 times)")) << "lines have no faces";
        EXPECT_TRUE(only_cage(scene).colors.empty()) << words;
    }
}

TEST(ImportOff, RefusesWhatDoesNotFit)
{
    const TempFolder folder;
    EXPECT_NE(error_of(folder.write("a.off", "OFF\n999999999 1 0\n")).find("more than the file holds"), std::string::npos);
    EXPECT_NE(error_of(folder.write("b.off", "OFF\n1 1 0\n0 0 0\n")).find("number of"), std::string::npos);
    EXPECT_NE(error_of(folder.write("c.off", "OFF BINARY\n1 1 0\n0 0 0\n")).find("number of"), std::string::npos);
    const Scene scene = load(folder.write("d.off", "OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 77\n2 0 1\n"));
    EXPECT_TRUE(warns(scene, "out of range"));
    EXPECT_TRUE(warns(scene, "points and lines"));
}

std::string stl_facet(bool ascii, const float (&p)[9])
{
    if (ascii) {
        std::string text = "facet normal 0 0 1\nouter loop\n";
        for (int v = 0; v < 3; ++v)
            text += "vertex " + std::to_string(p[3 * v]) + " " + std::to_string(p[3 * v + 1]) + " " +
                    std::to_string(p[3 * v + 2]) + "\n";
        return text + "endloop\nendfacet\n";
    }
    Bytes b(false);
    b.add(0.0f).add(0.0f).add(1.0f);
    for (float x : p) b.add(x);
    return b.add(std::uint16_t(0)).text();
}

TEST(ImportStl, JoinsEqualPositionsInBothEncodings)
{
    const TempFolder folder;
    constexpr float kFirst[] = {0, 0, 0, 1, 0, 0, 1, 1, 0}, kSecond[] = {0, 0, 0, 1, 1, 0, -0.0f, 1, 0};
    const auto ascii = folder.write(
        "a.stl", "solid two triangles\n" + stl_facet(true, kFirst) + stl_facet(true, kSecond) + "endsolid\n");
    // A binary file may begin with "solid" too.
    std::string header = "solid but binary";
    header.resize(80, ' ');
    const auto binary = folder.write(
        "b.stl", header + Bytes(false).add(2u).text() + stl_facet(false, kFirst) + stl_facet(false, kSecond));
    for (const auto& file : {ascii, binary}) {
        const Scene scene = load(file);
        EXPECT_EQ(only_cage(scene).positions.size(), 4u) << file;
        EXPECT_EQ(only_cage(scene).face_count(), 2u) << file;
        EXPECT_EQ(only_cage(scene).scheme, Scheme::Triangles);
    }
}

TEST(ImportStl, ReadsSolidsThatStandOnOneLine)
{
    const TempFolder folder;
    const std::string facet = "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet ";
    const std::string other = "facet normal 0 0 1 outer loop vertex 0 0 5 vertex 1 0 5 vertex 0 1 5 endloop endfacet ";
    for (const std::string& text : {"solid " + facet + other + "endsolid", "solid a b " + facet + other + "endsolid a b",
                                    "solid a " + facet + "endsolid a solid b " + other + "endsolid b",
                                    "solid facet normal\n" + facet + "\n" + other + "\nendsolid facet normal\n"}) {
        const Scene scene = load(folder.write("a.stl", text));
        EXPECT_EQ(only_cage(scene).face_count(), 2u) << text;
        EXPECT_TRUE(scene.warnings.empty()) << text;
    }
}

TEST(ImportPolygonFiles, SayThatANumberIsTooLarge)
{
    const TempFolder folder;
    const std::string stl = "solid\nfacet\nouter loop\nvertex 1e400 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    EXPECT_NE(error_of(folder.write("a.stl", stl)).find("a number is too large (line 4)"), std::string::npos);
    const std::string ply = ply_header("ascii", kSquare) + "0 0 +1e400 1 0 0 1 1 0 0 1 0 4 0 1 2 3";
    EXPECT_NE(error_of(folder.write("a.ply", ply)).find("a number is too large"), std::string::npos);
    const std::string off = "OFF\n3 1 0\n0 0 -1e400\n1 0 0\n0 1 0\n3 0 1 2\n";
    EXPECT_NE(error_of(folder.write("a.off", off)).find("a number is too large"), std::string::npos);
}

TEST(ImportStl, RefusesWhatIsCutOff)
{
    const TempFolder folder;
    EXPECT_NE(error_of(folder.write("a.stl", "")).find("the file is empty"), std::string::npos);
    EXPECT_NE(error_of(folder.write("b.stl", std::string(80, ' ') + Bytes(false).add(1000u).text())).find("cut off"),
              std::string::npos);
    EXPECT_NE(error_of(folder.write("c.stl", "solid\nfacet\nvertex 0 0\n")).find("line"), std::string::npos);
    EXPECT_NE(error_of(folder.write("d.stl", "solid\nendsolid\n")).find("no face"), std::string::npos);

    constexpr float kFirst[] = {0, 0, 0, 1, 0, 0, 1, 1, 0};
    const std::string facet = stl_facet(true, kFirst);
    for (const char* rest : {"facet normal 0 0 1\nouter loop\n", "facet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n",
                             "facet\nouter loop\nvertex 0 0 0\nvertex 1 0"})
        EXPECT_NE(error_of(folder.write("e.stl", "solid\n" + facet + rest)).find("an ascii STL that is cut off"),
                  std::string::npos)
            << rest;
    const std::string two = "facet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\n";
    EXPECT_NE(error_of(folder.write("f.stl", "solid\n" + two + facet + "endsolid\n")).find("not a facet of three vertices"),
              std::string::npos);
    EXPECT_TRUE(warns(load(folder.write("g.stl", "solid\n" + facet)), "no endsolid"));
    EXPECT_TRUE(warns(load(folder.write("g.stl", "solid\n" + facet + "endsolid\nsolid b\n")), "no endsolid"));
    EXPECT_TRUE(warns(load(folder.write("g.stl", "solid\n" + facet + "endsolid\n" + facet)), "no endsolid"));
    for (const std::string end :
         {"endsolid\n", "endsolid\n\x1a", "endsolid a\nmade by hand\n", "end solid a b\n", "end solid"})
        EXPECT_TRUE(load(folder.write("h.stl", "solid\n" + facet + end)).warnings.empty()) << end;
    EXPECT_TRUE(load(folder.write("h.stl", "solid\n" + facet + "endsolid\n" + std::string(3, '\0'))).warnings.empty());
    const std::string apart = "facet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nend loop\nend facet\n";
    EXPECT_EQ(only_cage(load(folder.write("i.stl", "solid\n" + apart + facet + "end solid\n"))).face_count(), 2u);
}

TEST(ImportStl, BinaryFilesMayBeginAsTextAndGoOnAfterTheirFacets)
{
    const TempFolder folder;
    constexpr float kFirst[] = {0, 0, 0, 1, 0, 0, 1, 1, 0};
    std::string header = "solid but binary";
    header.resize(80, ' ');
    const std::string file = header + Bytes(false).add(1u).text() + stl_facet(false, kFirst);
    EXPECT_EQ(only_cage(load(folder.write("a.stl", file + "more"))).face_count(), 1u);
    EXPECT_NE(error_of(folder.write("b.stl", file.substr(0, file.size() - 1))).find("a binary STL that is cut off"),
              std::string::npos);
}

TEST(ImportPly, ElementsOfTextureCoordinatesAreAWarningAndEmptyOnesSayNothing)
{
    const TempFolder folder;
    const std::string vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n",
                      faces = "element face 1\nproperty list uchar int vertex_indices\n",
                      body = "0 0 0 1 0 0 0 1 0 3 0 1 2\n";
    const std::string textures = "element multi_texture_vertex 1\nproperty float u\nproperty float v\n";
    EXPECT_TRUE(warns(load(folder.write("m.ply", ply_header("ascii", vertices + faces + textures) + body + "0 1\n")),
                      "texture coordinates of faces are not read"));
    const std::string none = "element vertex 0\nproperty float u\nproperty float v\n";
    EXPECT_EQ(error_of(folder.write("z.ply", ply_header("ascii", none + vertices + faces) + body)), "");
}

}  // namespace
}  // namespace occam
