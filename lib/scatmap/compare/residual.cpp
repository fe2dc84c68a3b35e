#include "scatmap/compare/residual.h"

#include <cmath>
#include <limits>
#include <string>

#include "scatmap/base/error.h"
#include "scatmap/compare/lobe.h"

namespace scatmap {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr int kScalePasses = 4;  // the weights depend on the factor only through the model's own uncertainty

std::string shape(const BrdfMap& map) {
  return std::to_string(map.mask.columns()) + " × " + std::to_string(map.mask.rows());
}

// What the sums need of one pixel.
struct Pixel {
  double measured, modelled;
  double measured_variance, modelled_variance;  // random and structured
  double random_variance(double scale) const { return measured_random + scale * scale * modelled_random; }
  double variance(double scale) const { return measured_variance + scale * scale * modelled_variance; }
  double measured_random, modelled_random;
};

double square(const Grid<float>& u, std::size_t i) {
  return u.empty() ? 0 : static_cast<double>(u[i]) * static_cast<double>(u[i]);
}

class Pixels {
 public:
  Pixels(const BrdfMap& measured, const BrdfMap& modelled)
      : measured_(measured),
        modelled_(modelled),
        measured_u_(per_pixel_uncertainty(measured)),
        modelled_u_(per_pixel_uncertainty(modelled)) {}

  bool have_uncertainty() const { return !measured_u_.empty() || !modelled_u_.empty(); }

  std::optional<Pixel> at(std::size_t i) const {
    if (measured_.mask[i] != 0 || modelled_.mask[i] != 0) return std::nullopt;
    Pixel p{};
    p.measured = measured_.brdf_per_sr[i];
    p.modelled = modelled_.brdf_per_sr[i];
    p.measured_variance = square(measured_u_, i);
    p.modelled_variance = square(modelled_u_, i);
    p.measured_random = square(measured_.u_random_per_sr, i);
    p.modelled_random = square(modelled_.u_random_per_sr, i);
    const double u2 = p.variance(1);
    if (!std::isfinite(p.measured) || !std::isfinite(p.modelled) || !(u2 > 0 && std::isfinite(u2))) return std::nullopt;
    return p;
  }

  template <class F>
  void for_each(const F& f) const {
    for (std::size_t i = 0; i < measured_.mask.size(); ++i) {
      if (const auto p = at(i)) f(i, *p);
    }
  }

 private:
  const BrdfMap& measured_;
  const BrdfMap& modelled_;
  Grid<float> measured_u_, modelled_u_;
};

ScaleFit fit_scale(const Pixels& pixels) {
  ScaleFit fit;
  for (int pass = 0; pass < kScalePasses; ++pass) {
    double across = 0, square_sum = 0, random = 0;
    pixels.for_each([&](std::size_t, const Pixel& p) {
      const double weight = 1 / p.variance(fit.factor);
      across += weight * p.measured * p.modelled;
      square_sum += weight * p.modelled * p.modelled;
      random += weight * weight * p.modelled * p.modelled * p.random_variance(fit.factor);
    });
    fit.factor = across / square_sum;
    fit.standard_error = std::sqrt(random) / square_sum;
  }
  return fit;
}

double chi_squared(const Pixels& pixels, double scale) {
  double sum = 0;
  pixels.for_each([&](std::size_t, const Pixel& p) {
    const double r = p.measured - scale * p.modelled;
    sum += r * r / p.variance(scale);
  });
  return sum;
}

}  // namespace

Residual residual(const BrdfMap& measured, const BrdfMap& modelled) {
  if (!measured.mask.same_shape(modelled.mask)) {
    throw Error({"compare", "the maps have different shapes", shape(modelled), shape(measured)});
  }
  const Pixels pixels(measured, modelled);
  if (!pixels.have_uncertainty()) {
    throw Error({"compare", "residuals need an uncertainty, and neither map has one", {}, {}});
  }
  Residual out;
  out.normalised = Grid<float>(measured.mask.rows(), measured.mask.columns(), kNaN);
  pixels.for_each([&](std::size_t i, const Pixel& p) {
    out.normalised[i] = static_cast<float>((p.measured - p.modelled) / std::sqrt(p.variance(1)));
    ++out.pixels;
  });
  if (out.pixels < 2) {
    throw Error({"compare", "too few pixels are good in both maps", std::to_string(out.pixels), "at least 2"});
  }
  out.scale = fit_scale(pixels);
  out.scale.u_scale = std::hypot(measured.scale.standard(), modelled.scale.standard());
  if (out.scale.u_scale > 0) out.scale.pull = std::abs(out.scale.factor - 1) / out.scale.u_scale;
  const auto n = static_cast<double>(out.pixels);
  out.as_is = {chi_squared(pixels, 1), n};
  out.scaled = {chi_squared(pixels, out.scale.factor), n - 1};
  return out;
}

Grid<float> log10_ratio(const BrdfMap& measured, const BrdfMap& modelled) {
  Grid<float> ratio(measured.mask.rows(), measured.mask.columns(), kNaN);
  for (std::size_t i = 0; i < ratio.size(); ++i) {
    const double a = measured.brdf_per_sr[i], b = modelled.brdf_per_sr[i];
    if (measured.mask[i] == 0 && modelled.mask[i] == 0 && a > 0 && b > 0) {
      ratio[i] = static_cast<float>(std::log10(a / b));
    }
  }
  return ratio;
}

}  // namespace scatmap
