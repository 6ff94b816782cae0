#include "tests/fuzz/door.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "io/texture/texture_store.h"
#include "occam/occam.h"

namespace occam::fuzz {

namespace {

constexpr std::size_t kTextureBytes = std::size_t(64) << 20;
constexpr std::uint64_t kScenesAPicture = 16;
constexpr std::size_t kMostFaces = 32;  // a scene with more faces does not become a picture

// The folder is removed when the process ends normally; a finding leaves it behind.
class Folder {
public:
    Folder()
    {
        std::string name = (std::filesystem::temp_directory_path() / "occam-fuzz-XXXXXX").string();
        if (!::mkdtemp(name.data())) std::abort();
        path_ = name;
    }
    ~Folder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

private:
    std::filesystem::path path_;
};

const Folder& folder()
{
    static const Folder only;
    return only;
}

// This is the FNV-1a hash.
std::uint64_t sum_of(std::string_view bytes)
{
    std::uint64_t sum = 0xcbf29ce484222325;
    for (const char c : bytes) sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001b3;
    return sum;
}

}  // namespace

std::filesystem::path write_file(const std::string& name, std::string_view bytes)
{
    std::filesystem::path file = folder() / name;
    std::ofstream stream(file, std::ios::binary | std::ios::trunc);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return file;
}

void pass_door(const std::string& name, std::string_view bytes)
{
    try {
        Scene scene = load(folder() / name);
        scene.refit();
        TextureStore(kTextureBytes).prepare(scene);
        if (sum_of(bytes) % kScenesAPicture != 0 || scene.placed_faces() > kMostFaces) return;
        Renderer renderer({.threads = 1, .memory_bytes = std::size_t(256) << 20});
        renderer.render(scene, Camera::framing(scene.bounds()), {.width = 4, .height = 3, .spp = 1, .shading_rate = 8});
    } catch (const Error&) {
        return;
    }
}

}  // namespace occam::fuzz
