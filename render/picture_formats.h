// The formats of picture files that can be written: one row each.
//
// To add a format, add its row (render/image_io.cpp) and, if the writers there do not fit, its writer. The library behind
// io/picture_codec.h has to know it, to read its pixels at least.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "io/texture/open_image.h"
#include "render/image.h"

namespace occam::render {

/// Names the attributes of OpenEXR files, and of others, that hold the note of a picture.
inline constexpr const char *kExrNote = "occam:note", *kNote = "ImageDescription";

/// The largest picture that is read. Two pictures of few bytes take less than 4 GB together.
inline constexpr std::int64_t kMaxReadValues = std::int64_t(1) << 29;  // 2 GiB of floats
inline constexpr std::int64_t kMaxReadValuesOfFewBytes = std::int64_t(1) << 28;
inline constexpr int kMaxReadChannels = 256;
inline constexpr ImageLimits kReadLimits = {std::uintmax_t(1) << 31, kMaxReadValues, kMaxReadValues,
                                            kMaxReadValuesOfFewBytes};

struct PictureFormat {
    std::string_view extensions;  ///< in lower case, with spaces between
    std::string_view name;
    std::string_view contents;      ///< what is written
    bool holds_layers = false;      ///< all layers, not the picture alone
    bool is_for_display = false;    ///< holds what a screen shows: exposure and tone curve are applied
    bool needs_codec = true;        ///< is written by picture_codec()
    std::string_view codec_name{};  ///< what PictureReader::format() calls it, if its end has a mark
    std::string_view end_mark{};    ///< the last bytes of a whole file; empty: its last row is read instead
    int largest_side = std::numeric_limits<int>::max();  ///< pixels; some libraries end the process beyond it
    std::size_t longest_note = 64'000'000;  ///< bytes of WriteOptions::note; some libraries end the process beyond it
    std::size_t note_line = 0;  ///< bytes of a line in the head; each line of a note takes whole ones. 0: there are none
    void (*write)(const Image& image, const std::filesystem::path& file, const WriteOptions& options) = nullptr;
};

/// Returns the name of a channel in a file of many layers: that of beauty has no prefix, others are layer.channel.
std::string channel_in_file(const Layer& layer, const std::string& channel);
/// Returns why a file cannot keep these layers apart: the name of one is empty or too long, or two are the same. Returns an
/// empty string if it can.
std::string why_not_written(std::span<const Layer> layers);

std::span<const PictureFormat> picture_formats() noexcept;
/// Returns the format that the extension of a file names, or null.
const PictureFormat* picture_format_of(const std::filesystem::path& file);
/// Returns the same format. Throws Error if there is none.
const PictureFormat& required_picture_format(const std::filesystem::path& file);
/// Throws Error of Kind::Output if a picture of that size is larger than the format of the file allows.
void check_sides(const std::filesystem::path& file, int width, int height);
/// Throws Error of Kind::Output if the file cannot hold the picture or its note, or an option makes no sense.
void check_contents(const std::filesystem::path& file, const Image& image, const WriteOptions& options);

}  // namespace occam::render
