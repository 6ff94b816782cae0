#include "io/picture_codec.h"

#include <dlfcn.h>
#include <sys/mman.h>

#include <atomic>
#include <new>

#include "base/error.h"
#include "io/texture/image_header.h"

namespace occam {
namespace {

namespace fs = std::filesystem;

// OCCAM_PICTURE_MODULE (cmake/Rooms.cmake) is the name of the module's file, "liboccam_images.so.0".
constexpr const char* kModule = OCCAM_PICTURE_MODULE;

// Returns the path of the module beside the library or program that holds this function.
fs::path beside_library()
{
    Dl_info info{};
    if (dladdr(reinterpret_cast<const void*>(&picture_codec), &info) == 0 || !info.dli_fname) return {};
    std::error_code error;
    const fs::path library = fs::weakly_canonical(info.dli_fname, error);
    return error ? fs::path() : library.parent_path() / kModule;
}

[[noreturn]] void refuse(const std::string& why)
{
    throw Error(kModule, "is needed to read and write pictures, and cannot be loaded: " + why +
                             "; it belongs beside liboccam.so, where cmake --install puts it");
}

std::atomic<bool> is_loading = false;

// Returns whether the process may have as much more address space as the module and its libraries take. Where it is limited
// (`ulimit -v`), constructors of these libraries that cannot start their threads would end the process, or wait for ever.
bool has_room() noexcept
{
    constexpr std::size_t kRoom = std::size_t(512) << 20;
    void* const room = mmap(nullptr, kRoom, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (room == MAP_FAILED) return false;
    munmap(room, kRoom);
    return true;
}

// Loads a module. Nothing but this function loads one, and one thread at a time calls it.
void* load_module(const char* file)
{
    if (!has_room()) throw std::bad_alloc();
    is_loading = true;
    void* module = dlopen(file, RTLD_LAZY | RTLD_LOCAL);
    is_loading = false;
    return module;
}

const PictureCodec& load()
{
    std::error_code error;
    const fs::path beside = beside_library();
    const bool is_beside = !beside.empty() && fs::exists(beside, error);
    void* module = load_module(is_beside ? beside.c_str() : kModule);
    if (!module) refuse(dlerror());
    using Entry = const PictureCodec* (*)();
    const auto entry = reinterpret_cast<Entry>(dlsym(module, "occam_picture_codec"));
    if (!entry) refuse("it is another file of that name");
    return *entry();
}

}  // namespace

std::unique_ptr<PictureReader> PictureCodec::open(const fs::path& file, std::string& error) const
{
    ImageBytes bytes(file);
    return open(file, image_format(bytes), error);
}

const PictureCodec& picture_codec()
{
    static const PictureCodec& codec = load();
    return codec;
}

bool is_loading_picture_codec() noexcept { return is_loading; }

void check_picture_codec()
{
    // Without a path of its own the module may still be found by the dynamic linker, which only loading it can tell.
    std::error_code error;
    if (const fs::path beside = beside_library(); beside.empty() || !fs::exists(beside, error)) picture_codec();
}

}  // namespace occam
