#include "scenegraph/import/gltf_file.h"

#include <limits>
#include <new>

#include "scenegraph/import/files.h"
#include "scenegraph/import/gltf_door.h"

namespace occam::import {

namespace {

// What tinygltf may open: the buffers of this file. Images stay closed until the texture store wants them.
struct Folder {
    std::filesystem::path folder;
    std::set<std::string> buffers;
};

std::string without_dot(const std::string& path) { return path.starts_with("./") ? path.substr(2) : path; }

bool file_exists(const std::string& path, void* user)
{
    return static_cast<const Folder*>(user)->buffers.count(without_dot(path)) > 0;
}

std::string expand_path(const std::string& path, void*) { return path; }

bool read_whole_file(std::vector<unsigned char>* out, std::string* error, const std::string& path, void* user)
{
    const auto file = inside(static_cast<const Folder*>(user)->folder, without_dot(path));
    if (!file) {
        *error = "not in the scene's folder";
        return false;
    }
    try {
        const std::string bytes = read_file(*file);
        out->assign(bytes.begin(), bytes.end());
        return true;
    } catch (const Error& e) {
        *error = e.what();
        return false;
    }
}

bool write_whole_file(std::string*, const std::string&, const std::vector<unsigned char>&, void*) { return false; }

// Decoding is the texture store's, which looks at the dimensions first. Bytes of a buffer view are not touched: nobody
// has checked them yet.
bool keep_image(tinygltf::Image* image, const int, std::string*, std::string*, int, int, const unsigned char* bytes,
                int size, void*)
{
    if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
    return true;
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace

tinygltf::Model open_gltf(Report& report)
{
    const std::string bytes = read_file(report.file(), std::numeric_limits<std::uint32_t>::max());
    const bool is_glb = bytes.starts_with("glTF");
    Folder folder{report.file().parent_path(), check_gltf(is_glb ? glb_json(bytes, report) : bytes, is_glb, report)};

    tinygltf::TinyGLTF reader;
    reader.SetFsCallbacks({file_exists, expand_path, read_whole_file, write_whole_file, &folder});
    reader.SetImageLoader(keep_image, nullptr);
    tinygltf::Model model;
    std::string errors, warnings;
    const unsigned size = static_cast<unsigned>(bytes.size());
    try {
        const bool ok = is_glb ? reader.LoadBinaryFromMemory(&model, &errors, &warnings,
                                                             reinterpret_cast<const unsigned char*>(bytes.data()), size)
                               : reader.LoadASCIIFromString(&model, &errors, &warnings, bytes.data(), size, "");
        // It also complains of what may be left out (a channel's node, inverse bind matrices); the door knows better.
        if (!ok) throw Error(report.name(), errors.empty() ? "not a readable glTF" : first_line(errors));
    } catch (const std::bad_alloc&) {
        throw Error(report.name(), "declares more than there is memory for");
    }
    return model;
}

}  // namespace occam::import
