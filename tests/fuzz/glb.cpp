// The input is a GLB, or JSON, a zero byte and the binary chunk, to which the container is added: mutations that would break
// its lengths then reach what is inside.
#include "tests/fuzz/door.h"

namespace {

void append_u32(std::string& to, std::size_t value)
{
    for (int shift = 0; shift < 32; shift += 8) to += static_cast<char>(value >> shift & 0xff);
}

std::string with_container(std::string_view json, std::string_view binary)
{
    const auto padded = [](std::size_t size) { return (size + 3) / 4 * 4; };
    std::string glb = "glTF";
    append_u32(glb, 2);
    append_u32(glb, 12 + 8 + padded(json.size()) + 8 + padded(binary.size()));
    const auto append_chunk = [&](const char* type, std::string_view bytes, char filler) {
        append_u32(glb, padded(bytes.size()));
        glb.append(type, 4);
        glb.append(bytes);
        glb.append(padded(bytes.size()) - bytes.size(), filler);
    };
    append_chunk("JSON", json, ' ');
    append_chunk("BIN", binary, '\0');
    return glb;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    const std::string_view bytes = occam::fuzz::text_of(data, size);
    const std::size_t zero = bytes.find('\0');
    const bool is_whole = bytes.starts_with("glTF") || zero == std::string_view::npos;
    occam::fuzz::write_file("scene.glb",
                            is_whole ? std::string(bytes) : with_container(bytes.substr(0, zero), bytes.substr(zero + 1)));
    occam::fuzz::pass_door("scene.glb", bytes);
    return 0;
}
