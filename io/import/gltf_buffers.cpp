#include "io/import/gltf_buffers.h"

#include <tiny_gltf.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <unordered_map>

#include "base/error.h"
#include "io/import/folder.h"
#include "io/import/gltf_door.h"
#include "io/import/gltf_json.h"
#include "io/import/gltf_uri.h"

namespace occam::import {

namespace {

using nlohmann::json;

// Returns what two buffers have in common that are read from one place; none if it is in the document or outside of the
// folder.
std::optional<std::string> place_of(const std::string& uri, Folder& folder)
{
    if (uri.starts_with("data:")) return std::nullopt;
    std::string name = decode_uri(uri);
    if (name == kBinaryChunk) return name;
    const auto& path = folder.find(name).path;
    return path ? std::optional(path->string()) : std::nullopt;
}

}  // namespace

void check_source(const json& buffer, const std::string& where, Report& report)
{
    constexpr std::size_t kMaxShown = 80;  // data URIs are long
    const std::string uri = text(buffer, "uri"), name = decode_uri(uri), shown = uri.substr(0, kMaxShown);
    if (name == kBinaryChunk) return;
    if (uri.starts_with("data:")) {
        if (!tinygltf::IsDataURI(uri))
            throw Error(report.name(), "the data URI is not in base64, or its media type is not read: " + shown, where);
        return;
    }
    const auto& [path, is_file] = report.folder().find(name);
    if (!path) throw Error(report.name(), "the file of the buffer is not in the scene's folder: " + shown, where);
    if (!is_file) throw Error(report.name(), "the file of the buffer is missing, or no regular file: " + shown, where);
    std::error_code error;
    const std::uintmax_t there = std::filesystem::file_size(*path, error);
    const std::int64_t wanted = integer(buffer, "byteLength", 0);
    if (!error && wanted > 0 && there < static_cast<std::uintmax_t>(wanted))
        throw Error(report.name(),
                    "the file of the buffer has " + std::to_string(there) + " bytes, and byteLength is " +
                        std::to_string(wanted) + ": " + shown,
                    where);
}

bool join_buffers(json& root, Folder& folder)
{
    const json& buffers = list(root, "buffers");
    json joined = json::array();
    std::vector<std::size_t> index(buffers.size());  // of each buffer, in the new list
    std::unordered_map<std::string, std::optional<std::string>> place_of_uri;
    std::unordered_map<std::string, std::size_t> index_of_place;
    for (std::size_t b = 0; b < buffers.size(); ++b) {
        index[b] = joined.size();
        const auto [place, is_new] = place_of_uri.try_emplace(text(buffers[b], "uri"));
        if (is_new) place->second = place_of(place->first, folder);
        if (place->second) index[b] = index_of_place.try_emplace(*place->second, index[b]).first->second;
        if (index[b] == joined.size()) {
            joined.push_back(buffers[b]);
            continue;
        }
        json& length = joined[index[b]]["byteLength"];
        if (buffers[b]["byteLength"] > length) length = buffers[b]["byteLength"];
    }
    if (joined.size() == buffers.size()) return false;
    root["buffers"] = std::move(joined);
    if (const auto views = root.find("bufferViews"); views != root.end())
        for (json& view : *views) view["buffer"] = index[static_cast<std::size_t>(integer(view, "buffer", 0))];
    return true;
}

}  // namespace occam::import
