// The memory that the lists of a cage take, by which copies of it are charged.
#pragma once

#include <cstddef>

#include "scenegraph/cage.h"

namespace occam::import {

/// Returns the bytes of the cage and of all its lists, those of each morph target and texture set included.
std::size_t bytes_of(const Cage& cage);

}  // namespace occam::import
