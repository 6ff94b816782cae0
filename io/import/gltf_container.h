// The container of a glTF file: its JSON, and the binary chunk of a GLB, which stays on disk until a buffer needs it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/import/files.h"
#include "io/import/report.h"

namespace occam::import {

class GltfContainer {
public:
    /// Reads the JSON, and checks the header, chunk order and lengths of a GLB (glTF 2.0, sec. 4). Throws Error if the file
    /// cannot be read, is larger than 4 GiB, or breaks a rule of the container.
    explicit GltfContainer(const Report& report);

    bool is_glb() const noexcept { return is_glb_; }
    const std::string& json() const noexcept { return json_; }
    /// Throws Error if the binary chunk is shorter than `bytes`, or missing.
    void require_binary(std::size_t bytes) const;
    /// Returns the first `bytes` of the binary chunk. Throws the same errors as require_binary().
    std::vector<unsigned char> binary(std::size_t bytes) const;

private:
    void read_chunks();
    void require(bool holds, const char* rule) const;

    std::string name_;
    FileReader file_;
    bool is_glb_ = false;
    std::string json_;
    std::size_t binary_begin_ = 0, binary_bytes_ = 0;
};

}  // namespace occam::import
