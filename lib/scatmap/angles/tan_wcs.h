#pragma once
#include <array>

#include "scatmap/angles/pixel_plane.h"

namespace scatmap {

/// The FITS world coordinate system of a flat detector: gnomonic (TAN) projection from the illuminated spot, exact for
/// any pose. World coordinates are phi_s (first, deg, from −x) and 90° − theta_s (second, deg), so that any FITS viewer
/// shows the scatter angles under the cursor. Keywords: Calabretta & Greisen, A&A 395, 1077 (2002), with the generic
/// axis types SCLN/SCLT, LONPOLE = 180.
struct TanWcs {
  std::array<double, 2> crpix;              ///< foot of the perpendicular from the spot; FITS pixels, first = 1
  std::array<double, 2> crval_deg;          ///< phi_s and 90° − theta_s there
  std::array<std::array<double, 2>, 2> cd;  ///< deg per pixel: rows (longitude, latitude), columns (column, row)
  static constexpr double kLonPole_deg = 180;
};

TanWcs tan_wcs(const SampleView& view);

}  // namespace scatmap
