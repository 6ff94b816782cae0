// Buffers of a glTF: what they are read from, and how those of one file become one.
#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "io/import/report.h"

namespace occam::import {

/// What a buffer is read from.
struct BufferSource {
    std::string uri;        ///< a relative reference or a data URI; empty: the binary chunk of a GLB
    std::size_t bytes = 0;  ///< so many of its first bytes are the buffer's

    bool is_chunk() const noexcept { return uri.empty(); }
    bool is_data_uri() const noexcept { return uri.starts_with("data:"); }
};

/// Throws Error, naming the element, if the file of a buffer is missing, is not in the scene's folder or is too short, or if
/// its data URI is too short or cannot be decoded.
/// where   the buffer's name for messages
void check_source(const nlohmann::json& buffer, const std::string& where, Report& report);

/// Makes one buffer of all those that have one file, so that it is read, kept and counted once, however many buffers name it
/// and however they spell its name. The document has passed check_schema(); indices of buffers change.
void join_buffers(nlohmann::json& root, Folder& folder);

/// Gives each buffer a name of ours as its URI, and returns what the buffers of these names are read from. So nothing but
/// our own code decodes URIs: tinygltf would take a plus sign for a blank, and refuse a data URI that is longer than its
/// buffer.
std::map<std::string, BufferSource> take_sources(nlohmann::json& root);

}  // namespace occam::import
