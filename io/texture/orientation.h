// How the rows of an image file lie in the picture.
#pragma once

#include <cstddef>
#include <iterator>

namespace occam {

/// A file has its rows in one order and the columns of each in another.
struct Orientation {
    bool mirrors_rows = false;     ///< the rows run from the bottom, or from the right if they are columns of the picture
    bool mirrors_columns = false;  ///< the columns run from the right, or from the bottom if they are rows of the picture
    bool swaps_axes = false;       ///< the file's rows are columns of the picture, and its columns are rows
};

/// Returns what a number of the tag Orientation (TIFF 6.0, sec. 8; Exif has the same) says; numbers that it does not have
/// count as 1.
inline Orientation orientation_of(std::size_t number) noexcept
{
    constexpr Orientation kFromOne[] = {{},
                                        {false, true, false},
                                        {true, true, false},
                                        {true, false, false},
                                        {false, false, true},
                                        {true, false, true},
                                        {true, true, true},
                                        {false, true, true}};
    return number >= 1 && number <= std::size(kFromOne) ? kFromOne[number - 1] : Orientation();
}

}  // namespace occam
