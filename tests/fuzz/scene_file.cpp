// The input is a scene of one file in the format of OCCAM_FUZZ_FILE.
#include "tests/fuzz/door.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    const std::string_view bytes = occam::fuzz::text_of(data, size);
    occam::fuzz::write_file(OCCAM_FUZZ_FILE, bytes);
    occam::fuzz::pass_door(OCCAM_FUZZ_FILE, bytes);
    return 0;
}
