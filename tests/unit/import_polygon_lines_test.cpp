// Tests of what programs write around the polygons of PLY, OFF and STL files: ends of lines, counts and the order of parts.
#include <gtest/gtest.h>

#include <bit>

#include "tests/support/import_errors.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";
const std::string kFace = "element face 1\nproperty list uchar int vertex_indices\n";
const std::string kPlaces = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

std::string ply(const std::string& elements, const std::string& body, const std::string& format = "ascii")
{
    return "ply\nformat " + format + " 1.0\ncomment made by hand\n" + elements + "end_header\n" + body;
}
std::string square_ply(const std::string& face = "4 0 1 2 3\n")
{
    return ply("element vertex 4\n" + kXyz + kFace, kPlaces + face);
}

std::string with_line_ends(const std::string& text, const std::string& end)
{
    std::string out;
    for (const char c : text) out += c == '\n' ? end : std::string(1, c);
    return out;
}

void append_u32(std::string& to, std::uint32_t x)
{
    for (int i = 0; i < 4; ++i) to += static_cast<char>(x >> 8 * i & 0xff);
}
void append_float(std::string& to, float x) { append_u32(to, std::bit_cast<std::uint32_t>(x)); }

// Its first byte is the LF character.
std::string square_bytes()
{
    std::string body;
    append_u32(body, 0x0a);
    for (const float x : {0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}) append_float(body, static_cast<float>(x));
    body += '\x04';
    for (const std::uint32_t v : {0, 1, 2, 3}) append_u32(body, v);
    return body;
}

TEST(PolygonLines, EndWithAnyOfThreeMarks)
{
    const TempFolder folder;
    const std::string off = "OFF\n# a comment\n4 2 0\n" + kPlaces + "4 0 1 2 3 255 0 0\n3 0 1 2 0 255 0\n";
    const std::string stl =
        "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\n"
        "endfacet\nendsolid a b\n";
    for (const std::string end : {"\n", "\r\n", "\r"}) {
        const auto read = [&](const char* name, const std::string& text) {
            return load(folder.write(name, with_line_ends(text, end)));
        };
        EXPECT_EQ(only_cage(read("a.ply", square_ply())).face_count(), 2u);
        const Scene colored = read("a.off", off);
        EXPECT_EQ(only_cage(colored).face_count(), 3u);
        EXPECT_EQ(only_cage(colored).colors.at(0), Vec4f(1, 0, 0, 1));
        EXPECT_TRUE(colored.warnings.empty());
        EXPECT_EQ(only_cage(read("a.stl", stl)).face_count(), 1u);
        const std::string header = ply("element vertex 4\n" + kXyz + kFace, "", "binary_little_endian");
        const Scene binary = load(folder.write("b.ply", with_line_ends(header, end) + square_bytes()));
        EXPECT_EQ(only_cage(binary).positions.at(2), Vec3f(1, 1, 0)) << end.size();
        EXPECT_TRUE(binary.warnings.empty());
    }
    const std::string broken = "ply\rformat ascii 1.0\rcomment a\rsomething\r";
    EXPECT_NE(error_of(folder.write("c.ply", broken)).find("line 4"), std::string::npos) << "lines are counted";
}

TEST(PolygonLines, ThatTheCountsLeaveOutAreNamed)
{
    const TempFolder folder;
    constexpr const char* kGoesOn = "the file goes on after the ";
    EXPECT_TRUE(load(folder.write("a.ply", square_ply() + "\n \n")).warnings.empty());
    EXPECT_TRUE(warns(load(folder.write("a.ply", square_ply("4 0 1 2 3\n3 0 1 2\n"))), kGoesOn));
    const std::string header = ply("element vertex 4\n" + kXyz + kFace, "", "binary_little_endian");
    EXPECT_TRUE(load(folder.write("b.ply", header + square_bytes() + "\n")).warnings.empty());
    EXPECT_TRUE(warns(load(folder.write("b.ply", header + square_bytes() + square_bytes())), kGoesOn));
    const std::string off = "OFF\n4 1 0\n" + kPlaces + "4 0 1 2 3\n";
    EXPECT_TRUE(load(folder.write("c.off", off + "# the end\n")).warnings.empty());
    EXPECT_TRUE(warns(load(folder.write("c.off", off + "3 0 1 2\n")), kGoesOn));
    std::string stl(80, ' '), facet(12, '\0');
    append_u32(stl, 1);
    for (const float x : {0, 0, 0, 1, 0, 0, 1, 1, 0}) append_float(facet, static_cast<float>(x));
    facet += std::string(2, '\0');
    EXPECT_TRUE(load(folder.write("d.stl", stl + facet)).warnings.empty());
    EXPECT_TRUE(warns(load(folder.write("d.stl", stl + facet + facet)), kGoesOn));
}

TEST(PolygonLines, WithCountsAndIndicesThatAreNoWholeNumbersAreRefused)
{
    const TempFolder folder;
    const auto refuses = [&](const char* name, const std::string& text, const char* why) {
        return error_of(folder.write(name, text)).find(why) != std::string::npos;
    };
    EXPECT_TRUE(refuses("a.ply", square_ply("4.5 0 1 2 3\n"), "the length of a list is not a whole number (line 15)"));
    EXPECT_TRUE(refuses("a.ply", square_ply("4 0 1.5 2 3\n"), "an index of a face is not a whole number (line 15)"));
    EXPECT_TRUE(refuses("b.off", "OFF\n4 1 0\n" + kPlaces + "4 0 1.5 2 3\n", "an index of a face is not a whole number"));
    // Here the vertices have more than the header says, so that one of their numbers is taken for that of a face's corners.
    EXPECT_TRUE(refuses("b.off", "OFF\n2 2 0\n0 0 0 0.5 0.5 0.5\n0.5 0 0 0.5 0.5 0.5\n2 0 1\n2 0 1\n",
                        "the number of corners is not a whole number"));
}

TEST(PolygonLines, OfOffMayLackTheNumberOfEdges)
{
    const TempFolder folder;
    for (const char* counts : {"4 1 0\n", "4 1\n", "4 1 # none\n", "4\n1\n0\n", "4 1\n0\n"}) {
        const Scene scene = load(folder.write("a.off", "OFF\n" + std::string(counts) + kPlaces + "4 0 1 2 3\n"));
        EXPECT_EQ(only_cage(scene).positions.at(2), Vec3f(1, 1, 0)) << counts;
        EXPECT_EQ(only_cage(scene).face_count(), 2u) << counts;
    }
}

TEST(PolygonLines, OfPlyMayHaveFacesBeforeTheirVertices)
{
    const TempFolder folder;
    const std::string rows = "0 0 0 0 0.6 0.8\n1 0 0 0 0.6 0.8\n1 1 0 0 0.6 0.8\n0 1 0 0 0.6 0.8\n";
    const std::string vertices = "element vertex 4\n" + kXyz + "property float nx\nproperty float ny\nproperty float nz\n";
    const Scene usual = load(folder.write("a.ply", ply(vertices + kFace, rows + "4 0 1 2 3\n")));
    const Scene other = load(folder.write("b.ply", ply(kFace + vertices, "4 0 1 2 3\n" + rows)));
    ASSERT_EQ(only_cage(usual).normals.size(), 4u);
    EXPECT_EQ(only_cage(other).normals, only_cage(usual).normals);
}

TEST(PolygonLines, MayFollowAByteOrderMark)
{
    const TempFolder folder;
    const std::string mark = "\xef\xbb\xbf";
    const std::string stl =
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\nendsolid\n";
    const std::string binary = ply("element vertex 4\n" + kXyz + kFace, square_bytes(), "binary_little_endian");
    const std::pair<const char*, std::string> files[] = {
        {"a.ply", square_ply()}, {"b.ply", binary}, {"a.off", "OFF\n4 1 0\n" + kPlaces + "4 0 1 2 3\n"}, {"a.stl", stl}};
    for (const auto& [name, text] : files) {
        const Scene scene = load(folder.write(name, mark + text));
        EXPECT_GT(only_cage(scene).face_count(), 0u) << name;
        EXPECT_TRUE(scene.warnings.empty()) << name;
    }
    std::string facets = mark + "solid" + std::string(72, ' ');
    append_u32(facets, 1);
    for (const float x : {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}) append_float(facets, static_cast<float>(x));
    EXPECT_EQ(only_cage(load(folder.write("b.stl", facets + std::string(2, '\0')))).face_count(), 1u);
}

// A double holds no number between 0 and 5e-324, and none above 1.8e308.
TEST(PolygonLines, NumbersThatAreTooSmallAreZeroAndThoseThatAreTooLargeAreErrors)
{
    const TempFolder folder;
    const std::string zeros[] = {
        "1e-400", "-1e-400", "+1E-400", "0.001e-322", "1e-99999999999999999999", "0." + std::string(400, '0') + "1"};
    const std::string large[] = {"1e400", "-1e400", "0.001e313", "1e99999999999999999999", "1" + std::string(400, '0')};
    const auto files = [&](const std::string& x) {
        const std::string vertices = x + " 0 0\n1 0 0\n1 1 0\n0 1 0\n";
        return std::vector{folder.write("a.ply", ply("element vertex 4\n" + kXyz + kFace, vertices + "4 0 1 2 3\n")),
                           folder.write("a.off", "OFF\n4 1 0\n" + vertices + "4 0 1 2 3\n"),
                           folder.write("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex " + x +
                                                     " 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\nendsolid\n")};
    };
    for (const std::string& x : zeros)
        for (const std::filesystem::path& file : files(x)) {
            ASSERT_EQ(error_of(file), "") << x;
            EXPECT_EQ(only_cage(load(file)).positions.at(0), Vec3f(0)) << x << file;
        }
    for (const std::string& x : large)
        for (const std::filesystem::path& file : files(x)) EXPECT_NE(error_of(file), "") << x << file;
    const Scene colored = load(folder.write("a.obj", "v 0 0 0 1 1e-60 1\nv 1 0 0 1 0 1\nv 0 1 0 1 0 1\nf 1 2 3\n"));
    ASSERT_FALSE(only_cage(colored).colors.empty());
    EXPECT_EQ(only_cage(colored).colors.at(0), Vec4f(1, 0, 1, 1));
}

TEST(PolygonLines, OfStlMayBeInCapitals)
{
    const TempFolder folder;
    const Scene scene = load(folder.write("a.stl",
                                          "SOLID PART\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\n"
                                          "VERTEX 1 1 0\nENDLOOP\nENDFACET\nENDSOLID PART\n"));
    EXPECT_EQ(only_cage(scene).face_count(), 1u);
    EXPECT_TRUE(scene.warnings.empty());
}

}  // namespace
}  // namespace occam::test
