// The subdivision cages of the tests, made by code: closed ones of every kind, and open ones.
//
// A plain clone tests itself on these; the cages of the shared test data are tested beside them where that folder exists.
#pragma once

#include <string>
#include <vector>

#include "scenegraph/cage.h"

namespace occam::test {

/// Holds a cage, its name, and the kind of its surface.
struct MadeCage {
    std::string name;  ///< letters, digits and underscores
    Cage cage;
    bool is_closed = true;
};

/// Returns all made cages. Every closed one encloses a volume and winds counter-clockwise seen from outside.
std::vector<MadeCage> made_cages();

/// Returns the cage of that name. Throws std::out_of_range if there is none.
Cage made_cage(const std::string& name);

}  // namespace occam::test
