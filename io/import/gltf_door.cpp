#include "io/import/gltf_door.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <memory>
#include <set>
#include <string_view>

#include "base/json_document.h"
#include "io/import/gltf_buffers.h"
#include "io/import/gltf_extensions.h"
#include "io/import/gltf_json.h"
#include "io/import/gltf_rules.h"
#include "io/import/gltf_schema_check.h"
#include "io/import/gltf_size.h"

namespace occam::import {

namespace {

using nlohmann::json;

// The limit is far more than a scene needs; it exists because tinygltf reads nested values by recursion.
constexpr int kMaxNesting = 128;
constexpr std::size_t kMaxShownName = 64;

void check_nesting(std::string_view text, const Report& report)
{
    int depth = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (in_string) {
            if (c == '\\') ++i;
            else if (c == '"') in_string = false;
        } else if (c == '"') {
            in_string = true;
        } else if (c == '{' || c == '[') {
            if (++depth > kMaxNesting) throw Error(report.name(), "JSON is nested deeper than 128 levels");
        } else if (c == '}' || c == ']') {
            --depth;
        }
    }
}

struct Version {
    unsigned major = 0, minor = 0;
};
Version version(const std::string& text, const Report& report)
{
    Version v;
    const char *begin = text.data(), *end = begin + text.size();
    const auto [dot, error] = std::from_chars(begin, end, v.major);
    if (error == std::errc() && dot != end && *dot == '.') {
        const auto [last, minor_error] = std::from_chars(dot + 1, end, v.minor);
        if (minor_error == std::errc() && last == end) return v;
    }
    throw Error(report.name(), "'" + text.substr(0, 32) + "' is not a version", "asset");
}

void check_asset(const json& root, Report& report)
{
    const json& asset = root["asset"];
    const Version v = version(text(asset, "version"), report);
    if (v.major != 2) throw Error(report.name(), "only glTF 2 is read, this is version " + text(asset, "version"), "asset");
    if (v.minor > 0) report.warn("a later minor version than 2.0: what is new in it is not seen", "asset");
    if (!asset.contains("minVersion")) return;
    const Version least = version(text(asset, "minVersion"), report);
    if (least.major > 2 || (least.major == 2 && least.minor > 0))
        throw Error(report.name(), "needs a reader of glTF " + text(asset, "minVersion"), "asset");
    if (least.major > v.major || (least.major == v.major && least.minor > v.minor))
        report.warn("minVersion is above version", "asset");
}

void check_extensions(const json& root, Report& report)
{
    const auto names_in = [&](const char* key) {
        std::set<std::string> names;
        for (const json& name : list(root, key)) names.insert(name.get<std::string>());
        return names;
    };
    const std::set<std::string> used = names_in("extensionsUsed"), required = names_in("extensionsRequired");
    for (const std::string& name : required) {
        if (!is_understood(name))
            throw Error(report.name(),
                        "requires the extension " + name.substr(0, kMaxShownName) + ", which is not understood");
        if (!used.contains(name)) report.warn("required extension is not declared as used", name);
    }
    for (const std::string& name : used)
        if (!is_understood(name))
            report.warn("extension " + name.substr(0, kMaxShownName) + " is not understood: what it says is left out");
    if (used.contains("KHR_mesh_quantization") && !required.contains("KHR_mesh_quantization"))
        report.warn("KHR_mesh_quantization must be required");
}

// tinygltf leaves out null, {} and [], so such a value would be ignored in silence. Hidden from nothing is the default.
void warn_of_empty_values(const json& object, const std::string& where, Report& report)
{
    const auto is_empty = [](const json& value) {
        return value.empty() || (value.is_string() && value.get_ref<const std::string&>().empty());
    };
    for (const auto& entry : object.items()) {
        const json& value = entry.value();
        const std::string key(entry.key(), 0, kMaxShownName);
        const auto says = [&](const char* what) { return std::string("'").append(key).append(what); };
        if (is_empty(value) && entry.key() != "hidden_from") report.warn(says("' is empty, and is not read"), where);
        else if (value.is_object()) warn_of_empty_values(value, std::string(where).append(".").append(key), report);
        else if (value.is_array() && std::any_of(value.begin(), value.end(), [](const json& one) { return one.empty(); }))
            report.warn(says("' has an empty element, which is not read"), where);
    }
}

void warn_of_empty_extras(const json& root, Report& report)
{
    const auto find = [](const json& object, const char* key) -> const json* {
        const auto found = object.is_object() ? object.find(key) : object.end();
        return found == object.end() ? nullptr : &*found;
    };
    for (const char* kind : {"nodes", "meshes", "materials", "scenes"})
        for (std::size_t i = 0; i < list(root, kind).size(); ++i) {
            const json* const extras = find(list(root, kind)[i], "extras");
            const json* const occam = extras ? find(*extras, "occam") : nullptr;
            if (occam && occam->empty()) report.warn("'occam' is empty, and is not read", element(kind, i) + ".extras");
            if (occam && occam->is_object()) warn_of_empty_values(*occam, element(kind, i) + ".extras.occam", report);
        }
}

// tinygltf cuts whole numbers of extensions and extras to 32 bits. Those that have more are written with a point.
void keep_large_integers(json& value, bool is_in_extension)
{
    if (value.is_object()) {
        for (const auto& entry : value.items())
            keep_large_integers(entry.value(), is_in_extension || entry.key() == "extensions" || entry.key() == "extras");
    } else if (value.is_array()) {
        for (json& element : value) keep_large_integers(element, is_in_extension);
    } else if (is_in_extension && value.is_number_integer()) {
        using Int = std::numeric_limits<int>;
        const auto number = value.get<double>();
        if (number < Int::min() || number > Int::max()) value = number;
    }
}

// tinygltf refuses indices without a buffer view, though those of a sparse accessor need none (glTF 2.0, sec. 3.6.2.3). It
// reads such attributes.
void rename_indices_without_view(json& root)
{
    const auto meshes = root.find("meshes");
    if (meshes == root.end()) return;
    for (json& mesh : *meshes)
        for (json& primitive : mesh["primitives"]) {
            json& attributes = primitive["attributes"];
            attributes.erase(kIndicesAttribute);
            const auto indices = primitive.find("indices");
            if (indices == primitive.end()) continue;
            if (list(root, "accessors")[indices->get<std::size_t>()].contains("bufferView")) continue;
            attributes[kIndicesAttribute] = *indices;
            primitive.erase(indices);
        }
}

std::unique_ptr<JsonDocument> parse(std::string_view text, const Report& report)
{
    try {
        return std::make_unique<JsonDocument>(text);
    } catch (const json::exception& error) {
        std::string_view reason = error.what();
        // It begins with the name of the exception in brackets.
        if (const std::size_t end = reason.find("] "); end != std::string_view::npos) reason.remove_prefix(end + 2);
        throw Error(report.name(), std::string("not valid JSON: ").append(reason));
    }
}

}  // namespace

CheckedGltf check_gltf(std::string_view json_text, bool is_glb, Report& report)
{
    check_nesting(json_text, report);
    if (json_text.starts_with("\xef\xbb\xbf")) report.warn("starts with a byte order mark");
    const auto document = parse(json_text, report);
    json& root = document->root;
    check_schema(root, report);
    check_asset(root, report);
    check_extensions(root, report);
    check_size(root, json_text.size(), report);
    check_data_rules(root, report);
    check_scene_rules(root, report);
    warn_of_empty_extras(root, report);

    for (std::size_t b = 0; b < list(root, "buffers").size(); ++b) {
        const json& buffer = root["buffers"][b];
        if (!text(buffer, "uri").empty()) {
            check_source(buffer, element("buffers", b), report);
            continue;
        }
        if (!is_glb || b > 0) {
            const bool is_compressed = buffer.contains("extensions") &&
                                       buffer["extensions"].contains("EXT_meshopt_compression");
            throw Error(report.name(),
                        is_compressed ? "has no data but for EXT_meshopt_compression, which is not read" : "has no data",
                        element("buffers", b));
        }
    }
    keep_large_integers(root, false);
    rename_indices_without_view(root);
    join_buffers(root, report.folder());
    CheckedGltf checked;
    checked.buffers = take_sources(root);
    checked.json = root.dump();
    return checked;
}

}  // namespace occam::import
