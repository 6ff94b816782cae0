// The checked arguments of a sample's command line: a folder, then numbers.
#pragma once

#include <occam/occam.h>

#include <charconv>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sample {

/// Reads positional arguments in their order. Throws occam::Error for an argument that looks like an option, is not a
/// number, or is one too many.
class Arguments {
public:
    Arguments(int argc, char** argv) : words_(argv + 1, argv + argc) {}

    /// Returns true if help was asked for, after printing the usage.
    bool wants_help(const char* usage) const
    {
        for (const std::string_view word : words_)
            if (word == "--help" || word == "-h") {
                std::printf("usage: %s\n", usage);
                return true;
            }
        return false;
    }
    bool has_more() const noexcept { return next_ < words_.size(); }
    /// Returns the next argument, or `otherwise` if there is none.
    std::filesystem::path path(const char* otherwise)
    {
        if (!has_more()) return otherwise;
        const std::string_view word = words_[next_++];
        if (word.empty() || word[0] == '-') throw occam::Error("", "there is no such option (--help)", std::string(word));
        return word;
    }
    /// Returns the next argument. Throws occam::Error if there is none.
    std::filesystem::path required_path(const char* name)
    {
        if (!has_more()) throw occam::Error("", std::string(name) + " is missing (--help)");
        return path("");
    }
    /// Returns the next argument as a number from `least` to `most`, or `otherwise` if there is none.
    int number(const char* name, int least, int most, int otherwise)
    {
        if (!has_more()) return otherwise;
        const std::string_view word = words_[next_++];
        int value = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc() || end != word.data() + word.size() || value < least || value > most)
            throw occam::Error("",
                               std::string(name) + " must be a number from " + std::to_string(least) + " to " +
                                   std::to_string(most) + " (--help)",
                               std::string(word));
        return value;
    }
    /// Reads WIDTH HEIGHT: both or neither.
    void size(int& width, int& height)
    {
        if (!has_more()) return;
        width = number("WIDTH", 1, 16384, width);
        if (!has_more()) throw occam::Error("", "HEIGHT is missing (--help)");
        height = number("HEIGHT", 1, 16384, height);
    }
    void end() const
    {
        if (has_more()) throw occam::Error("", "one word too many (--help)", std::string(words_[next_]));
    }

private:
    std::vector<std::string_view> words_;
    std::size_t next_ = 0;
};

}  // namespace sample
