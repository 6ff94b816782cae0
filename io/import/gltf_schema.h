// The schema of glTF 2.0 and of the extensions that we know, as a table: which object has which properties.
//
// After the JSON schemas of the specification (Khronos, 2021). Rules that involve more than one property
// are in gltf_rules.h.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

namespace occam::import {

struct Rule {
    enum class Kind : std::uint8_t {
        Object,     ///< detail: its type
        Objects,    ///< array of objects; detail: their type
        Index,      ///< detail: the array of the root that it points into
        Indices,    ///< array of those, none twice
        IndexMap,   ///< object of indices by name (attributes)
        IndexMaps,  ///< array of those (morph targets)
        Integer,    ///< low to high
        Number,     ///< low to high
        Positive,   ///< number above low
        Numbers,    ///< array of low to high numbers
        Boolean,
        String,
        Strings,
        Choice,  ///< detail: words with | before and after each
        Any
    };
    const char* object;
    const char* key;
    Kind kind;
    const char* detail = "";
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool is_required = false;
};

std::span<const Rule> gltf_schema();

}  // namespace occam::import
