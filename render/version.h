// The engine's version, in one place: CMakeLists.txt says the same (a test compares).
#pragma once

namespace occam::render {

inline constexpr const char* kVersion = "0.1.0";

}  // namespace occam::render
