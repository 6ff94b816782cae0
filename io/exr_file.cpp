#include "io/exr_file.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numeric>
#include <string>

#include "base/half.h"
#include "base/overloaded.h"

namespace occam {
namespace {

using namespace std::string_view_literals;

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

constexpr std::string_view kMagic = "\x76\x2f\x31\x01"sv;
constexpr std::uint32_t kVersion = 2, kHasLongNames = 0x400;
constexpr std::size_t kLongestShortName = 31;
constexpr std::uint8_t kZip = 3;
constexpr int kBlockLines = 16;
constexpr int kZipLevel = 4;
constexpr std::size_t kMostHeadBytes = std::size_t(64) << 20;

template <class T>
void append(std::string& to, T value)
{
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    to.append(bytes, sizeof(T));
}
void append_name(std::string& to, std::string_view name)
{
    to += name.substr(0, name.find('\0'));
    to += '\0';
}
void append_attribute(std::string& to, std::string_view name, std::string_view type, std::string_view value)
{
    append_name(to, name);
    append_name(to, type);
    append(to, static_cast<std::int32_t>(value.size()));
    to += value;
}
template <class... T>
std::string packed(T... values)
{
    std::string bytes;
    (append(bytes, values), ...);
    return bytes;
}

void append_given(std::string& to, const PictureAttribute& a)
{
    const auto floats = [](const auto& array) {
        return std::string_view(reinterpret_cast<const char*>(array.data()), sizeof(array));
    };
    std::visit(Overloaded{[&](const std::string& text) { append_attribute(to, a.name, "string", text); },
                          [&](float number) { append_attribute(to, a.name, "float", packed(number)); },
                          [&](int number) { append_attribute(to, a.name, "int", packed(number)); },
                          [&](const std::array<float, 16>& m) { append_attribute(to, a.name, "m44f", floats(m)); },
                          [&](const std::array<float, 8>& c) { append_attribute(to, a.name, "chromaticities", floats(c)); }},
               a.value);
}

bool is_half(const PictureSpec& spec, std::size_t channel) noexcept
{
    return spec.channel_type(channel) == SampleType::Half;
}

// Returns the indices of the channels in the order of their names, which is their order in the file.
std::vector<std::size_t> file_order(const PictureSpec& spec)
{
    std::vector<std::size_t> order(spec.channels.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::ranges::sort(order, {}, [&](std::size_t i) -> const std::string& { return spec.channels[i]; });
    return order;
}

std::string head_of(const PictureSpec& spec, std::span<const PictureAttribute> attributes,
                    const std::vector<std::size_t>& order)
{
    bool has_long_names = false;
    const auto note_length = [&](const std::string& name) { has_long_names |= name.size() > kLongestShortName; };
    for (const std::string& name : spec.channels) note_length(name);
    for (const PictureAttribute& a : attributes) note_length(a.name);

    std::string channels;
    for (const std::size_t i : order) {
        append_name(channels, spec.channels[i]);
        channels += packed(std::int32_t(is_half(spec, i) ? 1 : 2), std::int32_t(0), std::int32_t(1), std::int32_t(1));
    }
    channels += '\0';
    const auto window = [](int x, int y, int width, int height) { return packed(x, y, x + width - 1, y + height - 1); };

    std::string head(kMagic);
    append(head, kVersion | (has_long_names ? kHasLongNames : 0));
    for (const PictureAttribute& a : attributes) append_given(head, a);
    append_attribute(head, "channels", "chlist", channels);
    append_attribute(head, "compression", "compression", packed(kZip));
    append_attribute(head, "dataWindow", "box2i", window(spec.x, spec.y, spec.width, spec.height));
    append_attribute(head, "displayWindow", "box2i", window(spec.full_x, spec.full_y, spec.full_width, spec.full_height));
    append_attribute(head, "lineOrder", "lineOrder", packed(std::uint8_t(0)));
    append_attribute(head, "pixelAspectRatio", "float", packed(1.0f));
    append_attribute(head, "screenWindowCenter", "v2f", packed(0.0f, 0.0f));
    append_attribute(head, "screenWindowWidth", "float", packed(1.0f));
    head += '\0';
    return head;
}

std::uint16_t half_of(float f) noexcept
{
    if (std::isnan(f)) return 0x7e00;
    // From 65520 on a float is nearer to the half above the largest, which is infinity.
    if (std::fabs(f) >= 65520.0f) return f < 0 ? 0xfc00 : 0x7c00;
    return finite_half_from_float(f);
}

// Returns the bytes of some lines: line by line, and in each of them channel by channel.
std::string lines_of(const PictureSpec& spec, const float* pixels, const std::vector<std::size_t>& order, int first, int end)
{
    const std::size_t channels = spec.channels.size(), width = static_cast<std::size_t>(spec.width);
    std::string bytes;
    for (int y = first; y < end; ++y) {
        const float* const line = pixels + std::size_t(y) * width * channels;
        for (const std::size_t c : order)
            for (std::size_t x = 0; x < width; ++x) {
                const float value = line[x * channels + c];
                if (is_half(spec, c)) append(bytes, half_of(value));
                else append(bytes, value);
            }
    }
    return bytes;
}

// Compresses a block: bytes at even places come first, then those at odd ones, each as its difference to the one before it.
// Returns the block as it is if that makes it no smaller.
std::string compressed(const std::string& block)
{
    const std::size_t size = block.size(), half = (size + 1) / 2;
    std::string apart(size, '\0');
    for (std::size_t i = 0; i < size; ++i) apart[i / 2 + (i % 2) * half] = block[i];
    for (std::size_t i = size; i-- > 1;)
        apart[i] = static_cast<char>(static_cast<unsigned char>(apart[i]) - static_cast<unsigned char>(apart[i - 1]) + 128);
    uLongf small_size = compressBound(static_cast<uLong>(size));
    std::string small(small_size, '\0');
    const int result = compress2(reinterpret_cast<Bytef*>(small.data()), &small_size,
                                 reinterpret_cast<const Bytef*>(apart.data()), static_cast<uLong>(size), kZipLevel);
    if (result != Z_OK || small_size >= size) return block;
    small.resize(small_size);
    return small;
}

// Reads a name that ends with a null, or returns nothing if it is not whole.
std::optional<std::string> take_name(std::string_view bytes, std::size_t& at)
{
    const std::size_t end = bytes.find('\0', at);
    if (end == std::string_view::npos) return {};
    std::string name(bytes.substr(at, end - at));
    at = end + 1;
    return name;
}

// Returns the number of entries of a list of channels.
int count_channels(std::string_view list)
{
    constexpr std::size_t kBehindName = 16;
    int count = 0;
    for (std::size_t at = 0; at < list.size() && list[at] != '\0'; ++count) {
        if (!take_name(list, at) || list.size() - at < kBehindName) return 0;
        at += kBehindName;
    }
    return count;
}

}  // namespace

void write_exr(const PictureSpec& spec, std::span<const PictureAttribute> attributes, const float* pixels, PictureBytes& to)
{
    const std::vector<std::size_t> order = file_order(spec);
    const std::string head = head_of(spec, attributes, order);
    std::vector<std::uint64_t> starts;
    const std::size_t blocks = static_cast<std::size_t>((spec.height + kBlockLines - 1) / kBlockLines);
    std::uint64_t at = head.size() + blocks * sizeof(std::uint64_t);
    for (int y = 0; y < spec.height; y += kBlockLines) {
        const std::string block = compressed(lines_of(spec, pixels, order, y, std::min(y + kBlockLines, spec.height)));
        const std::string start = packed(std::int32_t(spec.y + y), static_cast<std::int32_t>(block.size()));
        to.write_at(start.data(), start.size(), at);
        to.write_at(block.data(), block.size(), at + start.size());
        starts.push_back(at);
        at += start.size() + block.size();
    }
    to.write_at(head.data(), head.size(), 0);
    to.write_at(starts.data(), starts.size() * sizeof(std::uint64_t), head.size());
}

std::optional<ExrHead> read_exr_head(const std::filesystem::path& file)
{
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    if (error) return {};
    std::string bytes(static_cast<std::size_t>(std::min<std::uintmax_t>(size, kMostHeadBytes)), '\0');
    std::ifstream in(file, std::ios::binary);
    if (!in.read(bytes.data(), static_cast<std::streamsize>(bytes.size())) || !bytes.starts_with(kMagic)) return {};
    ExrHead head;
    for (std::size_t at = kMagic.size() + sizeof kVersion; at < bytes.size();) {
        if (bytes[at] == '\0') return head.width > 0 && head.channel_count > 0 ? std::optional(head) : std::nullopt;
        const auto name = take_name(bytes, at);
        const auto type = name ? take_name(bytes, at) : std::nullopt;
        std::int32_t length = 0;
        if (!type || bytes.size() - at < sizeof length) return {};
        std::memcpy(&length, bytes.data() + at, sizeof length);
        at += sizeof length;
        if (length < 0 || bytes.size() - at < static_cast<std::size_t>(length)) return {};
        const std::string_view value(bytes.data() + at, static_cast<std::size_t>(length));
        at += value.size();
        if (*name == "channels") head.channel_count = count_channels(value);
        if (*name != "dataWindow" || value.size() != 4 * sizeof(std::int32_t)) continue;
        std::int32_t window[4];
        std::memcpy(window, value.data(), sizeof window);
        const std::int64_t width = std::int64_t(window[2]) - window[0] + 1, height = std::int64_t(window[3]) - window[1] + 1;
        if (width < 1 || height < 1 || std::max(width, height) > std::numeric_limits<int>::max()) return {};
        head.width = static_cast<int>(width);
        head.height = static_cast<int>(height);
    }
    return {};
}

}  // namespace occam
