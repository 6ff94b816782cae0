// Reading and writing picture files, behind an interface that names no library.
//
// The library that knows the formats brings more than two hundred shared libraries with it, and loading them takes longer
// than some pictures do. So its callers are in a module of their own (picture_module/), which is loaded when the first
// picture file is read or written that neither io/exr_file.h nor io/png_file.h handles, and never before.
//
// Threads  picture_codec() may be called by any thread. A PictureReader serves one caller at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace occam {

/// Names the type of a picture's values in a file.
enum class SampleType : unsigned char {
    Byte,
    Word,  ///< 16 bits without a sign
    Half,
    Float,
    OtherInteger,
    OtherReal
};

inline bool is_real(SampleType type) noexcept
{
    return type == SampleType::Half || type == SampleType::Float || type == SampleType::OtherReal;
}

/// Returns the bytes of a value of that type, or the most that it may have.
inline std::size_t most_bytes(SampleType type) noexcept
{
    constexpr std::size_t kBytes[] = {1, 2, 2, 4, 8, 8};
    return kBytes[static_cast<std::size_t>(type)];
}

/// Describes a picture in a file. The data window starts at (x, y); the full window is the whole frame.
struct PictureSpec {
    int width = 0, height = 0, depth = 1;
    int x = 0, y = 0;
    int full_x = 0, full_y = 0, full_width = 0, full_height = 0;
    int tile_width = 0, tile_height = 0;  ///< 0: the file has no tiles
    bool is_deep = false;
    bool has_levels = false;  ///< MIP levels, each side half as long and rounded down; told of OpenEXR files of one part
    SampleType type = SampleType::Float;
    std::vector<std::string> channels;
    std::vector<SampleType> channel_types;  ///< empty: all are of `type`
    int alpha_channel = -1;

    int channel_count() const noexcept { return static_cast<int>(channels.size()); }
    SampleType channel_type(std::size_t channel) const noexcept
    {
        return channel < channel_types.size() ? channel_types[channel] : type;
    }
};

/// Holds an attribute of a file's header. Matrices are 16 floats in OpenEXR's order.
struct PictureAttribute {
    using Value = std::variant<std::string, float, int, std::array<float, 16>, std::array<float, 8>>;
    std::string name;
    Value value;
};

/// An opened picture file.
class PictureReader {
public:
    virtual ~PictureReader() = default;
    virtual const PictureSpec& spec() const noexcept = 0;
    virtual std::string format() const = 0;  ///< "png", "openexr", ...
    /// Returns an attribute of the file that is a text, or by the module's readers a whole number; an empty text if there is
    /// none.
    virtual std::string text_attribute(const std::string& name) const = 0;
    /// Reads rows [y_begin, y_end), counted from the top of the data window, and their first `channels` channels.
    /// Returns false if they cannot be decoded; error() then says why.
    virtual bool read_rows(int y_begin, int y_end, int channels, std::uint8_t* to) = 0;
    virtual bool read_rows(int y_begin, int y_end, int channels, float* to) = 0;
    virtual std::string error() const = 0;
};

/// Receives the bytes of an encoder, which may go back and read what it has written. Failures are the receiver's to
/// remember, because some encoders end the process if a write fails.
class PictureBytes {
public:
    virtual ~PictureBytes() = default;
    virtual void write_at(const void* bytes, std::size_t size, std::uint64_t offset) noexcept = 0;
    virtual std::size_t read_at(void* bytes, std::size_t size, std::uint64_t offset) const noexcept = 0;
    virtual std::uint64_t size() const noexcept = 0;
};

class PictureCodec {
public:
    virtual ~PictureCodec() = default;
    /// Opens a file of a known format by its path, with alpha that is not multiplied into the colours. Returns null and says
    /// why in `error` if it cannot be read. The caller has checked what the file declares.
    virtual std::unique_ptr<PictureReader> open(const std::filesystem::path& file, const std::string& format,
                                                std::string& error) const = 0;
    /// The same, for a file that is trusted; its first bytes say its format.
    std::unique_ptr<PictureReader> open(const std::filesystem::path& file, std::string& error) const;
    /// Opens a file of a known format in memory. The bytes are borrowed as long as the reader lives.
    virtual std::unique_ptr<PictureReader> open(std::span<const std::byte> file, const std::string& format,
                                                std::string& error) const = 0;
    /// Encodes interleaved floats in the format of the extension of `file`, which is not touched. Returns what went wrong,
    /// or nothing.
    virtual std::string write(const std::filesystem::path& file, const PictureSpec& spec,
                              std::span<const PictureAttribute> attributes, const float* pixels, PictureBytes& to) const = 0;
};

/// Returns the codec of the module, which is loaded now if it was not. Throws Error if it cannot be loaded, and
/// std::bad_alloc if the process has no room for it.
const PictureCodec& picture_codec();

/// Returns whether a thread is loading the module now. The constructors of its libraries allocate memory and start threads,
/// and an exception for lack of these ends the process, since nothing can catch it there.
bool is_loading_picture_codec() noexcept;

/// Throws Error if the file of the module is not where picture_codec() looks for it. Loads nothing.
void check_picture_codec();

}  // namespace occam
