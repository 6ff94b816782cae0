// The module behind picture_codec(): the only file that uses OpenImageIO.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <exception>
#include <new>
#include <utility>
#include <vector>

#include "base/overloaded.h"
#include "io/picture_codec.h"
#include "io/picture_module/webp_reader.h"

namespace occam {
namespace {

SampleType type_of(OIIO::TypeDesc type) noexcept
{
    switch (type.basetype) {
        case OIIO::TypeDesc::UINT8:
            return SampleType::Byte;
        case OIIO::TypeDesc::UINT16:
            return SampleType::Word;
        case OIIO::TypeDesc::HALF:
            return SampleType::Half;
        case OIIO::TypeDesc::FLOAT:
            return SampleType::Float;
        case OIIO::TypeDesc::DOUBLE:
            return SampleType::OtherReal;
        default:
            return SampleType::OtherInteger;
    }
}

// The two types without a name of their own are those of files that are read, and none is written with them.
OIIO::TypeDesc type_of(SampleType type) noexcept
{
    switch (type) {
        case SampleType::Byte:
            return OIIO::TypeDesc::UINT8;
        case SampleType::Word:
        case SampleType::OtherInteger:
            return OIIO::TypeDesc::UINT16;
        case SampleType::Half:
            return OIIO::TypeDesc::HALF;
        case SampleType::Float:
        case SampleType::OtherReal:
            break;
    }
    return OIIO::TypeDesc::FLOAT;
}

PictureSpec spec_of(const OIIO::ImageSpec& from)
{
    PictureSpec spec;
    spec.width = from.width, spec.height = from.height, spec.depth = from.depth;
    spec.x = from.x, spec.y = from.y;
    spec.full_x = from.full_x, spec.full_y = from.full_y;
    spec.full_width = from.full_width, spec.full_height = from.full_height;
    spec.tile_width = std::max(from.tile_width, 0);
    spec.tile_height = spec.tile_width > 0 ? from.tile_height : 0;
    spec.is_deep = from.deep;
    spec.type = type_of(from.format);
    spec.channels = from.channelnames;
    spec.channels.resize(static_cast<std::size_t>(std::max(from.nchannels, 0)));
    for (const OIIO::TypeDesc& type : from.channelformats) spec.channel_types.push_back(type_of(type));
    spec.alpha_channel = from.alpha_channel;
    return spec;
}

class Reader final : public PictureReader {
public:
    Reader(std::unique_ptr<OIIO::ImageInput> input, std::unique_ptr<OIIO::Filesystem::IOProxy> bytes)
        : bytes_(std::move(bytes)), input_(std::move(input)), spec_(spec_of(input_->spec()))
    {
    }

    const PictureSpec& spec() const noexcept override { return spec_; }
    std::string format() const override { return input_->format_name(); }
    std::string text_attribute(const std::string& name) const override
    {
        const OIIO::ImageSpec& spec = input_->spec();
        const OIIO::ParamValue* const found = spec.find_attribute(name);
        if (found && found->type() == OIIO::TypeDesc::INT) return std::to_string(spec.get_int_attribute(name));
        return std::string(spec.get_string_attribute(name));
    }
    bool read_rows(int y_begin, int y_end, int channels, std::uint8_t* to) override
    {
        return read(y_begin, y_end, channels, OIIO::TypeDesc::UINT8, to);
    }
    bool read_rows(int y_begin, int y_end, int channels, float* to) override
    {
        return read(y_begin, y_end, channels, OIIO::TypeDesc::FLOAT, to);
    }
    std::string error() const override
    {
        const std::string why = thrown_.empty() ? input_->geterror() : thrown_;
        return why.empty() ? "it is damaged" : why;
    }

private:
    // Some of the library's readers throw what is not meant for anybody, such as that a vector is too long.
    bool read(int y_begin, int y_end, int channels, OIIO::TypeDesc type, void* to)
    try {
        const int y0 = spec_.y + y_begin, y1 = spec_.y + y_end;
        if (spec_.tile_height > 0)
            return input_->read_tiles(0, 0, spec_.x, spec_.x + spec_.width, y0, y1, 0, 1, 0, channels, type, to);
        return input_->read_scanlines(0, 0, y0, y1, 0, 0, channels, type, to);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        thrown_ = error.what();
        return false;
    }

    std::unique_ptr<OIIO::Filesystem::IOProxy> bytes_;  // the input refers to them
    std::unique_ptr<OIIO::ImageInput> input_;
    PictureSpec spec_;
    std::string thrown_;
};

// Hands a file to decoders. The library's own reader of files ends the process where memory fails.
class DecoderStream final : public OIIO::Filesystem::IOProxy {
public:
    explicit DecoderStream(const std::string& name) : IOProxy(name, Read), file_(::open(name.c_str(), O_RDONLY | O_CLOEXEC))
    {
    }
    DecoderStream(const DecoderStream&) = delete;
    DecoderStream& operator=(const DecoderStream&) = delete;
    ~DecoderStream() override
    {
        if (file_ >= 0) ::close(file_);
    }

    const char* proxytype() const override { return "occam"; }
    std::size_t read(void* bytes, std::size_t size) override
    {
        const std::size_t got = pread(bytes, size, m_pos);
        m_pos += static_cast<std::int64_t>(got);
        return got;
    }
    std::size_t pread(void* bytes, std::size_t size, std::int64_t offset) override
    {
        const ssize_t got = file_ >= 0 ? ::pread(file_, bytes, size, offset) : -1;
        return got > 0 ? static_cast<std::size_t>(got) : 0;
    }
    std::size_t size() const override
    {
        struct stat about {};
        return file_ >= 0 && ::fstat(file_, &about) == 0 ? static_cast<std::size_t>(about.st_size) : 0;
    }

private:
    const int file_;
};

// Returns the first GB of a file. No JPEG of up to 2^32 texels and no WebP, of up to 2^28, is longer unless it is made to
// be.
std::vector<char> first_bytes_of(const std::string& name)
{
    constexpr std::size_t kMostBytes = std::size_t(1) << 30;
    DecoderStream file(name);
    std::vector<char> bytes(std::min(file.size(), kMostBytes));
    bytes.resize(file.read(bytes.data(), bytes.size()));
    return bytes;
}

// Holds a file for the reader of JPEG, which takes no other stream than memory or the library's own. That one ends the
// process if memory fails while it is opened.
class FileInMemory final : public OIIO::Filesystem::IOMemReader {
public:
    explicit FileInMemory(std::vector<char> bytes) : IOMemReader(bytes.data(), bytes.size()), bytes_(std::move(bytes)) {}

private:
    const std::vector<char> bytes_;
};

// Hands the bytes of encoders on. They are told that every write succeeded.
class EncoderStream final : public OIIO::Filesystem::IOProxy {
public:
    EncoderStream(const std::string& name, PictureBytes& to) : IOProxy(name, Write), to_(to) {}

    const char* proxytype() const override { return "occam"; }
    std::size_t write(const void* bytes, std::size_t size) override
    {
        to_.write_at(bytes, size, static_cast<std::uint64_t>(m_pos));
        m_pos += static_cast<std::int64_t>(size);
        return size;
    }
    std::size_t pwrite(const void* bytes, std::size_t size, std::int64_t offset) override
    {
        to_.write_at(bytes, size, static_cast<std::uint64_t>(offset));
        return size;
    }
    std::size_t read(void* bytes, std::size_t size) override
    {
        const std::size_t got = pread(bytes, size, m_pos);
        m_pos += static_cast<std::int64_t>(got);
        return got;
    }
    std::size_t pread(void* bytes, std::size_t size, std::int64_t offset) override
    {
        return to_.read_at(bytes, size, static_cast<std::uint64_t>(offset));
    }
    std::size_t size() const override { return to_.size(); }

private:
    PictureBytes& to_;
};

OIIO::ImageSpec spec_of(const PictureSpec& from, std::span<const PictureAttribute> attributes)
{
    // The constructor with channels would name them, and end the process if there is no memory for the names.
    OIIO::ImageSpec spec(type_of(from.type));
    spec.x = from.x, spec.y = from.y;
    spec.width = from.width, spec.height = from.height, spec.depth = 1;
    spec.full_width = from.full_width, spec.full_height = from.full_height, spec.full_depth = 1;
    spec.nchannels = from.channel_count();
    spec.channelnames = from.channels;
    for (const SampleType type : from.channel_types) spec.channelformats.push_back(type_of(type));
    spec.alpha_channel = from.alpha_channel;
    for (const PictureAttribute& a : attributes)
        std::visit(
            Overloaded{[&](const std::string& text) { spec.attribute(a.name, text); },
                       [&](float number) { spec.attribute(a.name, number); },
                       [&](int number) { spec.attribute(a.name, number); },
                       [&](const std::array<float, 16>& matrix) { spec.attribute(a.name, OIIO::TypeMatrix, matrix.data()); },
                       [&](const std::array<float, 8>& eight) {
                           spec.attribute(a.name, OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), eight.data());
                       }},
            a.value);
    return spec;
}

class Codec final : public PictureCodec {
public:
    std::unique_ptr<PictureReader> open(const std::filesystem::path& file, const std::string& format,
                                        std::string& error) const override
    {
        if (format == "webp") return open_webp(first_bytes_of(file.string()), error);
        std::unique_ptr<OIIO::Filesystem::IOProxy> stream;
        if (format == "jpeg") stream = std::make_unique<FileInMemory>(first_bytes_of(file.string()));
        else stream = std::make_unique<DecoderStream>(file.string());
        return open(file.string(), format, std::move(stream), error);
    }

    std::unique_ptr<PictureReader> open(std::span<const std::byte> file, const std::string& format,
                                        std::string& error) const override
    {
        if (format == "webp") return open_webp(file, error);
        auto memory = std::make_unique<OIIO::Filesystem::IOMemReader>(const_cast<std::byte*>(file.data()), file.size());
        return open("memory." + format, format, std::move(memory), error);
    }

    std::string write(const std::filesystem::path& file, const PictureSpec& spec,
                      std::span<const PictureAttribute> attributes, const float* pixels, PictureBytes& to) const override
    {
        EncoderStream stream(file.string(), to);
        std::unique_ptr<OIIO::ImageOutput> encoder = OIIO::ImageOutput::create(extension_of(file));
        if (!encoder) return "its format has no encoder: " + OIIO::geterror();
        // The destructor closes an encoder that is open, and where that fails the library ends the process. So one that has
        // failed since it was opened is left behind. Writing never fails, so that is rare: there is not enough memory.
        try {
            const bool is_open = encoder->set_ioproxy(&stream) && encoder->open(file.string(), spec_of(spec, attributes));
            if (is_open && encoder->write_image(OIIO::TypeDesc::FLOAT, pixels) && encoder->close()) return {};
            const std::string why = encoder->geterror();
            if (is_open) static_cast<void>(encoder.release());
            return why.empty() ? "the encoder failed" : why;
        } catch (...) {
            static_cast<void>(encoder.release());
            throw;
        }
    }

private:
    // The library takes a name for the address of a resource if it has a question mark, so it only gets the extension.
    static std::string extension_of(const std::filesystem::path& file)
    {
        const std::string extension = file.extension().string();
        return extension.empty() ? extension : extension.substr(1);
    }
    static std::unique_ptr<OIIO::ImageInput> create(const std::string& format)
    {
        return format.empty() ? nullptr : OIIO::ImageInput::create(format);
    }
    static std::string why_not(const OIIO::ImageInput* input)
    {
        const std::string why = input ? input->geterror() : OIIO::geterror();
        return why.empty() ? "it is damaged, or of another format" : why;
    }
    // Opens what the stream holds, or the file of that name if there is no stream or the format's reader takes none. The
    // reader refers to the stream, which lives longer.
    static std::unique_ptr<PictureReader> open(const std::string& name, const std::string& format,
                                               std::unique_ptr<OIIO::Filesystem::IOProxy> stream, std::string& error)
    try {
        std::unique_ptr<OIIO::ImageInput> input = create(format);
        OIIO::ImageSpec wishes = reading_wishes(), opened;
        // The reader takes the stream from this attribute: ImageInput::open(name, config, proxy) closes the stream again.
        OIIO::Filesystem::IOProxy* const proxy = stream.get();
        if (proxy && input && input->supports("ioproxy")) wishes.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
        if (input && input->open(name, opened, wishes)) return std::make_unique<Reader>(std::move(input), std::move(stream));
        error = why_not(input.get());
        return nullptr;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& thrown) {
        error = thrown.what();
        return nullptr;
    }
    static OIIO::ImageSpec reading_wishes()
    {
        OIIO::ImageSpec wishes;
        wishes.attribute("oiio:UnassociatedAlpha", 1);
        return wishes;
    }
};

}  // namespace
}  // namespace occam

extern "C" __attribute__((visibility("default"))) const occam::PictureCodec* occam_picture_codec()
{
    static const occam::Codec codec;
    return &codec;
}
