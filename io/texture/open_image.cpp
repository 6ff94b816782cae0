#include "io/texture/open_image.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/number_in.h"
#include "io/exr_file.h"
#include "io/input_file.h"
#include "io/png_file.h"
#include "io/texture/bmp_masks.h"
#include "io/texture/chosen_channels.h"
#include "io/texture/color_maps.h"
#include "io/texture/image_header.h"
#include "io/texture/image_length.h"
#include "io/texture/image_metadata.h"
#include "io/texture/jpeg_head.h"
#include "io/texture/pnm_samples.h"
#include "io/texture/tiled_file.h"

namespace occam {

namespace {

// The ratio is more texels for each byte of a file than any compression gives: deflate writes 1032 bytes for one, of up to
// eight texels each.
constexpr std::uintmax_t kMaxTexelsPerByte = 16384;
constexpr std::uintmax_t kAlwaysAllowedTexels = std::uintmax_t(1) << 24;

// Each scan of a JPEG visits all texels, at half a billion a second or more, and some work remains for the smallest picture.
constexpr std::uintmax_t kMostScannedTexels = std::uintmax_t(1) << 32, kLeastScannedTexels = std::uintmax_t(1) << 16;
constexpr std::uintmax_t kLeastChargedTexels = std::uintmax_t(1) << 12;

// Few bytes may be pictures that take gigabytes, of which ordinary ones have far more bytes than this.
constexpr std::uintmax_t kValuesPerByte = 16, kLeastValuesOfTexel = 4;

constexpr std::uintmax_t kMostTileValues = std::uintmax_t(1) << 26;

class Opener {
public:
    Opener(const std::filesystem::path& file, const std::vector<std::byte>* encoded, const std::string& name,
           const ImageLimits& limits, DecodeBudget* budget)
        : path_(file),
          encoded_(encoded),
          name_(name),
          limits_(limits),
          budget_(budget),
          bytes_(encoded ? ImageBytes(std::span(*encoded)) : ImageBytes(file)),
          format_(image_format(bytes_))
    {
    }

    OpenImage open()
    {
        if (format_.empty() && !encoded_)
            if (const std::string why = why_unreadable(path_); !why.empty()) refuse(why);
        if (format_.empty()) refuse(std::string("not an image of a format that is read: ") + kImageFormats);
        check_header();
        OpenImage image;
        std::string why;
        if (format_ == "png" || format_ == "jpeg" || format_ == "tiff") {
            image.bytes = whole();
            remove_metadata(image.bytes, format_);
            if (format_ == "jpeg") check_scans(image.bytes);
            if (format_ == "tiff") {
                image.orientation = take_tiff_orientation(image.bytes);
                check_tiff(pixels_of_tiff(image.bytes));
            }
            image.reader = format_ == "png" ? open_png(ImageBytes(std::span(std::as_const(image.bytes))), why)
                                            : picture_codec().open(image.bytes, format_, why);
        } else if (has_color_numbers(bytes_, format_)) {
            image.bytes = with_whole_color_map(whole(), format_);
            image.reader = picture_codec().open(image.bytes, format_, why);
        } else if (const auto kind = place_of_multiplied_dds(bytes_)) {
            // The library would divide bytes by bytes of alpha, also by those that are 0, at which the process ends.
            image.bytes = whole();
            image.bytes[*kind] = static_cast<std::byte>(std::to_integer<int>(image.bytes[*kind]) + 1);
            image.reader = picture_codec().open(image.bytes, format_, why);
        } else if (const auto head = format_ == "pnm" ? read_head_of_few_values(bytes_) : std::nullopt) {
            check_size(head->width, head->height);
            image.bytes = with_many_values(whole(), *head);
            image.reader = picture_codec().open(image.bytes, format_, why);
        } else if (has_bmp_order()) {
            image.bytes = whole();
            put_in_usual_order(image.bytes, *masks_of_bmp(bytes_));
            image.reader = picture_codec().open(image.bytes, format_, why);
        } else {
            if (encoded_) image.bytes = *encoded_;
            if (format_ == "openexr")
                image.reader = open_exr(encoded_ ? ImageBytes(std::span(std::as_const(image.bytes))) : ImageBytes(path_));
            if (!image.reader)
                image.reader = encoded_ ? picture_codec().open(image.bytes, format_, why)
                                        : picture_codec().open(path_, format_, why);
        }
        if (!image.reader) refuse("image cannot be read: " + why);
        check_spec(image.reader->spec());
        if (format_ == "hdr") image.orientation = radiance_orientation(*image.reader);
        image.has_multiplied_colors = has_multiplied_colors(image);
        image.has_two_colors = has_two_colors_dds(bytes_);
        const ChannelChoice choice = channels_of(image);  // before the reader is moved
        image.reader = with_chosen_channels(std::move(image.reader), choice);
        return image;
    }

private:
    [[noreturn]] void refuse(const std::string& what) const { throw Error(name_, what); }

    void check_size(std::uintmax_t wide, std::uintmax_t high) const
    {
        const std::string size = std::to_string(wide) + " x " + std::to_string(high);
        if (wide > limits_.side || high > limits_.side || wide * high > limits_.texels)
            refuse("image is larger than is read: " + size);
        if (declares_too_much(wide * high, bytes_.size())) refuse("image declares far more than the file holds: " + size);
        check_few_bytes(wide * high, kLeastValuesOfTexel);
    }

    // All values of a picture that is compared are in memory, beside those of another one.
    void check_few_bytes(std::uintmax_t texels, std::uintmax_t channels) const
    {
        const std::uintmax_t values = texels * std::max(channels, kLeastValuesOfTexel);
        if (values > limits_.values_of_few_bytes && bytes_.size() < values / kValuesPerByte)
            refuse("image has more values than are read from a file of " + std::to_string(bytes_.size()) +
                   " bytes: " + std::to_string(texels) + " pixels");
    }

    bool is_read_as_a_whole()
    {
        return format_ == "png" || format_ == "jpeg" || format_ == "tiff" || has_color_numbers(bytes_, format_) ||
               place_of_multiplied_dds(bytes_) || has_bmp_order() || (format_ == "pnm" && read_head_of_few_values(bytes_));
    }

    // Few bytes on a disk may be a long file, and what is read takes memory for all of it.
    void check_length()
    {
        if (!is_read_as_a_whole()) return;
        if (const std::uintmax_t most = most_bytes_of_file(bytes_, format_, limits_); bytes_.size() > most)
            refuse("the file is longer than is read for the image that it declares: " + std::to_string(bytes_.size() >> 20) +
                   " MB, and at most " + std::to_string(most >> 20) + " MB");
    }

    void check_header()
    {
        check_length();
        if (is_cut_off_png(bytes_) || is_cut_off_exr(bytes_)) refuse("the image is cut off");
        if (has_foreign_pixels_dds(bytes_))
            refuse("the DDS file is a cube map or a volume, or its pixels are of a kind that is not read");
        if (has_foreign_compression_bmp(bytes_)) refuse("the image is compressed in a way that is not read");
        if (const auto masks = masks_of_bmp(bytes_); masks && !are_usual(*masks) && !are_bytes(*masks))
            refuse("the masks of its colours are not of eight bits each");
        if (format_ == "targa" && has_foreign_color_map_tga(bytes_))
            refuse("the pixels are numbers of colours, of a kind that is not read");
        if (const auto canvas = declared_canvas(bytes_)) check_size(canvas->width, canvas->height);
        if (format_ != "openexr") return;
        if (const auto head = read_exr_head(bytes_)) {
            check_size(static_cast<std::uintmax_t>(head->width), static_cast<std::uintmax_t>(head->height));
            check_values(head->width, head->height, head->channel_count);
            check_tiles(static_cast<std::uintmax_t>(head->tile_width), static_cast<std::uintmax_t>(head->tile_height),
                        head->channel_count);
        }
    }

    void check_scans(std::span<const std::byte> file) const
    {
        const auto head = jpeg_head(file);
        if (!head) return;  // the library will say what is wrong
        check_size(head->width, head->height);
        const std::uintmax_t texels = std::uintmax_t(head->width) * head->height;
        if (head->scans > kMostScannedTexels / std::max(texels, kLeastScannedTexels))
            refuse("image has more scans than are read at its size: " + std::to_string(head->scans));
        if (budget_ && !budget_->takes_scans(head->scans * std::max(texels, kLeastChargedTexels), file.size()))
            refuse("image has more scans than are read for all images of a scene together: " + std::to_string(head->scans));
    }

    void check_values(int width, int height, int channels) const
    {
        if (static_cast<std::uintmax_t>(width) * static_cast<std::uintmax_t>(height) >
            limits_.values / static_cast<std::uintmax_t>(std::max(channels, 1)))
            refuse("image has more channels than are read at its size: " + std::to_string(channels));
        check_few_bytes(static_cast<std::uintmax_t>(width) * static_cast<std::uintmax_t>(height),
                        static_cast<std::uintmax_t>(std::max(channels, 1)));
    }

    void check_spec(const PictureSpec& spec) const
    {
        if (spec.width <= 0 || spec.height <= 0 || spec.depth > 1 || spec.channel_count() < 1) refuse("not a flat image");
        if (spec.is_deep) refuse("deep images are not read");
        check_size(static_cast<std::uintmax_t>(spec.width), static_cast<std::uintmax_t>(spec.height));
        check_values(spec.width, spec.height, spec.channel_count());
        check_tiles(static_cast<std::uintmax_t>(spec.tile_width), static_cast<std::uintmax_t>(spec.tile_height),
                    spec.channel_count());
    }

    void check_tiles(std::uintmax_t wide, std::uintmax_t high, int channels) const
    {
        const auto values = static_cast<std::uintmax_t>(std::max(channels, 1));
        if (wide > kMostTileValues / std::max<std::uintmax_t>(high, 1) / values)
            refuse("image has larger tiles than are read: " + std::to_string(wide) + " x " + std::to_string(high));
    }

    bool has_multiplied_colors(OpenImage& image)
    {
        if (format_ == "openexr") return !TiledFile::keeps_colors_apart(*image.reader);
        if (format_ == "tiff") return pixels_of_tiff(image.bytes).is_multiplied;
        if (format_ == "targa") return has_multiplied_colors_tga(bytes_);
        return place_of_multiplied_dds(bytes_).has_value();
    }

    // Returns whether a BMP has the bytes of its pixels in an order that the library does not know, but we do.
    bool has_bmp_order()
    {
        const auto masks = masks_of_bmp(bytes_);
        return masks && !are_usual(*masks) && are_bytes(*masks);
    }

    void check_tiff(const TiffPixels& pixels) const
    {
        if (pixels.bits > 32) refuse("TIFF files of more than 32 bits a sample are not read");
        if (pixels.kind == TiffPixels::kInks && pixels.samples > 4)
            refuse("TIFF files of four inks (CMYK) and further samples are not read");
        if (pixels.kind >= TiffPixels::kLab && pixels.kind <= TiffPixels::kLastLab)
            refuse("TIFF files with colours in CIELab are not read");
    }

    // Returns what the file says of its channels. The library takes the second or the fourth for alpha, and inverts values
    // of which 0 is white only if they have eight bits or fewer.
    ChannelChoice channels_of(OpenImage& image)
    {
        const int count = image.reader->spec().channel_count();
        ChannelChoice all, without_alpha;
        without_alpha.channels = count > 2 ? std::vector{0, 1, 2} : std::vector{0};
        if (format_ == "bmp") {
            const auto masks = masks_of_bmp(bytes_);
            return masks && (*masks)[3] == 0 ? without_alpha : all;
        }
        if (format_ == "targa") return has_no_alpha_tga(bytes_) ? without_alpha : all;
        if (format_ != "tiff") return all;
        const TiffPixels pixels = pixels_of_tiff(image.bytes);
        if (pixels.kind > TiffPixels::kRgb) return all;
        ChannelChoice choice;
        choice.are_inverted = pixels.kind == TiffPixels::kWhiteIsZero && pixels.bits > 8;
        if (!pixels.alpha && pixels.extra < 2) return choice;
        for (int c = 0; c < (pixels.kind == TiffPixels::kRgb ? 3 : 1); ++c) choice.channels.push_back(c);
        if (pixels.alpha) choice.channels.push_back(static_cast<int>(pixels.samples - pixels.extra + *pixels.alpha));
        else if (pixels.kind == TiffPixels::kRgb) choice.channels.push_back(3);
        return choice;
    }

    Orientation radiance_orientation(const PictureReader& image) const
    {
        const Orientation orientation = orientation_of(
            number_in<std::size_t>(image.text_attribute("Orientation")).value_or(0));
        if (orientation.swaps_axes) refuse("Radiance images that are stored column by column are not read");
        return orientation;
    }

    std::vector<std::byte> whole()
    {
        if (encoded_) return *encoded_;
        constexpr std::size_t kDirectory = 1 << 16;  // of a TIFF, which may be put behind its end: else it would be copied
        std::vector<std::byte> all;
        all.reserve(static_cast<std::size_t>(bytes_.size()) + kDirectory);
        all.resize(static_cast<std::size_t>(bytes_.size()));
        if (!bytes_.read(0, {reinterpret_cast<unsigned char*>(all.data()), all.size()})) refuse("the image cannot be read");
        return all;
    }

    const std::filesystem::path& path_;
    const std::vector<std::byte>* encoded_;
    const std::string& name_;
    const ImageLimits& limits_;
    DecodeBudget* const budget_;
    ImageBytes bytes_;
    std::string format_;
};

}  // namespace

bool declares_too_much(std::uintmax_t texels, std::uintmax_t file_bytes) noexcept
{
    return texels > kAlwaysAllowedTexels && texels / kMaxTexelsPerByte > file_bytes;
}

OpenImage open_image(const std::filesystem::path& file, const std::vector<std::byte>* encoded, const std::string& name,
                     const ImageLimits& limits, DecodeBudget* budget)
{
    return Opener(file, encoded, name, limits, budget).open();
}

}  // namespace occam
