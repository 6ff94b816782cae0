#include "io/texture/chosen_channels.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

namespace occam {

namespace {

class ChoosingReader final : public PictureReader {
public:
    ChoosingReader(std::unique_ptr<PictureReader> all, std::vector<int> channels, bool are_inverted)
        : all_(std::move(all)), channels_(std::move(channels)), are_inverted_(are_inverted), spec_(all_->spec())
    {
        const PictureSpec& from = all_->spec();
        spec_.channels.clear(), spec_.channel_types.clear();
        for (const int c : channels_) {
            spec_.channels.push_back(from.channels[static_cast<std::size_t>(c)]);
            spec_.channel_types.push_back(from.channel_type(static_cast<std::size_t>(c)));
        }
        const int count = spec_.channel_count();
        spec_.alpha_channel = count % 2 == 0 ? count - 1 : -1;
    }

    const PictureSpec& spec() const noexcept override { return spec_; }
    std::string format() const override { return all_->format(); }
    std::string text_attribute(const std::string& name) const override { return all_->text_attribute(name); }
    bool read_rows(int y_begin, int y_end, int channels, std::uint8_t* to) override
    {
        return read_as(y_begin, y_end, channels, to);
    }
    bool read_rows(int y_begin, int y_end, int channels, float* to) override
    {
        return read_as(y_begin, y_end, channels, to);
    }
    std::string error() const override { return all_->error(); }

private:
    template <class T>
    bool read_as(int y_begin, int y_end, int channels, T* to)
    {
        const auto chosen = static_cast<std::size_t>(channels);
        const int needed = 1 + *std::max_element(channels_.begin(), channels_.begin() + channels);
        const std::size_t texels = static_cast<std::size_t>(y_end - y_begin) * static_cast<std::size_t>(spec_.width);
        std::vector<T> values(texels * static_cast<std::size_t>(needed));
        if (!all_->read_rows(y_begin, y_end, needed, values.data())) return false;
        constexpr T kWhite = std::is_integral_v<T> ? std::numeric_limits<T>::max() : T(1);
        for (std::size_t i = 0; i < texels; ++i)
            for (std::size_t c = 0; c < chosen; ++c) {
                const T value = values[i * static_cast<std::size_t>(needed) + static_cast<std::size_t>(channels_[c])];
                const bool is_inverted = are_inverted_ && static_cast<int>(c) != spec_.alpha_channel;
                to[i * chosen + c] = is_inverted ? static_cast<T>(kWhite - value) : value;
            }
        return true;
    }

    std::unique_ptr<PictureReader> all_;
    std::vector<int> channels_;
    bool are_inverted_;
    PictureSpec spec_;
};

}  // namespace

std::unique_ptr<PictureReader> with_chosen_channels(std::unique_ptr<PictureReader> reader, const ChannelChoice& choice)
{
    if (choice == ChannelChoice()) return reader;
    std::vector<int> channels = choice.channels;
    const int count = reader->spec().channel_count();
    if (channels.empty())
        for (int c = 0; c < count; ++c) channels.push_back(c);
    std::erase_if(channels, [&](int c) { return c >= count; });
    bool are_all = static_cast<int>(channels.size()) == count;
    for (std::size_t i = 0; i < channels.size(); ++i) are_all &= channels[i] == static_cast<int>(i);
    if (channels.empty() || (are_all && !choice.are_inverted)) return reader;
    return std::make_unique<ChoosingReader>(std::move(reader), std::move(channels), choice.are_inverted);
}

}  // namespace occam
