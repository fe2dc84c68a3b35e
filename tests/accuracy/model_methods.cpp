#include "accuracy/model_methods.h"

#include <algorithm>
#include <cmath>

#include "scatmap/base/units.h"
#include "scatmap/model/frame_model.h"

namespace scatmap::accuracy {
namespace {

std::string text(const ModelCase& c, std::size_t i) {
  char out[200];
  std::snprintf(out, sizeof out, "wi (%.17g, %.17g, %.17g) ws (%.17g, %.17g, %.17g) truth %.6Lg of peak %.3Lg",
                c.wi.x(), c.wi.y(), c.wi.z(), c.ws[i].x(), c.ws[i].y(), c.ws[i].z(), c.truth_per_sr[i], c.peak_per_sr);
  return out;
}

void add(MethodErrors& errors, const ModelCase& c, const std::vector<double>& values, double bound) {
  const double allowed = bound + (c.sensitive ? model_rounding_error(c.model, c.wi, kDistance_mm * kMetrePerMm) : 0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const long double scale = std::max(c.truth_per_sr[i], static_cast<long double>(kPeakShare) * c.peak_per_sr);
    // The truth drops factors below 1e-60: where all is faint there is nothing to compare with.
    if (!(scale > 1e-30L)) continue;
    ++errors.samples;
    double error = static_cast<double>(std::abs(values[i] - c.truth_per_sr[i]) / scale);
    if (std::isnan(error)) error = HUGE_VAL;
    if (error / allowed > errors.largest_of_allowed) {
      errors.largest_of_allowed = error / allowed;
      errors.largest = error;
      errors.where = text(c, i);
    }
  }
}

using Random = std::mt19937_64;
using Long = long double;
double uniform(Random& r, double low, double high) { return std::uniform_real_distribution<double>(low, high)(r); }
double log_uniform(Random& r, double low, double high) { return std::exp(uniform(r, std::log(low), std::log(high))); }

struct FrameCase {
  ModelCase model;
  DirectionPlane plane;
  int rows, columns;
};

// A detector at about the specular direction, its pixels from 1e-6 to 3e-3 rad.
FrameCase random_frame(Random& r) {
  FrameCase f;
  const double theta = uniform(r, 0, 1) < 0.1 ? 0 : uniform(r, 0, 88) * kRadPerDeg;
  f.model = empty_case({-std::sin(theta), 0, std::cos(theta)}, uniform(r, 0, 1) < 0.3 ? 0 : uniform(r, -180, 180),
                       static_cast<Polarization>(std::uniform_int_distribution<int>(0, 2)(r)));
  f.rows = std::uniform_int_distribution<int>(1, 200)(r);
  f.columns = std::uniform_int_distribution<int>(1, 700)(r);
  const double pixel = log_uniform(r, 1e-6, 3e-3), roll = uniform(r, 0, 1) < 0.5 ? 0 : uniform(r, 0, 7);
  const Vector3<double> boresight(std::sin(theta), 0, std::cos(theta)), right(std::cos(theta), 0, -std::sin(theta));
  const Vector3<double> down(0, 1, 0);
  f.plane.column_step = pixel * (std::cos(roll) * right + std::sin(roll) * down);
  f.plane.row_step = pixel * (std::cos(roll) * down - std::sin(roll) * right);
  f.plane.origin =
      boresight - uniform(r, 0, f.columns) * f.plane.column_step - uniform(r, 0, f.rows) * f.plane.row_step;
  return f;
}

// A tilted lobe whose mirror direction is a chosen place of the frame: tile corners, edges, between pixels.
void aim_lobe(FrameCase& f, double m, Random& r) {
  static constexpr double kPlaces[] = {0, 63.5, 64, 63, 15.5, 16, 127.5, 255.5, 256, 31.5};
  const auto place = [&](int count) {
    return uniform(r, 0, 1) < 0.5 ? uniform(r, -2, count + 2)
                                  : kPlaces[std::uniform_int_distribution<int>(0, 9)(r)] + uniform(r, -0.6, 0.6);
  };
  const Vector3<double> n = (f.plane.at(place(f.columns), place(f.rows)).normalized() + f.model.wi).normalized();
  const std::complex<double> index(uniform(r, 0.6, 4), uniform(r, 0, 1) < 0.5 ? 0 : uniform(r, 0, 4));
  add_lobe(f.model, log_uniform(r, 1e-6, 1), m, index, std::atan2(std::hypot(n.x(), n.y()), n.z()) * kDegPerRad,
           std::atan2(n.y(), n.x()) * kDegPerRad - f.model.truth.phi_ref_deg);
}

FrameCase adversarial_frame(Random& r, double narrowest_px) {
  FrameCase f = random_frame(r);
  const double pixel = f.plane.column_step.norm();
  const int terms = std::uniform_int_distribution<int>(1, 4)(r);
  for (int i = 0; i < terms; ++i) {
    const double kind = uniform(r, 0, 5);
    if (kind < 2) {
      aim_lobe(f, pixel * log_uniform(r, narrowest_px, 300), r);  // to wider than the frame
    } else if (kind < 3) {
      add_lobe(f.model, log_uniform(r, 1e-4, 1), log_uniform(r, std::max(1e-4, narrowest_px * pixel), 3),
               {uniform(r, 0.6, 4), 0});
    } else if (kind < 4) {
      // From fringes narrower than a pixel to ones wider than the frame.
      const double a_um = 0.6328 / (pixel * log_uniform(r, 0.3, 1000));
      add_stripes(f.model, log_uniform(r, 1e-2, 1e3), a_um, a_um * log_uniform(r, 1e-3, 1),
                  325e3 * pixel * log_uniform(r, 0.3, 1000),
                  uniform(r, 0, 1) < 0.5 ? StripesForm::kPaper : StripesForm::kGrating);
    } else {
      add_lambertian(f.model, log_uniform(r, 1e-6, 1));
    }
  }
  return f;
}

std::vector<double> filled(const FrameCase& f, const FrameModelOptions& options) {
  std::vector<double> out(static_cast<std::size_t>(f.rows) * static_cast<std::size_t>(f.columns));
  FrameModel(f.model.model, f.model.wi, kDistance_mm * kMetrePerMm, f.plane, f.rows, f.columns, options).fill(out);
  return out;
}

// Where truth and product mean the same to rounding: not along the normal in polarised light, not beside the critical
// angle, not below 1 degree of grazing.
bool has_truth(const FrameCase& f, const Vector3<Long>& ws) {
  if (f.model.wi.x() == 0 && f.model.model.polarization != Polarization::kUnpolarized) return false;
  for (const Term& term : f.model.model.terms) {
    const auto* lobe = std::get_if<MicrofacetTerm>(&term);
    if (lobe != nullptr && lobe->n.real() < 1) return false;
  }
  return ws.z() > 0.0175L;
}

std::string place(const FrameCase& f, int frame, std::size_t i, double expected, double value, double tolerance) {
  char out[200];
  std::snprintf(out, sizeof out, "frame %d of %d x %d, column %zu, row %zu: %.17g, culled %.17g at %.2g", frame,
                f.columns, f.rows, i % static_cast<std::size_t>(f.columns), i / static_cast<std::size_t>(f.columns),
                expected, value, tolerance);
  return out;
}

// Error in units of what is allowed; infinite for NaN.
double part_of(double allowed, double value, double expected, double peak) {
  const double scale = std::max(expected, kPeakShare * peak);
  if (!(scale > 1e-30)) return 0;
  const double error = std::abs(value - expected) / scale / allowed;
  return std::isnan(error) ? HUGE_VAL : error;
}

Vector3<Long> direction(const FrameCase& f, Long column, Long row) {
  const Vector3<Long> ray =
      f.plane.origin.cast<Long>() + column * f.plane.column_step.cast<Long>() + row * f.plane.row_step.cast<Long>();
  return ray / ray.norm();
}

void compare_with_truth(const FrameCase& f, int frame, const std::vector<double>& culled, double tolerance,
                        double allowed, double peak, Random& random, CullingErrors& out) {
  for (int k = 0; k < 20; ++k) {
    const auto i = std::uniform_int_distribution<std::size_t>(0, culled.size() - 1)(random);
    const auto column = static_cast<Long>(i % static_cast<std::size_t>(f.columns));
    const auto row = static_cast<Long>(i / static_cast<std::size_t>(f.columns));
    const Vector3<Long> ws = direction(f, column, row);
    if (!has_truth(f, ws)) continue;
    ++out.truths;
    const auto expected = static_cast<double>(truth_at(f.model, ws));
    const double part = part_of(allowed, culled[i], expected, peak);
    if (part > out.largest_of_allowed_truth) {
      out.largest_of_allowed_truth = part;
      out.where_truth = place(f, frame, i, expected, culled[i], tolerance);
    }
  }
}

// Four by four Gauss points in each of 16 by 16 parts.
Long mean_of_truth(const FrameCase& f, Long column, Long row) {
  constexpr int kParts = 16;
  constexpr Long kAt[] = {-0.430568155797026287612L, -0.169990521792428132401L, 0.169990521792428132401L,
                          0.430568155797026287612L};
  constexpr Long kWeight[] = {0.173927422568726928687L, 0.326072577431273071313L, 0.326072577431273071313L,
                              0.173927422568726928687L};
  const auto position = [&](int i) { return (i / 4 + 0.5L + kAt[i % 4]) / kParts - 0.5L; };
  Long sum = 0;
  for (int i = 0; i < 4 * kParts; ++i) {
    for (int j = 0; j < 4 * kParts; ++j)
      sum += kWeight[i % 4] * kWeight[j % 4] * truth_at(f.model, direction(f, column + position(j), row + position(i)));
  }
  return sum / (static_cast<Long>(kParts) * kParts);
}

}  // namespace

RegimeErrors measure_regime(Regime regime, int cases, int directions, unsigned long seed) {
  Random random(seed + static_cast<unsigned long>(regime));
  RegimeErrors out;
  for (int k = 0; k < cases; ++k) {
    const ModelCase c = model_case(regime, directions, random);
    const double distance_m = kDistance_mm * kMetrePerMm;
    const PreparedModel exact(c.model, c.wi, distance_m);
    const ModelKernel kernel(c.model, c.wi, distance_m);
    std::vector<double> values(c.ws.size());
    std::transform(c.ws.begin(), c.ws.end(), values.begin(), exact);
    add(out.exact, c, values, kExactModelError);
    kernel.directions(c.ws, Amplitudes::kDouble, values);
    add(out.vector, c, values, kVectorModelError);
    kernel.directions(c.ws, Amplitudes::kSingle, values);
    add(out.single, c, values, kSingleModelError);
  }
  return out;
}

CullingErrors measure_culling(int frames, unsigned long seed) {
  Random random(seed);
  CullingErrors out;
  for (int k = 0; k < frames; ++k) {
    const FrameCase f = adversarial_frame(random, 0.05);
    const double tolerance = log_uniform(random, 1e-11, 1e-2);
    const std::vector<double> vector = filled(f, {ModelMethod::kVector});
    const std::vector<double> culled = filled(f, {ModelMethod::kCulled, tolerance});
    double peak = 0;
    for (const double v : vector) peak = std::isnan(v) ? peak : std::max(peak, v);
    // Both round their directions, each in its own way.
    const double allowed = tolerance + 2 * model_rounding_error(f.model.model, f.model.wi, kDistance_mm * kMetrePerMm);
    for (std::size_t i = 0; i < vector.size(); ++i) {
      ++out.pixels;
      if (std::isnan(vector[i]) && std::isnan(culled[i])) continue;
      const double part = part_of(allowed, culled[i], vector[i], peak);
      if (part > out.largest_of_allowed) {
        out.largest_of_allowed = part;
        out.where = place(f, k, i, vector[i], culled[i], tolerance);
      }
    }
    compare_with_truth(f, k, culled, tolerance, allowed + kVectorModelError, peak, random, out);
  }
  return out;
}

MethodErrors measure_averages(int frames, unsigned long seed) {
  Random random(seed);
  MethodErrors out;
  for (int k = 0; k < frames; ++k) {
    const FrameCase f = adversarial_frame(random, 0.3);
    const double tolerance = log_uniform(random, 1e-8, 1e-2);
    const std::vector<double> points = filled(f, {ModelMethod::kVector});
    const std::vector<double> means = filled(f, {ModelMethod::kCulled, tolerance, true});
    double peak = 0;
    for (const double v : points) peak = std::isnan(v) ? peak : std::max(peak, v);
    const double allowed =
        tolerance + kVectorModelError + 2 * model_rounding_error(f.model.model, f.model.wi, kDistance_mm * kMetrePerMm);
    for (int j = 0; j < 4; ++j) {
      const auto i = std::uniform_int_distribution<std::size_t>(0, means.size() - 1)(random);
      const auto column = static_cast<Long>(i % static_cast<std::size_t>(f.columns));
      const auto row = static_cast<Long>(i / static_cast<std::size_t>(f.columns));
      // Eight pixels from the horizon nothing is promised.
      if (!has_truth(f, direction(f, column, row)) || !(direction(f, column, row).z() > 0.05L)) continue;
      ++out.samples;
      const auto expected = static_cast<double>(mean_of_truth(f, column, row));
      const double part = part_of(allowed, means[i], expected, peak);
      if (part > out.largest_of_allowed) {
        out.largest_of_allowed = part;
        out.where = place(f, k, i, expected, means[i], tolerance);
      }
    }
  }
  return out;
}

}  // namespace scatmap::accuracy
