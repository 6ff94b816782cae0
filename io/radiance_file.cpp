#include "io/radiance_file.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

namespace occam {
namespace {

constexpr int kMostHeaderLines = 256;
constexpr std::size_t kLongestLine = 4096;
// Rows of other lengths than these are not compressed.
constexpr int kLeastRun = 8, kMostRun = 0x7fff;

// Reads up to the end of a line, or returns false if the line is too long or not there.
bool take_line(std::istream& in, std::string& line)
{
    line.clear();
    for (char c; in.get(c);) {
        if (c == '\n') return true;
        if (line.size() == kLongestLine) return false;
        line += c;
    }
    return false;
}

// Reads the header of a file of the usual kind and leaves the stream where the rows begin. Returns false for others.
bool take_header(std::istream& in, int& width, int& height)
{
    std::string line;
    if (!take_line(in, line) || !line.starts_with("#?")) return false;
    bool is_rgbe = false;
    for (int i = 0; i < kMostHeaderLines && take_line(in, line); ++i) {
        if (line.empty()) {
            int end = 0;
            return is_rgbe && take_line(in, line) &&
                   std::sscanf(line.c_str(), "-Y %6d +X %6d%n", &height, &width, &end) == 2 &&
                   static_cast<std::size_t>(end) == line.size() && width > 0 && height > 0;
        }
        if (line == "FORMAT=32-bit_rle_rgbe") is_rgbe = true;
        else if (!line.starts_with('#') && !line.starts_with("SOFTWARE=")) return false;
    }
    return false;
}

class RadianceReader final : public PictureReader {
public:
    RadianceReader(std::ifstream&& in, int width, int height) : in_(std::move(in)), rows_begin_(in_.tellg())
    {
        spec_.width = spec_.full_width = width;
        spec_.height = spec_.full_height = height;
        spec_.channels = {"R", "G", "B"};
    }

    const PictureSpec& spec() const noexcept override { return spec_; }
    std::string format() const override { return "hdr"; }
    std::string text_attribute(const std::string&) const override { return {}; }
    bool read_rows(int, int, int, std::uint8_t*) override
    {
        error_ = "its values are not bytes";
        return false;
    }
    bool read_rows(int y_begin, int y_end, int channels, float* to) override
    {
        if (y_begin < next_row_) {
            in_.clear();
            in_.seekg(rows_begin_);
            next_row_ = 0;
        }
        for (; next_row_ < y_end; ++next_row_) {
            if (!take_row()) {
                error_ = "row " + std::to_string(next_row_) + " is cut off or damaged";
                return false;
            }
            if (next_row_ < y_begin) continue;
            for (const Texel& texel : row_) {
                const float unit = std::ldexp(1.0f, texel[3] - (128 + 8));
                for (int c = 0; c < channels; ++c)
                    *to++ = texel[3] == 0 ? 0.0f : static_cast<float>(texel[static_cast<std::size_t>(c)]) * unit;
            }
        }
        return true;
    }
    std::string error() const override { return error_; }

private:
    using Texel = std::array<unsigned char, 4>;

    bool take_row()
    {
        const auto width = static_cast<std::size_t>(spec_.width);
        row_.resize(width);
        Texel first{};
        if (!take(first.data(), first.size())) return false;
        const bool is_compressed = spec_.width >= kLeastRun && spec_.width <= kMostRun && first[0] == 2 && first[1] == 2 &&
                                   (first[2] & 0x80) == 0;
        if (!is_compressed) {
            row_[0] = first;
            return take(row_[0].data() + first.size(), (width - 1) * sizeof(Texel));
        }
        if ((first[2] << 8 | first[3]) != spec_.width) return false;
        for (std::size_t c = 0; c < first.size(); ++c)
            if (!take_runs(c)) return false;
        return true;
    }
    // Reads one of the four values of a compressed row.
    bool take_runs(std::size_t channel)
    {
        for (std::size_t x = 0; x < row_.size();) {
            const int code = in_.get();
            if (code == std::char_traits<char>::eof()) return false;
            const bool is_run = code > 128;
            const std::size_t length = static_cast<std::size_t>(is_run ? code - 128 : code);
            if (length == 0 || length > row_.size() - x) return false;
            unsigned char values[128];
            if (!take(values, is_run ? 1 : length)) return false;
            for (std::size_t i = 0; i < length; ++i) row_[x++][channel] = values[is_run ? 0 : i];
        }
        return true;
    }
    bool take(unsigned char* to, std::size_t size)
    {
        return static_cast<bool>(in_.read(reinterpret_cast<char*>(to), static_cast<std::streamsize>(size)));
    }

    std::ifstream in_;
    std::ifstream::pos_type rows_begin_;
    PictureSpec spec_;
    int next_row_ = 0;
    std::vector<Texel> row_;
    std::string error_;
};

}  // namespace

std::unique_ptr<PictureReader> open_radiance(const std::filesystem::path& file)
{
    std::ifstream in(file, std::ios::binary);
    int width = 0, height = 0;
    if (!take_header(in, width, height)) return nullptr;
    return std::make_unique<RadianceReader>(std::move(in), width, height);
}

}  // namespace occam
