// Reads the heads of picture files: their size and note, and whether they are whole.
#include <algorithm>
#include <fstream>
#include <system_error>

#include "base/error.h"
#include "io/exr_file.h"
#include "io/hdr_note.h"
#include "io/input_file.h"
#include "io/png_file.h"
#include "io/texture/open_image.h"
#include "render/picture_formats.h"

namespace occam::render {
namespace {

namespace fs = std::filesystem;

// No more than a row of a picture is read here, so it may be as large as one that is written.
constexpr ImageLimits kHeadLimits = {std::uintmax_t(1) << 31, std::uintmax_t(1) << 31, std::uintmax_t(1) << 36,
                                     std::uintmax_t(1) << 36};

// OpenEXR decodes a block of rows for one of them. These values are enough for all layers of the widest picture.
constexpr int kMostRowsOfBlock = 256;
constexpr std::int64_t kMostValuesOfBlock = std::int64_t(1) << 30;

[[noreturn]] void refuse(const fs::path& file, const std::string& why) { throw Error(file.string(), why); }

PictureHead head_of_png(const fs::path& file, ImageBytes& bytes)
{
    if (is_cut_off_png(bytes)) refuse(file, "is cut off");
    const std::optional<PngPicture> head = read_png_head(bytes);
    if (!head) refuse(file, "cannot be read: it is no PNG");
    return {head->width, head->height, head->description};
}

PictureHead head_of_exr(const fs::path& file, ImageBytes& bytes)
{
    const std::optional<ExrHead> head = read_exr_head(bytes, kExrNote);
    if (!head) refuse(file, "cannot be read: it is no OpenEXR file, or cut off");
    const std::int64_t width = head->width, rows = std::min(head->height, kMostRowsOfBlock);
    if (head->channel_count > kMaxReadChannels || width * rows > kMostValuesOfBlock / std::max(head->channel_count, 1))
        refuse(file, "is too large a picture to read");
    if (declares_too_much(std::uintmax_t(width) * std::uintmax_t(head->height), bytes.size()))
        refuse(file, "declares far more than the file holds");
    if (!has_last_row(std::move(bytes))) refuse(file, "is cut off");
    return {head->width, head->height, head->text};
}

// Returns true if a file ends with its format's mark. Libraries read a JPEG that is cut off as if it were whole.
bool has_end_mark(const fs::path& file, std::string_view mark)
{
    std::ifstream in(file, std::ios::binary);
    std::string end(mark.size(), '\0');
    in.seekg(-static_cast<std::streamoff>(mark.size()), std::ios::end);
    return in.read(end.data(), static_cast<std::streamsize>(end.size())) && end == mark;
}

// The image is opened without its metadata first, which checks it, and then with them for the note.
std::string note_of(const fs::path& file, const std::string& format)
{
    std::string why;
    const std::unique_ptr<PictureReader> in = picture_codec().open(file, format, why);
    if (!in) refuse(file, "cannot be read: " + why);
    return in->text_attribute(kNote);
}

PictureHead head_by_codec(const fs::path& file, const std::string& file_format, ImageBytes& bytes)
{
    const OpenImage opened = open_image(file, nullptr, file.string(), kHeadLimits);
    PictureReader* const in = opened.reader.get();
    const PictureSpec& spec = in->spec();
    const std::string name = in->format();
    const std::span<const PictureFormat> formats = picture_formats();
    const auto format = std::ranges::find_if(formats, [&](const PictureFormat& f) { return f.codec_name == name; });
    bool is_whole = true;
    if (format != formats.end()) is_whole = has_end_mark(file, format->end_mark);
    else if (spec.tile_height == 0 && spec.channel_count() <= kMaxReadChannels) {
        std::vector<float> row(std::size_t(std::max(spec.width, 1)) * spec.channels.size());
        is_whole = in->read_rows(spec.height - 1, spec.height, spec.channel_count(), row.data());
    }
    if (!is_whole) refuse(file, "is cut off");
    return {spec.width, spec.height, file_format == "hdr" ? hdr_note(bytes) : note_of(file, file_format)};
}

}  // namespace

PictureHead Image::read_head(const fs::path& file)
{
    if (const std::string why = why_unreadable(file); !why.empty()) refuse(file, why);
    std::error_code error;
    if (fs::file_size(file, error) == 0) refuse(file, "is empty");
    ImageBytes bytes(file);
    const std::string format = image_format(bytes);
    if (format == "png") return head_of_png(file, bytes);
    if (format == "openexr") return head_of_exr(file, bytes);
    return head_by_codec(file, format, bytes);
}

}  // namespace occam::render
