// Computes a number from everything that a picture was made with, so that a picture that exists already can be told from one
// that would be made now.
//
// The number depends on the version, the settings, the camera, the moment, and the bytes of the scene's file, of the files
// that it names and of the environment. Of an image of more than 128 KiB that the scene names it sees the size and both
// ends; the environment's is seen whole. It does not depend on threads, budgets (but for images that are halved to fit one)
// or folders. Pictures have it in their heads (WriteOptions::note).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "arguments.h"

namespace occam::command {

/// Returns the part of the number that all pictures of one scene share. Reads the files once more. Where images are
/// halved to fit the memory for textures, that belongs to it.
/// scene   the scene that is rendered, not yet posed: with the environment that Framing gives it, whose image takes its part
///         of that memory
std::uint64_t scene_stamp(Scene& scene, const RenderArguments& arguments, Renderer& renderer);

/// Holds what a picture is made with, besides the scene.
struct Recipe {
    const RenderArguments& arguments;
    const WriteOptions& write;
    const Settings& settings;
    const Camera& camera;
    std::optional<double> moment;  ///< seconds on the clip's axis; none for the file's own pose
};
/// Returns the note of a picture: "Occam 0.1.0, recipe 0123456789abcdef".
std::string recipe_note(std::uint64_t scene_stamp, const Recipe& recipe);
/// Returns whether a text is such a note, of any picture and version.
bool is_recipe_note(std::string_view text);
/// Returns what the file of the picture holds: its note, and whether it was stopped before it was finished.
std::string note_in_file(const std::string& note, bool is_complete);

/// Describes the file that exists where a picture is to be made.
struct FoundPicture {
    enum class State : unsigned char {
        Missing,
        Same,         ///< whole, of the right size, and with this note
        Unreadable,   ///< the system does not let it be opened, so that nothing is known of it
        Broken,       ///< not a whole picture, or one that was stopped while these settings have no deadline
        OtherSize,    ///< a whole picture of another size
        OtherRecipe,  ///< a whole picture of this size that was made with other settings or from another scene
        NoRecipe      ///< a whole picture of this size that has no note
    } state = State::Missing;
    std::string why;  ///< says what is broken, other or in the way
};
FoundPicture look_for(const std::filesystem::path& file, const Settings& settings, const std::string& note);

}  // namespace occam::command
