#pragma once
#include "calib/export_poni.h"
#include "scatmap/angles/instrument.h"

namespace scatmap::calib {

/// The instrument whose detector, at a pose, lies where a .poni file puts it: the way back from poni_at_spot, exact.
/// Pixel pitch, distance, offset and rotation of the detector come from the file, its size too where the file states
/// one; flips, arm, stage, beam, sample and sensor from `like`. Its calibration is dropped: it described another
/// detector. The file's 2theta and chi must be those that poni_at_spot gives the flips of `like`.
/// @throws Error if the sizes differ, the detector would not face the sample, or `like` has a lens
Instrument instrument_from_poni(const Poni& poni, const Instrument& like, const Pose& pose);

}  // namespace scatmap::calib
