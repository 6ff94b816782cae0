#include <map>
#include <set>

#include "io/import/gltf_json.h"
#include "io/import/gltf_rules.h"

namespace occam::import {

namespace {

using nlohmann::json;

int component_bytes(std::int64_t type) { return type <= 5121 ? 1 : type <= 5123 ? 2 : 4; }

// Holds the size of an element's own bytes and the stride to the next one. Columns of matrices start at multiples of four
// bytes (glTF 2.0, sec. 3.6.2.4), and the padding after the last column may be missing.
struct ElementSize {
    std::int64_t bytes, stride;
};
ElementSize element_size(const std::string& type, int component)
{
    if (type == "MAT2" && component == 1) return {6, 8};
    if (type == "MAT3" && component < 4) return component == 1 ? ElementSize{11, 12} : ElementSize{22, 24};
    const std::map<std::string, int> components = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                                                   {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
    const std::int64_t bytes = std::int64_t(components.at(type)) * component;
    return {bytes, bytes};
}

void check_view(const json& view, const json& root, const std::string& where, Report& report)
{
    const json& buffer = list(root, "buffers")[static_cast<std::size_t>(integer(view, "buffer", 0))];
    if (integer(view, "byteOffset", 0) + integer(view, "byteLength", 0) > integer(buffer, "byteLength", 0))
        throw Error(report.name(), "the buffer view does not fit its buffer", where);
    const std::int64_t stride = integer(view, "byteStride", 0);
    if (stride % 4 != 0) throw Error(report.name(), "byteStride must be a multiple of four", where);
    if (stride != 0 && integer(view, "target", 0) == 34963) report.warn("byteStride in a view of indices", where);
    if (integer(view, "byteStride", 0) > integer(view, "byteLength", 0))
        report.warn("byteStride is longer than the view", where);
}

// Checks that elements fit their view, by their offset and length.
void check_fit(const json& part, std::int64_t count, ElementSize size, const json& root, const std::string& where,
               Report& report)
{
    const json& view = list(root, "bufferViews")[static_cast<std::size_t>(integer(part, "bufferView", 0))];
    const std::int64_t offset = integer(part, "byteOffset", 0);
    const std::int64_t stride = integer(view, "byteStride", size.stride);
    if (stride < size.bytes) throw Error(report.name(), "elements overlap: the stride is too small", where);
    if (offset + (count - 1) * stride + size.bytes > integer(view, "byteLength", 0))
        throw Error(report.name(), "does not fit its buffer view", where);
}

void check_accessor(const json& accessor, const json& root, const std::string& where, Report& report)
{
    const int component = component_bytes(integer(accessor, "componentType", 5126));
    const std::string type = text(accessor, "type");
    const ElementSize size = element_size(type, component);
    const std::int64_t count = integer(accessor, "count", 0);
    const std::size_t components = type == "SCALAR" ? 1
                                                    : static_cast<std::size_t>(type[3] - '0') *
                                                          (type[0] == 'M' ? static_cast<std::size_t>(type[3] - '0') : 1);
    for (const char* bound : {"min", "max"})
        if (accessor.contains(bound) && accessor[bound].size() != components)
            report.warn(std::string(bound) + " has the wrong number of elements", where);
    if (accessor.contains("bufferView")) {
        check_fit(accessor, count, size, root, where, report);
        const json& view = list(root, "bufferViews")[static_cast<std::size_t>(integer(accessor, "bufferView", 0))];
        const std::int64_t offset = integer(accessor, "byteOffset", 0);
        if (offset % component != 0 || (offset + integer(view, "byteOffset", 0)) % component != 0 ||
            (type[0] == 'M' && offset % 4 != 0) || integer(view, "byteStride", component) % component != 0)
            report.warn("accessor is not aligned to its components", where);
    } else if (accessor.contains("byteOffset")) {
        report.warn("byteOffset without a buffer view", where);
    }
    if (accessor.value("normalized", false) && integer(accessor, "componentType", 0) >= 5125)
        report.warn("normalized is for 8 and 16 bits only", where);
    const auto sparse = accessor.find("sparse");
    if (sparse == accessor.end()) return;
    const std::int64_t sparse_count = integer(*sparse, "count", 0);
    if (sparse_count > count) throw Error(report.name(), "sparse: more elements than the accessor has", where);
    const json &indices = (*sparse)["indices"], &values = (*sparse)["values"];
    const int index_bytes = component_bytes(integer(indices, "componentType", 5125));
    check_fit(indices, sparse_count, {index_bytes, index_bytes}, root, where + ".sparse.indices", report);
    check_fit(values, sparse_count, size, root, where + ".sparse.values", report);
    for (const json* part : {&indices, &values}) {
        const json& view = list(root, "bufferViews")[static_cast<std::size_t>(integer(*part, "bufferView", 0))];
        if (view.contains("byteStride") || view.contains("target"))
            report.warn("sparse data in a view with byteStride or target", where);
        if (integer(*part, "byteOffset", 0) % (part == &indices ? index_bytes : component) != 0)
            report.warn("accessor is not aligned to its components", where);
    }
}

// Returns the images that extensions of textures name and no texture itself does: of what type they are the extension says.
std::set<std::int64_t> images_of_extensions(const json& root)
{
    std::set<std::int64_t> images, others;
    for (const json& texture : list(root, "textures")) {
        others.insert(integer(texture, "source", -1));
        if (!texture.contains("extensions")) continue;
        for (const json& extension : texture["extensions"])
            if (extension.is_object() && extension.contains("source") && extension["source"].is_number_integer())
                images.insert(extension["source"].get<std::int64_t>());
    }
    std::erase_if(images, [&](std::int64_t image) { return others.contains(image); });
    return images;
}

void check_image(const json& image, const json& root, bool may_be_of_any_type, const std::string& where, Report& report)
{
    if (image.contains("uri") == image.contains("bufferView"))
        throw Error(report.name(), "needs a uri or a buffer view, and only one", where);
    if (image.contains("bufferView")) {
        if (!image.contains("mimeType")) report.warn("image in a buffer view without mimeType", where);
        const json& view = list(root, "bufferViews")[static_cast<std::size_t>(integer(image, "bufferView", 0))];
        if (view.contains("byteStride")) report.warn("image in a view with byteStride", where);
    }
    const std::string mime = text(image, "mimeType"), uri = text(image, "uri");
    if (!mime.empty() && mime != "image/png" && mime != "image/jpeg" && !may_be_of_any_type)
        report.warn("mimeType is neither PNG nor JPEG", where);
    const std::size_t colon = uri.find(':');
    if (uri.starts_with("data:")) {
        if (!mime.empty() && !uri.starts_with("data:" + mime)) report.warn("mimeType is not that of the data URI", where);
    } else if (colon != std::string::npos && colon < uri.find('/')) {
        report.warn("the uri is not a relative reference", where);
    }
}

}  // namespace

void check_data_rules(const json& root, Report& report)
{
    const auto each = [&](const char* kind, auto&& check) {
        const json& all = list(root, kind);
        for (std::size_t i = 0; i < all.size(); ++i) check(all[i], root, element(kind, i), report);
    };
    each("bufferViews", check_view);
    each("accessors", check_accessor);
    const std::set<std::int64_t> special = images_of_extensions(root);
    const json& images = list(root, "images");
    for (std::size_t i = 0; i < images.size(); ++i)
        check_image(images[i], root, special.contains(static_cast<std::int64_t>(i)), element("images", i), report);
    each("buffers", [](const json& buffer, const json&, const std::string& where, Report& r) {
        const std::string uri = text(buffer, "uri");
        if (uri.starts_with("data:") && !uri.starts_with("data:application/octet-stream") &&
            !uri.starts_with("data:application/gltf-buffer"))
            r.warn("the data URI has another media type than a buffer's", where);
        if (uri.starts_with("data:application/octet-stream") && uri.find_first_of(";,") != 29)
            r.warn("the data URI has another media type than a buffer's", where);
    });
}

}  // namespace occam::import
