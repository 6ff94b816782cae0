// Values of options, parsed from their text. Each function throws std::invalid_argument that says what was expected.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/vec.h"

namespace occam::command {

/// Throws the exception: "expected a number, not 'x'".
[[noreturn]] void expected(const std::string& what, std::string_view text);

double real_of(std::string_view text);                 ///< "0.5", "-3", "1e-4"; any finite double
double number_of(std::string_view text);               ///< the same, within the range of floats
std::optional<float> stops_of(std::string_view text);  ///< "-1.5", from -100 to 100; nothing for "auto"
/// "16", "1e5", "2.0": a whole number from `least` to `most`, which is at most 2^64 - 1.
std::uint64_t whole_of(std::string_view text, std::uint64_t least, std::uint64_t most);
std::vector<double> numbers_of(std::string_view text, std::size_t n);  ///< n of them, with commas between
std::vector<std::string_view> words_of(std::string_view text);         ///< with commas between; none is empty
Vec3d axis_of(std::string_view text);                                  ///< "x", "y", "z" or "0,1,0.5", not all zero
std::pair<int, int> size_of(std::string_view text);                    ///< "1280x720"
int corners_of(std::string_view text);                                 ///< "6", from 3 to 64, or 0 for a round shape
std::size_t bytes_of(std::string_view text);                           ///< "512M", "2G", "1.5G", "4096"; powers of 1024
bool is_on(std::string_view text);                                     ///< "on" or "off"

}  // namespace occam::command
