// The entry point of every fuzz target: it writes the bytes to a file in a folder of the process, and loads the file as an
// application would.
//
// Finding  a crash, a sanitizer's report, an exception other than occam::Error, a hang, or more memory than the run allows.
// Threads  one input at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace occam::fuzz {

inline std::string_view text_of(const std::uint8_t* data, std::size_t size)
{
    return {reinterpret_cast<const char*>(data), size};
}

/// Writes a file into the folder of this process, in place of the last one of that name. Returns its path.
std::filesystem::path write_file(const std::string& name, std::string_view bytes);

/// Loads a file of the folder and decodes its textures; every few scenes (told by a sum over `bytes`, so that a finding
/// can be replayed) also become a small picture. occam::Error is the right answer to a bad file.
void pass_door(const std::string& name, std::string_view bytes);

}  // namespace occam::fuzz
