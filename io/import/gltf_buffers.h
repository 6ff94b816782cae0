// Buffers of a glTF that are read from one file.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "io/import/report.h"

namespace occam::import {

/// Throws Error, naming the element, if the file of a buffer is missing, is not in the scene's folder or is too short, or if
/// its data URI cannot be decoded.
/// where   the buffer's name for messages
void check_source(const nlohmann::json& buffer, const std::string& where, Report& report);

/// Makes one buffer of all those that have one file, so that it is read, kept and counted once, however many buffers name it
/// and however they spell its name. The document has passed check_schema(), and each of its buffers has a URI; indices of
/// buffers change. Returns false if there was nothing to join.
bool join_buffers(nlohmann::json& root, Folder& folder);

}  // namespace occam::import
