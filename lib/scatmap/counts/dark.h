#pragma once
#include <span>

#include "scatmap/counts/sensor_model.h"

namespace scatmap {

/// A master dark: robust mean of dark frames of one exposure time, linearised DN.
struct MasterDark {
  Grid<float> level_dn;
  Grid<float> single_variance_dn2;  ///< variance of one dark frame at that pixel: read noise, dark shot, quantisation
  Grid<float> level_variance_dn2;   ///< variance of level_dn: one error, shared by every frame the dark is taken from
  Grid<Mask> mask;                  ///< kHot
  double pooled_variance_dn2 = 0;   ///< single_variance of an ordinary pixel
  bool pooled_from_frames = false;  ///< measured from the scatter of the darks, else computed from the read noise
};

/// A dark is hot when its level exceeds the sensor's median by this many single-frame sigmas, ...
inline constexpr double kHotSigmas = 10;
/// ... or, with four darks or more, when their scatter exceeds this many times the expected variance or two are
/// outliers.
inline constexpr double kUnstableVarianceRatio = 16;
/// A dark value this far from the pixel's median is an outlier (a cosmic hit) and left out; needs three darks.
inline constexpr double kDarkOutlierSigmas = 6;
/// A pixel's own dark charge counts in its variance where its level is this many standard deviations of the level off.
inline constexpr double kExtraDarkSigmas = 3;

/// Combines darks of equal shape and exposure. The expected variance of a pixel is the pooled variance of ordinary
/// pixels plus the shot noise of its own extra dark charge, not its own scatter: a variance from a handful of values is
/// worth little and correlates with the mean. @throws Error if there is no dark or the shapes differ
MasterDark combine_darks(std::span<const Frame> darks, const SensorModel& sensor);

/// A dark level stated by the user instead of measured (a camera's black level), with its standard uncertainty.
MasterDark stated_dark(double level_dn, double u_level_dn, int rows, int columns, double quantum_dn,
                       const SensorModel& sensor);

/// @throws Error naming both files if the frames' shapes differ
void require_same_shape(const Frame& a, const Frame& b);

/// @throws Error naming the file if its header (IMAGETYP) says that it is a light or flat frame
void require_dark(const Frame& frame);
/// @throws Error naming the file if its header says that it is a dark, bias or flat frame
void require_light(const Frame& frame);
/// @throws Error naming the file if its header says that it is a light, dark or bias frame
void require_flat(const Frame& frame);

}  // namespace scatmap
