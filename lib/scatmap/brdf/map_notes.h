#pragma once
#include <string>

#include "scatmap/brdf/from_frames.h"
#include "scatmap/brdf/signature_exposures.h"

/// What the user should hear of a map besides its numbers: each adds to map.notes what there is to say.
namespace scatmap {

/// Darks whose scatter is not that of the stated read noise. @param pooled_dark_noise_dn 0: not measured
void note_noise(double pooled_dark_noise_dn, const std::string& role, const SensorModel& sensor, BrdfMap& map);

/// Filters beyond their tolerance, and exposures that do not meet.
void note_overlap(const OverlapReport& overlap, BrdfMap& map);

/// An aperture that leaves out some of the beam makes the whole map too bright; so does light beside it that belongs to
/// it.
void note_beam(const Measurement& measurement, const MergedSignature& signature, BrdfMap& map);

/// Counts below their darks all over the frame: no light gives that.
void note_darkness(BrdfMap& map);

/// More light in the map's pixels than fell on the sample.
void note_power(BrdfMap& map);

}  // namespace scatmap
