// The extensions of glTF that are read, with what is read of each: the one list of them.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace occam::import {

struct Extension {
    std::string_view name;
    std::string_view what;  ///< what it does here, for docs/gltf-extensions.md
};

/// Every extension that is understood, in alphabetical order.
std::span<const Extension> gltf_extensions();
bool is_understood(std::string_view extension);

/// The extensions as the rows of a Markdown table; docs/gltf-extensions.md holds it.
std::string gltf_extension_table();

}  // namespace occam::import
