// Where the files are that a scene names: only those in the scene's folder are read.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

namespace occam::import {

/// Returns the path of `relative` (with generic separators) under `folder`, or none if it is absolute or leads out of the
/// folder, be it by a symbolic link. The file need not exist. The time is in proportion to the length of the name, for a
/// name whose file is missing times its logarithm.
std::optional<std::filesystem::path> inside(const std::filesystem::path& folder, std::string_view relative);

/// The folder of a scene. It looks for each name once, since a file may name the same one a million times.
class Folder {
public:
    explicit Folder(std::filesystem::path folder) : folder_(std::move(folder)) {}

    struct Place {
        std::optional<std::filesystem::path> path;  ///< as inside() returns it
        bool is_file = false;                       ///< whether a regular file was there
    };
    /// The reference stays valid.
    const Place& find(const std::string& relative);

private:
    std::filesystem::path folder_;
    bool is_canonical_ = false;
    std::unordered_map<std::string, Place> places_;
};

}  // namespace occam::import
