#include "io/import/gltf_file.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <map>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "io/import/files.h"
#include "io/import/gltf_container.h"
#include "io/import/gltf_door.h"
#include "io/import/gltf_uri.h"

namespace occam::import {

namespace {

// Holds what tinygltf may open: the buffers of this file, each once. Images stay closed until the texture store needs them.
struct Opened {
    const GltfContainer& container;
    Report& report;
    std::map<std::string, BufferSource> buffers;  // by name; those that were read are gone
    std::exception_ptr error{};                   // what has ended a read
};

bool file_exists(const std::string& name, void* user) { return static_cast<const Opened*>(user)->buffers.contains(name); }

std::string expand_path(const std::string& path, void*) { return path; }

// Returns as many of the first bytes as the buffer has: files and data URIs may be longer.
std::vector<unsigned char> read_buffer(const BufferSource& source, const GltfContainer& container, Report& report)
{
    if (source.is_chunk()) return container.binary(source.bytes);
    std::vector<unsigned char> bytes;
    if (source.is_data_uri()) {
        std::string media_type;
        tinygltf::DecodeDataURI(&bytes, media_type, source.uri, 0, false);
        bytes.resize(std::min(bytes.size(), source.bytes));
        return bytes;
    }
    const auto& path = report.folder().find(decode_uri(source.uri)).path;
    if (!path) throw Error(report.name(), "the file of the buffer is not in the scene's folder", "buffers");
    report.add_file(*path);
    const FileReader file(*path);
    bytes.resize(std::min(source.bytes, file.size()));
    file.read(0, {reinterpret_cast<char*>(bytes.data()), bytes.size()});
    return bytes;
}

bool read_whole_file(std::vector<unsigned char>* out, std::string*, const std::string& name, void* user)
{
    Opened& opened = *static_cast<Opened*>(user);
    try {
        const auto source = opened.buffers.find(name);
        *out = read_buffer(source->second, opened.container, opened.report);
        opened.buffers.erase(source);
        return true;
    } catch (const std::exception&) {
        opened.error = std::current_exception();
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
    for (const auto& [name, source] : checked.buffers)
        if (source.is_chunk()) container.require_binary(source.bytes);
    Opened opened{container, report, std::move(checked.buffers)};

    // Numbers may be longer than they were in the file.
    if (checked.json.size() > std::numeric_limits<unsigned>::max())
        throw Error(report.name(), "the JSON is longer than 4 GiB");
    tinygltf::TinyGLTF reader;
    reader.SetFsCallbacks({file_exists, expand_path, read_whole_file, write_whole_file, &opened});
    reader.SetImageLoader(keep_image, nullptr);
    tinygltf::Model model;
    std::string errors, warnings;
    const bool ok = reader.LoadASCIIFromString(&model, &errors, &warnings, checked.json.data(),
                                               static_cast<unsigned>(checked.json.size()), "");
    if (opened.error) std::rethrow_exception(opened.error);
    // tinygltf itself catches what its parser throws, and keeps the text of it.
    if (errors.find(std::bad_alloc().what()) != std::string::npos) throw std::bad_alloc();
    // tinygltf also reports what may be left out (a channel's node, inverse bind matrices); our validation is more exact.
    if (!ok) throw Error(report.name(), errors.empty() ? "not a readable glTF" : first_line(errors));
    return model;
}

}  // namespace occam::import
