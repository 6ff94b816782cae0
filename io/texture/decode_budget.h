// A limit to the work of decoding all images of a scene: each of them may be within its own limits while together they would
// take minutes, though their files are small.
#pragma once

#include <cstdint>

namespace occam {

/// Counts texels that the scans of JPEG files visit and bytes of decoded texels. Of both, a number is always allowed, and
/// beyond it as many as ordinary files of that size hold.
class DecodeBudget {
public:
    static constexpr std::uintmax_t kAlwaysAllowedBytes = std::uintmax_t(1) << 32, kMostBytesPerByte = 256;
    /// One scan visits up to half a billion texels a second. An ordinary progressive file has ten scans.
    static constexpr std::uintmax_t kAlwaysScanned = std::uintmax_t(1) << 32, kMostScannedPerByte = 512;

    /// Each returns whether an image of a file of `file_bytes` bytes is still allowed; one that is not takes nothing.
    bool takes_scans(std::uintmax_t scanned_texels, std::uintmax_t file_bytes) noexcept
    {
        return scans_.takes(scanned_texels, file_bytes, kAlwaysScanned, kMostScannedPerByte);
    }
    bool takes_bytes(std::uintmax_t decoded_bytes, std::uintmax_t file_bytes) noexcept
    {
        return bytes_.takes(decoded_bytes, file_bytes, kAlwaysAllowedBytes, kMostBytesPerByte);
    }

    /// Returns whether so much work is allowed for files of so many bytes in all.
    static bool allows_bytes(std::uintmax_t decoded_bytes, std::uintmax_t file_bytes) noexcept
    {
        return DecodeBudget().takes_bytes(decoded_bytes, file_bytes);
    }

private:
    struct Sum {
        std::uintmax_t work = 0, file_bytes = 0;

        bool takes(std::uintmax_t more, std::uintmax_t bytes, std::uintmax_t always, std::uintmax_t per_byte) noexcept
        {
            const Sum then{work + more, file_bytes + bytes};
            if (then.work > always && then.work / per_byte > then.file_bytes) return false;
            *this = then;
            return true;
        }
    };
    Sum scans_, bytes_;
};

}  // namespace occam
