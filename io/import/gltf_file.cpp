#include "io/import/gltf_file.h"

#include <algorithm>
#include <limits>
#include <new>

#include "io/import/files.h"
#include "io/import/gltf_container.h"
#include "io/import/gltf_door.h"

namespace occam::import {

namespace {

// Holds what tinygltf may open: the buffers of this file. Images stay closed until the texture store needs them.
struct Opened {
    const GltfContainer& container;
    Report& report;
    std::map<std::string, std::size_t> files;  // the bytes to read of each
    bool lacks_memory = false;                 // a read has failed for lack of memory
};

std::string without_dot(const std::string& path) { return path.starts_with("./") ? path.substr(2) : path; }

bool file_exists(const std::string& path, void* user)
{
    return static_cast<const Opened*>(user)->files.count(without_dot(path)) > 0;
}

std::string expand_path(const std::string& path, void*) { return path; }

// Returns the first bytes of a file, as many as the buffer has: tinygltf would refuse a longer file, which the format
// allows.
std::vector<unsigned char> read_buffer(const std::filesystem::path& path, std::size_t wanted)
{
    const FileReader file(path);
    std::vector<unsigned char> bytes(std::min(wanted, file.size()));
    file.read(0, {reinterpret_cast<char*>(bytes.data()), bytes.size()});
    return bytes;
}

bool read_whole_file(std::vector<unsigned char>* out, std::string* error, const std::string& path, void* user)
{
    Opened& opened = *static_cast<Opened*>(user);
    const std::string name = without_dot(path);
    try {
        const std::size_t wanted = opened.files.at(name);
        if (name == kBinaryChunk) {
            *out = opened.container.binary(wanted);
            return true;
        }
        const auto& file = opened.report.folder().find(name).path;
        if (!file) {
            *error = "not in the scene's folder";
            return false;
        }
        opened.report.add_file(*file);
        *out = read_buffer(*file, wanted);
        return true;
    } catch (const std::bad_alloc&) {
        opened.lacks_memory = true;
        return false;
    } catch (const std::exception& e) {
        *error = e.what();
        return false;
    }
}

bool write_whole_file(std::string*, const std::string&, const std::vector<unsigned char>&, void*) { return false; }

// Images are decoded by the texture store, which checks the dimensions first. The bytes of a buffer view are not touched
// here, since nothing has checked them yet.
bool keep_image(tinygltf::Image* image, const int, std::string*, std::string*, int, int, const unsigned char* bytes,
                int size, void*)
{
    // It has so many parameters because tinygltf calls it.
    if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
    return true;
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace

tinygltf::Model open_gltf(Report& report)
{
    const GltfContainer container(report);
    CheckedGltf checked = check_gltf(container.json(), container.is_glb(), report);
    if (const auto chunk = checked.files.find(kBinaryChunk); chunk != checked.files.end())
        container.require_binary(chunk->second);
    const std::string& json = checked.json.empty() ? container.json() : checked.json;
    Opened opened{container, report, std::move(checked.files), false};

    tinygltf::TinyGLTF reader;
    reader.SetFsCallbacks({file_exists, expand_path, read_whole_file, write_whole_file, &opened});
    reader.SetImageLoader(keep_image, nullptr);
    tinygltf::Model model;
    std::string errors, warnings;
    const bool ok = reader.LoadASCIIFromString(&model, &errors, &warnings, json.data(), static_cast<unsigned>(json.size()),
                                               "");
    // tinygltf itself catches what its parser throws, and keeps the text of it.
    if (opened.lacks_memory || errors.find(std::bad_alloc().what()) != std::string::npos) throw std::bad_alloc();
    // tinygltf also reports what may be left out (a channel's node, inverse bind matrices); our validation is more exact.
    if (!ok) throw Error(report.name(), errors.empty() ? "not a readable glTF" : first_line(errors));
    return model;
}

}  // namespace occam::import
