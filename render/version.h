// The version of the engine. CMakeLists.txt says the same (a test compares the two).
#pragma once

namespace occam::render {

inline constexpr const char* kVersion = "0.1.0";

}  // namespace occam::render
