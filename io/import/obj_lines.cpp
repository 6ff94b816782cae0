#include "io/import/obj_lines.h"

namespace occam::import {

namespace {

// Returns true for the first letter of a comment or of a statement with a name (usemtl, mtllib, o, g).
bool begins_name(char c) noexcept { return c == '#' || c == 'u' || c == 'm' || c == 'o' || c == 'g'; }

bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }

const char* past_blanks(const char* at, const char* end)
{
    while (at != end && is_blank(*at)) ++at;
    return at;
}
const char* past_digits(const char* at, const char* end)
{
    while (at != end && is_digit(*at)) ++at;
    return at;
}

NumberKind kind_of(std::string_view word)
{
    if (word.find(".#") != std::string_view::npos) return NumberKind::NotFinite;
    if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (end != word.data() + word.size() || error == std::errc::invalid_argument) return NumberKind::Malformed;
    return error == std::errc() && !std::isfinite(value) ? NumberKind::NotFinite : NumberKind::Finite;
}

// Returns where a whole number ends that fits into 32 bits, or none.
const char* past_index(const char* at, const char* end)
{
    const char* begin = at;
    if (at != end && (*at == '-' || *at == '+')) ++at;
    const char* digits = at;
    at = past_digits(at, end);
    if (at == digits) return nullptr;
    if (at - digits < 10) return at;
    int value = 0;
    return std::from_chars(*begin == '+' ? digits : begin, at, value).ec == std::errc() ? at : nullptr;
}

}  // namespace

bool ObjLines::next()
{
    if (!lines_.next()) return false;
    number_ = lines_.number();
    std::size_t begin = lines_.begin();
    while (begin < lines_.end() && is_blank(text_[begin])) ++begin;
    if (begin < lines_.end() && !begins_name(text_[begin])) {
        blank_comment(begin);
        while (lines_.end() > begin && text_[lines_.end() - 1] == '\\') {
            const std::size_t backslash = lines_.end() - 1, after = lines_.after();
            const bool is_last = !lines_.extend();
            std::fill(text_.begin() + std::ptrdiff_t(backslash), text_.begin() + std::ptrdiff_t(after), ' ');
            if (is_last) break;
            blank_comment(after);
        }
    }
    line_ = std::string_view(text_).substr(begin, lines_.end() - begin);
    return true;
}

void ObjLines::blank_comment(std::size_t from)
{
    for (std::size_t sign = sign_.from(from); sign < lines_.end(); sign = sign_.from(sign + 1)) {
        if (sign == 0 || !is_blank(text_[sign - 1])) continue;
        std::fill(text_.begin() + std::ptrdiff_t(sign), text_.begin() + std::ptrdiff_t(lines_.end()), ' ');
        return;
    }
}

NumberKind take_number(std::string_view& rest)
{
    const char* end = rest.data() + rest.size();
    const char* begin = past_blanks(rest.data(), end);
    if (begin == end) return NumberKind::Missing;
    // Nearly all numbers are digits with a sign and a point, which need not be converted.
    const char* digits = begin + (*begin == '-' ? 1 : 0);
    const char* at = past_digits(digits, end);
    bool is_plain = at != digits;
    if (at != end && *at == '.') {
        const char* point = at++;
        at = past_digits(at, end);
        is_plain |= at != point + 1;
    }
    is_plain &= at == end || is_blank(*at);
    while (at != end && !is_blank(*at)) ++at;
    rest.remove_prefix(static_cast<std::size_t>(at - rest.data()));
    return is_plain ? NumberKind::Finite : kind_of({begin, static_cast<std::size_t>(at - begin)});
}

std::optional<std::size_t> count_corners(std::span<char> rest)
{
    std::size_t corners = 0;
    const char* end = rest.data() + rest.size();
    for (const char* at = past_blanks(rest.data(), end); at != end; at = past_blanks(at, end)) {
        at = past_index(at, end);
        for (int slash = 0; slash < 2 && at && at != end && *at == '/'; ++slash) {
            ++at;
            if (at != end && *at != '/' && !is_blank(*at)) at = past_index(at, end);
        }
        if (!at || (at != end && !is_blank(*at))) return std::nullopt;
        for (char* last = rest.data() + (at - rest.data()); last[-1] == '/'; --last) last[-1] = ' ';
        ++corners;
    }
    return corners;
}

}  // namespace occam::import
