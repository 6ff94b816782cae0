#include "io/hdr_note.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

namespace occam {
namespace {

constexpr std::string_view kNoteLine = "#occam:note ", kMore = "#occam:more ";

std::string comment_of(std::string_view note)
{
    std::string comment;
    std::size_t lines = 0;
    for (bool has_more = !note.empty(); has_more && lines < kMostHdrNoteLines;) {
        const std::size_t end = std::min(note.find('\n'), note.size());
        std::string_view rest = note.substr(0, end), begin = kNoteLine;
        do {
            comment.append(begin).append(rest.substr(0, kHdrNoteLine)).push_back('\n');
            rest.remove_prefix(std::min(rest.size(), kHdrNoteLine));
            begin = kMore;
        } while (++lines < kMostHdrNoteLines && !rest.empty());
        has_more = end < note.size();
        note.remove_prefix(std::min(end + 1, note.size()));
    }
    return comment;
}

}  // namespace

HdrNoteBytes::HdrNoteBytes(PictureBytes& to, const std::string& note) : to_(to), comment_(comment_of(note)) {}

void HdrNoteBytes::write_at(const void* bytes, std::size_t size, std::uint64_t offset) noexcept
{
    const char* next = static_cast<const char*>(bytes);
    if (first_line_ == 0) {
        const void* end = std::memchr(next, '\n', size);
        if (!end) return to_.write_at(next, size, offset);
        first_line_ = offset + static_cast<std::uint64_t>(static_cast<const char*>(end) - next) + 1;
        to_.write_at(comment_.data(), comment_.size(), first_line_);
    }
    if (offset < first_line_) {
        const std::size_t before = std::min(size, static_cast<std::size_t>(first_line_ - offset));
        to_.write_at(next, before, offset);
        next += before, size -= before, offset += before;
    }
    if (size > 0) to_.write_at(next, size, offset + comment_.size());
}

std::size_t HdrNoteBytes::read_at(void* bytes, std::size_t size, std::uint64_t offset) const noexcept
{
    if (first_line_ == 0) return to_.read_at(bytes, size, offset);
    if (offset >= first_line_) return to_.read_at(bytes, size, offset + comment_.size());
    return to_.read_at(bytes, std::min(size, static_cast<std::size_t>(first_line_ - offset)), offset);
}

std::string hdr_note(ImageBytes& file)
{
    constexpr std::uintmax_t kMostHead = 16384;
    std::vector<unsigned char> head(static_cast<std::size_t>(std::min(file.size(), kMostHead)));
    if (!file.read(0, head)) return {};
    std::string_view rest(reinterpret_cast<const char*>(head.data()), head.size());
    std::string note;
    bool has_note = false;
    for (std::size_t end = 0; (end = rest.find('\n')) != std::string_view::npos; rest.remove_prefix(end + 1)) {
        const std::string_view line = rest.substr(0, end);
        if (line.empty()) break;  // the end of the head
        if (line.starts_with(kNoteLine)) {
            if (std::exchange(has_note, true)) note.push_back('\n');
            note.append(line.substr(kNoteLine.size()));
        } else if (line.starts_with(kMore)) {
            note.append(line.substr(kMore.size()));
        }
    }
    return note;
}

}  // namespace occam
