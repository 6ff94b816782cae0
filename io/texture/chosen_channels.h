// A picture whose channels are some of those that a library's reader gives.
#pragma once

#include <memory>
#include <vector>

#include "io/picture_codec.h"

namespace occam {

/// Says what a file says of its channels and the library does not heed.
struct ChannelChoice {
    std::vector<int> channels;  ///< those that are colours or alpha, in this order; empty: all of them
    bool are_inverted = false;  ///< a value of 0 is white, so colours are what is missing to 1
    bool operator==(const ChannelChoice&) const = default;
};

/// Returns a reader of the chosen channels. Those that the picture does not have are left out, and if none is left, or the
/// choice says nothing, it is the reader itself. Of two or four channels that are chosen the last is alpha.
std::unique_ptr<PictureReader> with_chosen_channels(std::unique_ptr<PictureReader> reader, const ChannelChoice& choice);

}  // namespace occam
