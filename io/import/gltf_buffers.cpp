#include "io/import/gltf_buffers.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "base/error.h"
#include "io/import/folder.h"
#include "io/import/gltf_json.h"
#include "io/import/gltf_uri.h"

namespace occam::import {

namespace {

using nlohmann::json;

// Returns what two buffers have in common that are read from one file; none if they are read from something else.
std::optional<std::string> place_of(const std::string& uri, Folder& folder)
{
    if (uri.empty() || uri.starts_with("data:")) return std::nullopt;
    const auto& path = folder.find(decode_uri(uri)).path;
    return path ? std::optional(path->string()) : std::nullopt;
}

// Returns how many bytes a data URI in base64 holds. What follows the first other character is not read.
std::size_t bytes_in(std::string_view uri)
{
    constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const std::string_view text = uri.substr(std::min(uri.find(','), uri.size() - 1) + 1);
    return std::min(text.find_first_not_of(kDigits), text.size()) * 3 / 4;
}

}  // namespace

void check_source(const json& buffer, const std::string& where, Report& report)
{
    constexpr std::size_t kMaxShown = 80;  // data URIs are long
    const std::string uri = text(buffer, "uri"), shown = uri.substr(0, kMaxShown);
    const std::int64_t wanted = integer(buffer, "byteLength", 0);
    if (uri.starts_with("data:")) {
        if (!tinygltf::IsDataURI(uri))
            throw Error(report.name(), "the data URI is not in base64, or its media type is not read: " + shown, where);
        if (const std::size_t there = bytes_in(uri); there < static_cast<std::uint64_t>(wanted))
            throw Error(report.name(),
                        "the data URI of the buffer has " + std::to_string(there) + " bytes, and byteLength is " +
                            std::to_string(wanted) + ": " + shown,
                        where);
        return;
    }
    const auto& [path, is_file] = report.folder().find(decode_uri(uri));
    if (!path) throw Error(report.name(), "the file of the buffer is not in the scene's folder: " + shown, where);
    if (!is_file) throw Error(report.name(), "the file of the buffer is missing, or no regular file: " + shown, where);
    std::error_code error;
    const std::uintmax_t there = std::filesystem::file_size(*path, error);
    if (!error && wanted > 0 && there < static_cast<std::uintmax_t>(wanted))
        throw Error(report.name(),
                    "the file of the buffer has " + std::to_string(there) + " bytes, and byteLength is " +
                        std::to_string(wanted) + ": " + shown,
                    where);
}

void join_buffers(json& root, Folder& folder)
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
    if (joined.size() == buffers.size()) return;
    root["buffers"] = std::move(joined);
    if (const auto views = root.find("bufferViews"); views != root.end())
        for (json& view : *views) view["buffer"] = index[static_cast<std::size_t>(integer(view, "buffer", 0))];
}

std::map<std::string, BufferSource> take_sources(json& root)
{
    std::map<std::string, BufferSource> sources;
    for (std::size_t b = 0; b < list(root, "buffers").size(); ++b) {
        json& buffer = root["buffers"][b];
        const std::string name = "<buffer " + std::to_string(b) + ">";
        BufferSource& source = sources[name];
        source.bytes = static_cast<std::size_t>(integer(buffer, "byteLength", 0));
        if (const auto uri = buffer.find("uri"); uri != buffer.end()) source.uri = std::move(uri->get_ref<std::string&>());
        buffer["uri"] = name;
    }
    return sources;
}

}  // namespace occam::import
