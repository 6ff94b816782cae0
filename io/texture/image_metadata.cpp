#include "io/texture/image_metadata.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

namespace occam {

namespace {

// Goes through a file and moves what it keeps to the front.
class Sieve {
public:
    explicit Sieve(std::vector<std::byte>& file) : file_(file) {}

    std::size_t left() const noexcept { return file_.size() - at_; }
    /// Returns the byte `ahead` of the current position; 0 beyond the end.
    std::uint32_t byte(std::size_t ahead) const noexcept
    {
        return ahead < left() ? std::to_integer<std::uint32_t>(file_[at_ + ahead]) : 0;
    }
    std::uint32_t big_endian(std::size_t ahead, std::size_t count) const noexcept
    {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < count; ++i) value = value << 8 | byte(ahead + i);
        return value;
    }
    void skip(std::size_t bytes) noexcept { at_ += std::min(bytes, left()); }
    void keep(std::size_t bytes)
    {
        const std::size_t count = std::min(bytes, left());
        if (kept_ != at_ && count > 0) std::memmove(&file_[kept_], &file_[at_], count);
        kept_ += count;
        skip(count);
    }
    void finish() { file_.resize(kept_); }

private:
    std::vector<std::byte>& file_;
    std::size_t at_ = 0, kept_ = 0;
};

// Keeps the critical chunks, which an upper-case first letter marks (PNG, sec. 5.4), and tRNS, the only other one that
// changes texels.
void remove_png_metadata(std::vector<std::byte>& file)
{
    constexpr std::uint32_t kLowerCase = 0x20, kTransparency = 0x74524e53;
    constexpr std::size_t kMagic = 8, kAround = 12;
    Sieve sieve(file);
    sieve.keep(kMagic);
    while (sieve.left() > 0) {
        const std::size_t size = kAround + sieve.big_endian(0, 4);
        if ((sieve.byte(4) & kLowerCase) != 0 && sieve.big_endian(4, 4) != kTransparency) sieve.skip(size);
        else sieve.keep(size);
    }
    sieve.finish();
}

// Leaves out application segments and comments before the first scan (JPEG: ITU T.81, annex B), except those of JFIF and
// Adobe, which say what the components are.
void remove_jpeg_metadata(std::vector<std::byte>& file)
{
    constexpr std::uint32_t kApp0 = 0xe0, kApp14 = 0xee, kApp15 = 0xef, kComment = 0xfe, kScan = 0xda;
    Sieve sieve(file);
    sieve.keep(2);
    while (sieve.left() > 4 && sieve.byte(0) == 0xff && sieve.byte(1) != kScan) {
        const std::uint32_t marker = sieve.byte(1);
        const bool is_bare = marker == 0xff || marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8);
        const std::size_t size = marker == 0xff ? 1 : is_bare ? 2 : 2 + sieve.big_endian(2, 2);
        const bool describes = (marker > kApp0 && marker <= kApp15 && marker != kApp14) || marker == kComment;
        if (describes) sieve.skip(size);
        else sieve.keep(size);
    }
    sieve.keep(sieve.left());
    sieve.finish();
}

// The first directory of a TIFF in memory (TIFF 6.0, sec. 2), or of a BigTIFF, in which numbers of entries, counts and
// places have eight bytes. A file of another version is left alone.
class TiffDirectory {
public:
    explicit TiffDirectory(std::vector<std::byte>& file)
        : file_(file), is_little_(!file.empty() && file[0] == std::byte('I'))
    {
        constexpr std::size_t kClassic = 42, kBig = 43;
        const std::size_t version = file.size() < 16 ? 0 : number(2, 2);
        if (version != kClassic && version != kBig) return;
        is_big_ = version == kBig;
        if (number(head(), word()) > file.size() - size_of_count()) return;
        begin_ = number(head(), word());
        const std::size_t declared = number(begin_, size_of_count()),
                          fitting = (file.size() - begin_ - size_of_count()) / entry();
        count_ = std::min(declared, fitting);
        is_whole_ = declared <= fitting && file.size() - end() >= word();
    }

    void rename_metadata()
    {
        constexpr std::array<std::size_t, 6> kDescribing = {700, 33723, 34377, 34665, 34675, 37724};
        for (std::size_t at = first(); at < end(); at += entry())
            if (std::find(kDescribing.begin(), kDescribing.end(), number(at, 2)) != kDescribing.end())
                file_[at] = file_[at + 1] = std::byte{0xfd};
    }

    // A file of one bit a sample need not say so, but OpenImageIO takes it as one of eight. A directory that does is put
    // behind the end of the file.
    void write_default_bits()
    {
        constexpr std::size_t kBitsPerSample = 258, kSamplesPerPixel = 277, kMost = 0xffff0000;
        if (!is_whole_ || has(kBitsPerSample) || has(kSamplesPerPixel, 2) || (!is_big_ && file_.size() > kMost)) return;
        std::vector<std::byte> entries;
        const auto copy = [&](std::size_t from, std::size_t to) {
            entries.insert(entries.end(), file_.begin() + std::ptrdiff_t(from), file_.begin() + std::ptrdiff_t(to));
        };
        std::size_t next = first();
        while (next < end() && number(next, 2) < kBitsPerSample) next += entry();
        copy(first(), next);
        const std::size_t at = entries.size();
        entries.resize(at + entry());
        copy(next, end() + word());
        put(entries, at, kBitsPerSample, 2);
        put_short(entries, at, 1);
        file_.resize((file_.size() + word() - 1) / word() * word());
        put(file_, head(), file_.size(), word());
        file_.resize(file_.size() + size_of_count());
        put(file_, file_.size() - size_of_count(), count_ + 1, size_of_count());
        file_.insert(file_.end(), entries.begin(), entries.end());
    }

    // Returns the value of the tag and sets it to the usual one.
    std::size_t take_orientation()
    {
        constexpr std::size_t kOrientation = 274, kUsual = 1;
        for (std::size_t at = first(); at < end(); at += entry()) {
            if (number(at, 2) != kOrientation) continue;
            const std::size_t type = number(at + 2, 2), bytes = type == kByte    ? 1
                                                                : type == kShort ? 2
                                                                : type == kLong  ? 4
                                                                                 : 0;
            const std::size_t value = bytes == 0 ? kUsual : number(value_of(at), bytes);
            put_short(file_, at, kUsual);
            return value;
        }
        return kUsual;
    }

    TiffPixels pixels() const
    {
        constexpr std::size_t kBitsPerSample = 258, kPhotometric = 262, kSamplesPerPixel = 277, kExtraSamples = 338;
        constexpr std::size_t kAssociated = 1, kUnassociated = 2;
        TiffPixels pixels{.kind = short_of(kPhotometric, 0, 1), .bits = short_of(kBitsPerSample, 0, 1)};
        pixels.samples = short_of(kSamplesPerPixel, 0, 1);
        const Shorts extra = shorts_of(kExtraSamples);
        for (; pixels.extra < pixels.samples && short_at(extra, pixels.extra, kNothing) != kNothing; ++pixels.extra) {
            const std::size_t kind = short_at(extra, pixels.extra, kNothing);
            if (pixels.alpha || (kind != kAssociated && kind != kUnassociated)) continue;
            pixels.alpha = pixels.extra;
            pixels.is_multiplied = kind == kAssociated;
        }
        return pixels;
    }

private:
    static constexpr std::size_t kByte = 1, kShort = 3, kLong = 4;  // types of values
    static constexpr std::size_t kNothing = 0x10000;                // larger than any number of 16 bits

    std::size_t word() const { return is_big_ ? 8 : 4; }  // the size of a place in the file and of a count of values
    std::size_t head() const { return is_big_ ? 8 : 4; }  // where the head says where the directory is
    std::size_t size_of_count() const { return is_big_ ? 8 : 2; }
    std::size_t entry() const { return 4 + 2 * word(); }
    std::size_t first() const { return begin_ + size_of_count(); }
    std::size_t end() const { return first() + count_ * entry(); }
    std::size_t value_of(std::size_t at) const { return at + 4 + word(); }
    std::size_t place(std::size_t i, std::size_t bytes) const { return is_little_ ? bytes - 1 - i : i; }
    std::size_t number(std::size_t at, std::size_t bytes) const
    {
        std::size_t value = 0;
        for (std::size_t i = 0; i < bytes; ++i)
            value = value << 8 | std::to_integer<std::size_t>(file_[at + place(i, bytes)]);
        return value;
    }
    void put(std::vector<std::byte>& to, std::size_t at, std::size_t value, std::size_t bytes) const
    {
        for (std::size_t i = bytes; i-- > 0; value >>= 8) to[at + place(i, bytes)] = static_cast<std::byte>(value & 0xff);
    }
    // Makes one number of 16 bits the value of the entry at `at`.
    void put_short(std::vector<std::byte>& to, std::size_t at, std::size_t value) const
    {
        put(to, at + 2, kShort, 2);
        put(to, at + 4, 1, word());
        put(to, value_of(at), value, 2);
    }
    // Says where the numbers of 16 bits are that are the value of a tag, and how many there are.
    struct Shorts {
        std::size_t at = 0, count = 0;
    };
    // Walks the whole directory, which may be long.
    Shorts shorts_of(std::size_t tag) const
    {
        for (std::size_t at = first(); at < end(); at += entry()) {
            if (number(at, 2) != tag || number(at + 2, 2) != kShort) continue;
            const std::size_t count = number(at + 4, word());
            return {count <= word() / 2 ? value_of(at) : number(value_of(at), word()), count};
        }
        return {};
    }
    std::size_t short_at(const Shorts& list, std::size_t index, std::size_t otherwise) const
    {
        if (index >= list.count || list.at > file_.size() - 2 || 2 * index > file_.size() - 2 - list.at) return otherwise;
        return number(list.at + 2 * index, 2);
    }
    std::size_t short_of(std::size_t tag, std::size_t index, std::size_t otherwise) const
    {
        return short_at(shorts_of(tag), index, otherwise);
    }
    // Returns whether there is an entry of that tag, with a value of `least` or more.
    bool has(std::size_t tag, std::size_t least = 0) const
    {
        for (std::size_t at = first(); at < end(); at += entry())
            if (number(at, 2) == tag && number(value_of(at), 2) >= least) return true;
        return false;
    }

    std::vector<std::byte>& file_;
    bool is_little_, is_big_ = false, is_whole_ = false;
    std::size_t begin_ = 0, count_ = 0;
};

// Gives descriptive entries of the first directory a tag number that no reader knows.
void remove_tiff_metadata(std::vector<std::byte>& file)
{
    TiffDirectory directory(file);
    directory.rename_metadata();
    directory.write_default_bits();
}

}  // namespace

void remove_metadata(std::vector<std::byte>& file, std::string_view format)
{
    if (format == "png") remove_png_metadata(file);
    if (format == "jpeg") remove_jpeg_metadata(file);
    if (format == "tiff") remove_tiff_metadata(file);
}

Orientation take_tiff_orientation(std::vector<std::byte>& file)
{
    return orientation_of(TiffDirectory(file).take_orientation());
}

TiffPixels pixels_of_tiff(std::vector<std::byte>& file) { return TiffDirectory(file).pixels(); }

}  // namespace occam
