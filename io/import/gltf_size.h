// A limit to the memory that the lists of a glTF take: an element of three bytes of text becomes kilobytes.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>

#include "io/import/report.h"

namespace occam::import {

/// Throws Error, naming the longest list, if the elements of the document would take far more memory than its text explains.
/// text_bytes   the length of the text
void check_size(const nlohmann::json& root, std::size_t text_bytes, const Report& report);

}  // namespace occam::import
