// The one list of the glTF extensions that are read, with what is read of each.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace occam::import {

struct Extension {
    std::string_view name;
    std::string_view what;  ///< what it does here, for docs/gltf-extensions.md
};

/// Returns every extension that is understood, in alphabetical order.
std::span<const Extension> gltf_extensions();
bool is_understood(std::string_view extension);

/// Returns the extensions as the rows of a Markdown table, which docs/gltf-extensions.md holds.
std::string gltf_extension_table();

}  // namespace occam::import
