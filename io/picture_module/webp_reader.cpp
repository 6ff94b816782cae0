// This is the only source file that uses libwebp.
#include "io/picture_module/webp_reader.h"

#include <webp/decode.h>
#include <webp/demux.h>

#include <algorithm>
#include <cstdint>
#include <new>
#include <utility>

namespace occam {
namespace {

constexpr const char* kDamaged = "it is damaged";

// The first frame of a file, as a part of the file's bytes. The library finds it without a look at its pixels.
class FirstFrame {
public:
    explicit FirstFrame(std::span<const std::byte> file)
    {
        const WebPData data{reinterpret_cast<const std::uint8_t*>(file.data()), file.size()};
        demuxer_ = WebPDemux(&data);
        is_whole_ = demuxer_ && WebPDemuxGetFrame(demuxer_, 1, &frame_) != 0;
    }
    FirstFrame(const FirstFrame&) = delete;
    FirstFrame& operator=(const FirstFrame&) = delete;
    ~FirstFrame()
    {
        WebPDemuxReleaseIterator(&frame_);
        WebPDemuxDelete(demuxer_);
    }

    bool is_whole() const noexcept { return is_whole_; }
    const WebPIterator& operator*() const noexcept { return frame_; }
    std::uint32_t of_file(WebPFormatFeature feature) const noexcept { return WebPDemuxGetI(demuxer_, feature); }

private:
    WebPDemuxer* demuxer_ = nullptr;
    WebPIterator frame_{};
    bool is_whole_ = false;
};

class WebpReader final : public PictureReader {
public:
    explicit WebpReader(std::vector<char> bytes) : kept_(std::move(bytes)), frame_(std::as_bytes(std::span(kept_)))
    {
        describe();
    }
    explicit WebpReader(std::span<const std::byte> bytes) : frame_(bytes) { describe(); }

    bool is_open() const noexcept { return frame_.is_whole(); }
    const PictureSpec& spec() const noexcept override { return spec_; }
    std::string format() const override { return "webp"; }
    std::string text_attribute(const std::string&) const override { return {}; }
    std::string error() const override { return kDamaged; }

    bool read_rows(int y_begin, int y_end, int channels, std::uint8_t* to) override
    {
        return read(y_begin, y_end, channels, to, [](std::uint8_t value) { return value; });
    }
    bool read_rows(int y_begin, int y_end, int channels, float* to) override
    {
        return read(y_begin, y_end, channels, to,
                    [](std::uint8_t value) { return static_cast<float>(value) * (1.0f / 255); });
    }

private:
    void describe()
    {
        if (!frame_.is_whole()) return;
        spec_.width = spec_.full_width = static_cast<int>(frame_.of_file(WEBP_FF_CANVAS_WIDTH));
        spec_.height = spec_.full_height = static_cast<int>(frame_.of_file(WEBP_FF_CANVAS_HEIGHT));
        spec_.type = SampleType::Byte;
        spec_.channels = {"R", "G", "B"};
        if ((frame_.of_file(WEBP_FF_FORMAT_FLAGS) & ALPHA_FLAG) == 0) return;
        spec_.alpha_channel = 3;
        spec_.channels.emplace_back("A");
    }

    // Returns whether the frame lies on the canvas and has the size that the file says. The library has checked that, but
    // its decoder is about to write to memory of the canvas's size.
    bool fits(const WebPIterator& frame, const WebPBitstreamFeatures& found) const
    {
        return found.width == frame.width && found.height == frame.height && frame.x_offset >= 0 && frame.y_offset >= 0 &&
               frame.width <= spec_.width - frame.x_offset && frame.height <= spec_.height - frame.y_offset;
    }

    // Decodes the whole picture. Throws std::bad_alloc.
    bool decode()
    {
        const WebPIterator& frame = *frame_;
        WebPDecoderConfig config;
        if (!WebPInitDecoderConfig(&config)) return false;
        const VP8StatusCode features = WebPGetFeatures(frame.fragment.bytes, frame.fragment.size, &config.input);
        if (features == VP8_STATUS_OUT_OF_MEMORY) throw std::bad_alloc();
        if (features != VP8_STATUS_OK || !fits(frame, config.input)) return false;
        const std::size_t channels = spec_.channels.size(), row = channels * static_cast<std::size_t>(spec_.width);
        std::vector<std::uint8_t> canvas(row * static_cast<std::size_t>(spec_.height));
        const std::size_t first = row * static_cast<std::size_t>(frame.y_offset) +
                                  channels * static_cast<std::size_t>(frame.x_offset);
        config.output.colorspace = channels == 4 ? MODE_RGBA : MODE_RGB;
        config.output.is_external_memory = 1;
        config.output.u.RGBA = {canvas.data() + first, static_cast<int>(row), canvas.size() - first};
        const VP8StatusCode status = WebPDecode(frame.fragment.bytes, frame.fragment.size, &config);
        WebPFreeDecBuffer(&config.output);
        if (status == VP8_STATUS_OUT_OF_MEMORY) throw std::bad_alloc();
        if (status != VP8_STATUS_OK) return false;
        canvas_ = std::move(canvas);
        return true;
    }

    template <class T, class Convert>
    bool read(int y_begin, int y_end, int channels, T* to, const Convert& convert)
    {
        if (canvas_.empty() && !decode()) return false;
        const std::size_t all = spec_.channels.size(), kept = std::min(static_cast<std::size_t>(channels), all);
        const std::size_t columns = static_cast<std::size_t>(spec_.width);
        const std::size_t pixels = static_cast<std::size_t>(y_end - y_begin) * columns;
        const std::uint8_t* from = canvas_.data() + static_cast<std::size_t>(y_begin) * columns * all;
        for (std::size_t p = 0; p < pixels; ++p, from += all, to += channels) std::transform(from, from + kept, to, convert);
        return true;
    }

    std::vector<char> kept_;  // the frame refers to them
    FirstFrame frame_;
    PictureSpec spec_;
    std::vector<std::uint8_t> canvas_;  // empty: not decoded yet
};

template <class Bytes>
std::unique_ptr<PictureReader> open(Bytes bytes, std::string& error)
{
    auto reader = std::make_unique<WebpReader>(std::move(bytes));
    if (reader->is_open()) return reader;
    error = kDamaged;
    return nullptr;
}

}  // namespace

std::unique_ptr<PictureReader> open_webp(std::span<const std::byte> bytes, std::string& error) { return open(bytes, error); }

std::unique_ptr<PictureReader> open_webp(std::vector<char> bytes, std::string& error)
{
    return open(std::move(bytes), error);
}

}  // namespace occam
