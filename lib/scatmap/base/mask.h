#pragma once
#include <array>
#include <cstdint>

namespace scatmap {

/// Why a pixel is not good; 0 is a good pixel. Bits combine. The same bits stand in every map's MASK extension, whose
/// header lists them from `kMaskFlags`.
using Mask = std::uint16_t;

inline constexpr Mask kSaturated = 1u << 0;       ///< raw counts at or above saturation in every usable exposure
inline constexpr Mask kBloom = 1u << 1;           ///< touches a saturated pixel (charge spills along columns)
inline constexpr Mask kHot = 1u << 2;             ///< dark level or dark scatter far above the sensor's
inline constexpr Mask kBad = 1u << 3;             ///< listed in bad_pixels
inline constexpr Mask kFlatInvalid = 1u << 4;     ///< flat field not finite or not positive there
inline constexpr Mask kCosmic = 1u << 5;          ///< no frame left after rejecting outliers among frames
inline constexpr Mask kBelowHorizon = 1u << 6;    ///< theta_s >= 90 degrees
inline constexpr Mask kBehindDetector = 1u << 7;  ///< light would arrive from behind the detector plane
inline constexpr Mask kNoData = 1u << 8;          ///< no exposure gives a finite value

struct MaskFlag {
  Mask bit;
  const char* name;
  const char* meaning;
};

/// Every flag, in bit order.
inline constexpr std::array<MaskFlag, 9> kMaskFlags{{
    {kSaturated, "SATURATED", "raw counts at or above saturation"},
    {kBloom, "BLOOM", "touches a saturated pixel"},
    {kHot, "HOT", "hot or unstable in the darks"},
    {kBad, "BAD", "listed in bad_pixels"},
    {kFlatInvalid, "FLAT", "flat field not positive"},
    {kCosmic, "COSMIC", "rejected as outlier in all frames"},
    {kBelowHorizon, "HORIZON", "theta_s at or beyond 90 deg"},
    {kBehindDetector, "BEHIND", "behind the detector plane"},
    {kNoData, "NODATA", "no finite value"},
}};

}  // namespace scatmap
