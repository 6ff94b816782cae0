// Files that another process writes while they are read: they are cut off, grow, are replaced or vanish between any two
// reads. Each round ends with a picture or with an error of one line.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <thread>

#include "tests/support/file_outcome.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void write_image(const fs::path& file, int side)
{
    OIIO::ImageSpec spec(side, side, 3, file.extension() == ".exr" ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::UINT8);
    std::vector<float> texels;
    for (int i = 0; i < side * side * 3; ++i) texels.push_back(float(i * 37 % 101) / 101);
    const auto writer = OIIO::ImageOutput::create(file.string());
    ASSERT_TRUE(writer && writer->open(file.string(), spec) && writer->write_image(OIIO::TypeDesc::FLOAT, texels.data()));
}

/// Changes files until it is destroyed, and then restores them.
class Changer {
public:
    Changer(std::vector<fs::path> files, unsigned seed) : files_(std::move(files)), random_(seed)
    {
        for (const fs::path& file : files_) whole_.push_back(bytes_of(file));
        thread_ = std::jthread([this](const std::stop_token& stop) {
            while (!stop.stop_requested()) {
                const std::size_t which = random_() % files_.size();
                change(files_[which], whole_[which]);
                std::this_thread::sleep_for(std::chrono::microseconds(random_() % 400));
            }
        });
    }
    ~Changer()
    {
        thread_.request_stop();
        thread_.join();
        for (std::size_t i = 0; i < files_.size(); ++i) write(files_[i], whole_[i], std::ios::trunc);
    }
    Changer(const Changer&) = delete;
    Changer& operator=(const Changer&) = delete;

private:
    static void write(const fs::path& file, const std::string& bytes, std::ios::openmode mode)
    {
        std::ofstream(file, std::ios::binary | mode).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
    void change(const fs::path& file, const std::string& whole)
    {
        std::error_code ignored;
        const std::size_t some = random_() % (whole.size() + 1);
        switch (random_() % 6) {
            case 0:
                fs::resize_file(file, some, ignored);
                break;
            case 1:
                write(file, whole.substr(some), std::ios::app);
                break;
            case 2: {
                const fs::path other = file.string() + ".new";
                write(other, random_() % 2 ? whole : whole.substr(0, some), std::ios::trunc);
                fs::rename(other, file, ignored);
                break;
            }
            case 3:
                fs::remove(file, ignored);
                break;
            case 4: {
                std::string garbage = whole;
                for (int i = 0; i < 20; ++i) garbage[random_() % garbage.size()] = static_cast<char>(random_());
                write(file, garbage, std::ios::trunc);
                break;
            }
            default:
                write(file, whole, std::ios::trunc);
        }
    }

    std::vector<fs::path> files_;
    std::vector<std::string> whole_;
    std::mt19937 random_;
    std::jthread thread_;
};

/// Loads and renders a scene again and again while files change.
void expect_survives(const fs::path& scene, const std::vector<fs::path>& files, int rounds)
{
    ASSERT_EQ(outcome_of(scene).error, "") << scene;
    int refused = 0;
    {
        const Changer changer(files, 17);
        for (int round = 0; round < rounds; ++round) {
            const std::string error = outcome_of(scene).error;
            EXPECT_EQ(error.find('\n'), std::string::npos) << error;
            refused += !error.empty();
        }
    }
    EXPECT_GT(refused, 0) << scene << ": no file was changed in time";
    EXPECT_EQ(outcome_of(scene).error, "") << scene;
}

constexpr int kRounds = 50;

std::string grid_of_vertices(int side)
{
    std::string text;
    for (int i = 0; i <= side; ++i)
        for (int j = 0; j <= side; ++j) {
            const auto x = std::to_string(i), y = std::to_string(j);
            text += "v " + x + " " + y + " 0\nvt 0." + x + " 0." + y + "\n";
        }
    return text;
}

TEST(ChangingFiles, AnObjWithItsLibraryAndImagesEndsInAnErrorOrAPicture)
{
    constexpr int kSide = 40;
    const TempFolder folder;
    write_image(folder.path() / "a.png", 64);
    write_image(folder.path() / "b.exr", 64);
    const fs::path library = folder.write("m.mtl",
                                          "newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.exr\nKe 1 1 1\nmap_bump a.png\n");
    std::string text = "mtllib m.mtl\n" + grid_of_vertices(kSide);
    for (int i = 0; i < kSide; ++i)
        for (int j = 0; j < kSide; ++j) {
            const int v = i * (kSide + 1) + j + 1;
            text += (j % 2 ? "usemtl a\nf" : "usemtl b\nf");
            for (const int corner : {v, v + kSide + 1, v + kSide + 2, v + 1}) {
                const std::string number = std::to_string(corner);
                text += " " + number + "/" + number;
            }
            text += "\n";
        }
    const fs::path scene = folder.write("s.obj", text);
    expect_survives(scene, {scene, library, folder.path() / "a.png", folder.path() / "b.exr"}, kRounds);
    expect_survives(scene, {folder.path() / "a.png", folder.path() / "b.exr"}, kRounds);
}

TEST(ChangingFiles, AGltfWithItsBufferCageAndImageEndsInAnErrorOrAPicture)
{
    const TempFolder folder;
    write_image(folder.path() / "a.png", 64);
    std::string bin;
    const auto put = [&](auto value) { bin.append(reinterpret_cast<const char*>(&value), sizeof value); };
    constexpr int kVertices = 3000;
    for (int v = 0; v < kVertices; ++v)
        for (const int coordinate : {v % 50, v / 50, v % 3}) put(float(coordinate) / 10);
    const fs::path buffer = folder.write("a.bin", bin);
    const fs::path cage = folder.write("cage.obj", grid_of_vertices(2) + "f 1 4 5 2\nf 2 5 6 3\nf 4 7 8 5\nf 5 8 9 6\n");
    const std::string count = std::to_string(kVertices), bytes = std::to_string(bin.size());
    const fs::path scene = folder.write("s.gltf", R"({"asset": {"version": "2.0"},
        "buffers": [{"uri": "a.bin", "byteLength": )" +
                                                      bytes + R"(}],
        "bufferViews": [{"buffer": 0, "byteLength": )" +
                                                      bytes + R"(}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": )" +
                                                      count + R"(, "type": "VEC3",
            "min": [0, 0, 0], "max": [5, 6, 0.2]}],
        "images": [{"uri": "a.png"}], "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "nodes": [{"mesh": 0}, {"extras": {"occam": {"cage": "cage.obj", "material": 0}}}],
        "scenes": [{"nodes": [0, 1]}], "scene": 0})");
    expect_survives(scene, {scene, buffer, cage, folder.path() / "a.png"}, kRounds);
    expect_survives(scene, {buffer, cage}, kRounds);
}

TEST(ChangingFiles, APlyAndAnStlEndInAnErrorOrAPicture)
{
    const TempFolder folder;
    std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 900\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 841\nproperty list uchar uint vertex_indices\nend_header\n";
    for (int v = 0; v < 900; ++v) ply += std::to_string(v % 30) + " " + std::to_string(v / 30) + " 0\n";
    for (int i = 0; i < 29; ++i)
        for (int j = 0; j < 29; ++j) {
            const int v = 30 * i + j;
            ply += "4";
            for (const int corner : {v, v + 1, v + 31, v + 30}) ply += " " + std::to_string(corner);
            ply += "\n";
        }
    const fs::path polygons = folder.write("s.ply", ply);
    expect_survives(polygons, {polygons}, kRounds);

    std::string stl(84 + 50 * 400, '\0');
    stl[80] = static_cast<char>(400 & 0xff);
    stl[81] = static_cast<char>(400 >> 8);
    for (int t = 0; t < 400; ++t)
        for (int c = 0; c < 9; ++c) {
            const float value = float((t * 7 + c * 13) % 29);
            std::memcpy(&stl[84 + 50 * std::size_t(t) + 12 + 4 * std::size_t(c)], &value, sizeof value);
        }
    const fs::path triangles = folder.write("s.stl", stl);
    expect_survives(triangles, {triangles}, kRounds);
}

}  // namespace
}  // namespace occam::test
