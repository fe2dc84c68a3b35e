#pragma once
#include <numbers>

/// Factors between the units of files and the command line (degrees, mm, µm, nm) and those inside (radians, metres).
namespace scatmap {

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;
inline constexpr double kMetrePerMm = 1e-3;
inline constexpr double kMetrePerUm = 1e-6;
inline constexpr double kMetrePerNm = 1e-9;
inline constexpr double kLn10 = std::numbers::ln10;

}  // namespace scatmap
