// The messages of refused files, what a file of one cage gives, and the vertices of a small OBJ file.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "base/error.h"
#include "io/import/import.h"

namespace occam::test {

/// The vertices of a unit square, as an OBJ file begins with them.
inline constexpr const char* kQuad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// Returns the message of the Error that load() throws; empty if it throws none.
inline std::string error_of(const std::filesystem::path& file, const LoadOptions& options = {})
{
    try {
        load(file, options);
        return {};
    } catch (const Error& error) {
        return error.what();
    }
}

/// Returns true if a warning of the scene contains `text`.
inline bool warns(const Scene& scene, const std::string& text)
{
    for (const std::string& line : scene.warnings)
        if (line.find(text) != std::string::npos) return true;
    return false;
}

/// Returns the last cage that a node of the scene shows.
inline const Cage& only_cage(const Scene& scene)
{
    const Cage* found = nullptr;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
        for (CageId id : node.cages) found = &scene.cage(id).cage;
    });
    if (!found) throw std::logic_error("no cage");
    return *found;
}

}  // namespace occam::test
