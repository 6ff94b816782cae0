// The input is a material library, beside an OBJ that names it.
#include "tests/fuzz/door.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    constexpr const char* kObj =
        "mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n";
    const std::string_view bytes = occam::fuzz::text_of(data, size);
    occam::fuzz::write_file("scene.mtl", bytes);
    occam::fuzz::write_file("scene.obj", kObj);
    occam::fuzz::pass_door("scene.obj", bytes);
    return 0;
}
