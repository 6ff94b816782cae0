// The outcome of a file that may break any rule: an error, or warnings and a small picture.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/texture/texture_store.h"
#include "occam/occam.h"

namespace occam::test {

struct FileOutcome {
    std::string error;                  ///< empty: it was loaded and rendered
    std::vector<std::string> warnings;  ///< of the scene and of its textures
};

/// Loads a file and renders it, since the code after loading relies on what was checked there.
inline FileOutcome outcome_of(const std::filesystem::path& file)
{
    FileOutcome outcome;
    try {
        Scene scene = load(file);
        scene.refit();
        TextureStore store(std::size_t(64) << 20);
        store.prepare(scene);
        outcome.warnings = scene.warnings;
        for (std::string& line : store.errors()) outcome.warnings.push_back(std::move(line));
        const std::vector<std::string> more = store.warnings();
        outcome.warnings.insert(outcome.warnings.end(), more.begin(), more.end());
        Renderer renderer({.threads = 1, .memory_bytes = std::size_t(256) << 20});
        renderer.render(scene, Camera::framing(scene.bounds()), {.width = 8, .height = 6, .spp = 1});
    } catch (const Error& error) {
        outcome.error = error.what();
    }
    return outcome;
}

}  // namespace occam::test
