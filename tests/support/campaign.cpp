#include "tests/support/campaign.h"

#include <cstdlib>
#include <cstring>

namespace occam::test {

bool is_long()
{
    const char* value = std::getenv("OCCAM_LONG");
    return value && std::strcmp(value, "1") == 0;
}

std::uint64_t number_from(const char* variable, std::uint64_t otherwise)
{
    const char* text = std::getenv(variable);
    return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

std::uint64_t rays_of_a_campaign() { return number_from("OCCAM_CAMPAIGN_RAYS", 1'000'000); }
std::uint64_t rays_per_cage() { return is_long() ? rays_of_a_campaign() : 16'000; }
std::uint64_t blended_rays_per_place() { return is_long() ? rays_of_a_campaign() / 8 : 8'000; }

}  // namespace occam::test
