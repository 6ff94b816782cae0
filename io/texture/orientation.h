// How the rows of an image file lie in the picture.
#pragma once

namespace occam {

/// A file has its rows in one order and the columns of each in another.
struct Orientation {
    bool mirrors_rows = false;     ///< the rows run from the bottom, or from the right if they are columns of the picture
    bool mirrors_columns = false;  ///< the columns run from the right, or from the bottom if they are rows of the picture
    bool swaps_axes = false;       ///< the file's rows are columns of the picture, and its columns are rows
};

}  // namespace occam
