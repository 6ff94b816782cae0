// Says before a picture is written what its file cannot hold. Some libraries end the process there.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <string_view>

#include "base/error.h"
#include "render/layers.h"
#include "render/picture_formats.h"

namespace occam::render {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse_output(const fs::path& file, const std::string& why)
{
    throw Error(file.string(), why, {}, Error::Kind::Output);
}

// Returns the bytes that a note takes in a file of a format.
std::size_t note_bytes(const PictureFormat& format, std::string_view note)
{
    if (format.note_line == 0 || note.empty()) return note.size();
    std::size_t lines = 0, first = 0, end = 0;
    for (; end != std::string_view::npos; first = end + 1) {
        end = note.find('\n', first);
        const std::size_t bytes = std::min(end, note.size()) - first;
        lines += std::max<std::size_t>((bytes + format.note_line - 1) / format.note_line, 1);
    }
    return lines * format.note_line;
}

void check_note(const fs::path& file, const std::string& note)
{
    const PictureFormat& format = required_picture_format(file);
    if (note.find('\0') != std::string::npos)
        refuse_output(file, "cannot be written: its note has a zero byte, and is a text");
    const std::size_t bytes = note_bytes(format, note);
    if (bytes <= format.longest_note) return;
    const std::string lines = format.note_line > 0 ? " in lines of " + std::to_string(format.note_line) : "";
    refuse_output(file, "cannot be written: its note takes " + std::to_string(bytes) + " bytes" + lines + ", and " +
                            std::string(format.name) + " allows " + std::to_string(format.longest_note));
}

void check_layers(const fs::path& file, const Image& image)
{
    if (image.layers().empty()) refuse_output(file, "there is no layer to write");
    if (!Image::has_layers(file)) {
        const Layer* const beauty = image.find("beauty");
        if (!beauty) refuse_output(file, "there is no layer beauty, and the format holds no other");
        if (const std::string why = why_without_colors(*beauty); !why.empty())
            refuse_output(file, "cannot be written: " + why);
    }
    if (const std::string why = why_incomplete(image); !why.empty()) refuse_output(file, why);
}

}  // namespace

void check_sides(const fs::path& file, int width, int height)
{
    const PictureFormat& format = required_picture_format(file);
    if (std::max(width, height) > format.largest_side)
        refuse_output(file, "cannot be written: it has " + std::to_string(width) + " x " + std::to_string(height) +
                                " pixels, and " + std::string(format.name) + " allows " +
                                std::to_string(format.largest_side) + " a side");
}

void check_contents(const fs::path& file, const Image& image, const WriteOptions& options)
{
    if (image.width < 1 || image.height < 1) refuse_output(file, "there is no picture to write");
    check_sides(file, image.width, image.height);
    check_layers(file, image);
    if (options.exposure_ev && !std::isfinite(*options.exposure_ev))
        refuse_output(file, "the exposure is not a finite number");
    if (std::none_of(std::begin(kTonemaps), std::end(kTonemaps),
                     [&](const TonemapRow& row) { return row.value == options.tonemap; }))
        refuse_output(file, "there is no such tone curve");
    check_note(file, options.note);
}

}  // namespace occam::render
