// A position in a text of numbers and words, which never leaves the text. Lines end with LF, CR LF or CR alone.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "base/number_in.h"

namespace occam::import {

class TextCursor {
public:
    explicit TextCursor(std::string_view text, char comment = '\0') : text_(text), comment_(comment) {}

    std::size_t left() const noexcept { return text_.size() - at_; }
    std::size_t line() const noexcept { return line_; }
    bool is_at_end() { return skip_space(), at_ == text_.size(); }

    /// Returns the next word, also from a later line; empty at the end.
    std::string_view word()
    {
        skip_space();
        const std::size_t begin = at_;
        while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
        return text_.substr(begin, at_ - begin);
    }
    /// Returns the next word as a number; none if it is something else, or too large. What is too small is 0.
    std::optional<double> number()
    {
        skip_space();
        const char *begin = text_.data() + at_, *end = text_.data() + text_.size();
        if (begin != end && *begin == '+') ++begin;
        double value = 0;
        const auto [after, error] = read_number(begin, end, value);
        if (error != std::errc() || (after != end && !is_space(*after))) return std::nullopt;
        at_ = static_cast<std::size_t>(after - text_.data());
        return value;
    }
    /// Returns what is wrong with the next word, of which number() made none.
    const char* why_no_number() const
    {
        double value = 0;
        const std::string_view left = text_.substr(text_.substr(at_).starts_with('+') ? at_ + 1 : at_);
        const bool is_too_large = read_number(left.data(), left.data() + left.size(), value).ec ==
                                  std::errc::result_out_of_range;
        return is_too_large ? "a number is too large" : "a number is missing or malformed";
    }
    /// Reads the words up to the end of this line; returns how many there are, of which `words` holds the first ones.
    std::size_t rest_of_line(std::span<std::string_view> words)
    {
        std::size_t count = 0;
        for (;;) {
            while (at_ < text_.size() && !is_line_end(text_[at_]) && is_space(text_[at_])) ++at_;
            if (at_ == text_.size() || is_line_end(text_[at_])) return count;
            if (comment_ != '\0' && text_[at_] == comment_) return skip_line(), count;
            const std::string_view next = word();
            if (count < words.size()) words[count] = next;
            ++count;
        }
    }
    /// Goes to the end of this line, but not behind it.
    void skip_line()
    {
        while (at_ < text_.size() && !is_line_end(text_[at_])) ++at_;
    }

private:
    static bool is_line_end(char c) noexcept { return c == '\n' || c == '\r'; }
    static bool is_space(char c) noexcept
    {
        return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == '\v' || c == '\f';
    }
    void skip_space()
    {
        while (at_ < text_.size()) {
            if (comment_ != '\0' && text_[at_] == comment_) {
                skip_line();
                continue;
            }
            if (!is_space(text_[at_])) return;
            const char c = text_[at_++];
            if (c == '\n' || (c == '\r' && !text_.substr(at_).starts_with('\n'))) ++line_;
        }
    }

    std::string_view text_;
    std::size_t at_ = 0, line_ = 1;
    char comment_;
};

}  // namespace occam::import
