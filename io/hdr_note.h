// The note in the head of a Radiance HDR file, which the library for all formats neither writes nor reads.
//
// It stands in comment lines, which programs skip, after the first line of the file: one that begins with "#occam:note " for
// each line of the note, and those with "#occam:more " continue a long one.
#pragma once

#include <cstddef>
#include <string>

#include "io/picture_codec.h"
#include "io/texture/image_header.h"

namespace occam {

/// A line of a note that is longer than kHdrNoteLine bytes takes several lines of the head.
inline constexpr std::size_t kMostHdrNoteLines = 32, kHdrNoteLine = 64;  // OpenImageIO reads 100 lines of 127 bytes

/// Hands the bytes of an encoder on, and puts the note behind the first line of what it writes. Libraries read few lines of
/// a head, and short ones, so no more of a note is kept than kMostHdrNoteLines.
class HdrNoteBytes final : public PictureBytes {
public:
    HdrNoteBytes(PictureBytes& to, const std::string& note);

    void write_at(const void* bytes, std::size_t size, std::uint64_t offset) noexcept override;
    std::size_t read_at(void* bytes, std::size_t size, std::uint64_t offset) const noexcept override;
    std::uint64_t size() const noexcept override { return to_.size() - (first_line_ > 0 ? comment_.size() : 0); }

private:
    PictureBytes& to_;
    std::string comment_;
    std::uint64_t first_line_ = 0;  ///< its length; 0: its end is not written yet
};

/// Returns the note of a Radiance file; empty if it has none.
std::string hdr_note(ImageBytes& file);

}  // namespace occam
