// Large scene files for the importers: a field of waves of columns x rows quads with texture coordinates.
#pragma once

#include <filesystem>

namespace occam::bench {

/// Writes quads without normals. Throws Error.
void write_wave_obj(const std::filesystem::path& file, int columns, int rows);
inline constexpr int kWaveColumns = 1000, kWaveRows = 500;  ///< 500,000 faces

/// Writes two triangles for each quad, with normals and 32-bit indices. Throws Error.
void write_wave_glb(const std::filesystem::path& file, int columns, int rows);

/// Writes two triangles for each quad to a binary STL file, which has each corner's position and joins none. Throws Error.
void write_wave_stl(const std::filesystem::path& file, int columns, int rows);

}  // namespace occam::bench
