#include "io/texture/pnm_samples.h"

#include <algorithm>
#include <string>

namespace occam {
namespace {

constexpr std::uint32_t kMostOfByte = 255, kMostOfWord = 65535;

bool is_blank(unsigned char c) noexcept { return c == ' ' || (c >= '\t' && c <= '\r'); }
bool is_digit(unsigned char c) noexcept { return c >= '0' && c <= '9'; }

// Reads numbers that are separated by blanks and comments. Next is a function that gives the next byte, or nothing.
template <class Next>
class Numbers {
public:
    explicit Numbers(Next next) : next_(next) {}

    /// Returns the next number and takes the byte behind it, too; nothing at the end, or if there is something else.
    std::optional<std::uint32_t> take()
    {
        constexpr std::uint32_t kMost = 100'000'000;
        std::optional<unsigned char> c = next_();
        for (; c && (is_blank(*c) || *c == '#'); c = next_())
            if (*c == '#') skip_comment();
        if (!c || !is_digit(*c)) return std::nullopt;
        std::uint32_t value = 0;
        for (; c && is_digit(*c); c = next_()) {
            value = value * 10 + std::uint32_t(*c - '0');
            if (value > kMost) return std::nullopt;
        }
        if (c && !is_blank(*c)) return std::nullopt;
        return value;
    }

private:
    void skip_comment()
    {
        for (std::optional<unsigned char> c = next_(); c && *c != '\n' && *c != '\r';) c = next_();
    }
    Next next_;
};

}  // namespace

std::optional<PnmHead> read_head_of_few_values(ImageBytes& bytes)
{
    constexpr std::size_t kLongestHead = 1 << 16;
    unsigned char magic[2] = {};
    if (!bytes.read(0, magic) || magic[0] != 'P') return std::nullopt;
    const bool is_text = magic[1] == '2' || magic[1] == '3';
    if (!is_text && magic[1] != '5' && magic[1] != '6') return std::nullopt;
    PnmHead head{.is_text = is_text, .channels = magic[1] == '3' || magic[1] == '6' ? 3 : 1, .samples_at = 2};
    Numbers numbers([&]() -> std::optional<unsigned char> {
        unsigned char c = 0;
        if (head.samples_at >= kLongestHead || !bytes.read(head.samples_at, {&c, 1})) return std::nullopt;
        ++head.samples_at;
        return c;
    });
    for (std::uint32_t* const to : {&head.width, &head.height, &head.most}) {
        const auto number = numbers.take();
        if (!number) return std::nullopt;
        *to = *number;
    }
    if (head.most < 1 || head.most >= kMostOfByte) return std::nullopt;
    return head;
}

std::vector<std::byte> with_many_values(std::span<const std::byte> file, const PnmHead& head)
{
    const std::string first = (head.channels == 3 ? "P6\n" : "P5\n") + std::to_string(head.width) + ' ' +
                              std::to_string(head.height) + '\n' + std::to_string(kMostOfWord) + '\n';
    const auto* const text = reinterpret_cast<const std::byte*>(first.data());
    std::vector<std::byte> out(text, text + first.size());
    const auto put = [&](std::uint32_t sample) {
        const std::uint32_t word = (std::min(sample, head.most) * kMostOfWord + head.most / 2) / head.most;
        out.push_back(static_cast<std::byte>(word >> 8));
        out.push_back(static_cast<std::byte>(word & 0xff));
    };
    std::size_t at = std::min(head.samples_at, file.size());
    const std::uint64_t pixels = std::uint64_t(head.width) * head.height;
    std::size_t left = file.size() - at;  // of samples; behind them a file may hold more
    const auto channels = static_cast<std::size_t>(head.channels);
    if (pixels <= left / channels) left = static_cast<std::size_t>(pixels) * channels;
    if (!head.is_text) {
        out.reserve(out.size() + 2 * left);
        for (; left > 0; --left) put(std::to_integer<std::uint32_t>(file[at++]));
        return out;
    }
    Numbers numbers([&]() -> std::optional<unsigned char> {
        if (at >= file.size()) return std::nullopt;
        return std::to_integer<unsigned char>(file[at++]);
    });
    for (; left > 0; --left) {
        const auto sample = numbers.take();
        if (!sample) break;
        put(*sample);
    }
    return out;
}

}  // namespace occam
