#include "base/printable.h"

#include <algorithm>
#include <cstddef>

namespace occam {
namespace {

constexpr std::size_t kMostKept = 2000, kHead = 1400, kTail = 500;

bool continues(char c) noexcept { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

// Returns the length of the character with which the text starts; 0 if it is a control character or no UTF-8.
std::size_t character_length(std::string_view text) noexcept
{
    const auto first = static_cast<unsigned char>(text[0]);
    if (first < 0x80) return first >= 0x20 && first != 0x7f;
    const std::size_t length = first >= 0xc2 && first < 0xe0 ? 2 : first >= 0xe0 && first < 0xf0 ? 3 : first < 0xf5 ? 4 : 0;
    if (first < 0xc2 || length == 0 || text.size() < length) return 0;
    if (!std::all_of(text.begin() + 1, text.begin() + std::ptrdiff_t(length), continues)) return 0;
    const auto second = static_cast<unsigned char>(text[1]);
    // The second byte tells overlong forms of three and four bytes, surrogates and what lies above U+10FFFF.
    if ((first == 0xe0 && second < 0xa0) || (first == 0xed && second >= 0xa0)) return 0;
    if ((first == 0xf0 && second < 0x90) || (first == 0xf4 && second >= 0x90)) return 0;
    // U+0080 to U+009F are control characters, and U+2028 and U+2029 end lines.
    if (first == 0xc2 && second < 0xa0) return 0;
    if (first == 0xe2 && second == 0x80 && (text[2] == '\xa8' || text[2] == '\xa9')) return 0;
    return length;
}

std::string shortened(std::string_view text)
{
    if (text.size() <= kMostKept) return std::string(text);
    std::size_t head = kHead, tail = text.size() - kTail;
    while (head > 0 && continues(text[head])) --head;
    while (tail < text.size() && continues(text[tail])) ++tail;
    return std::string(text.substr(0, head)).append(" [...] ").append(text.substr(tail));
}

}  // namespace

std::string printable_line(std::string_view given)
{
    std::string text = shortened(given);
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    std::string line;
    for (std::size_t i = 0; i < text.size();) {
        constexpr char kDigits[] = "0123456789abcdef";
        const std::size_t length = character_length(std::string_view(text).substr(i));
        const auto byte = static_cast<unsigned char>(text[i]);
        if (length > 0) line.append(text, i, length);
        else if (byte == '\t') line += ' ';
        else if (byte != '\n' && byte != '\r') line.append({'\\', 'x', kDigits[byte >> 4], kDigits[byte & 15]});
        else if (!line.ends_with("; ")) line += "; ";
        i += std::max<std::size_t>(length, 1);
    }
    return line;
}

}  // namespace occam
