#include "tools/chart/model.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <string>

#include "data-synthetic/truth_model.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/units.h"
#include "scatmap/compare/model_map.h"
#include "tools/chart/error_sample.h"
#include "tools/chart/naive_model.h"
#include "tools/chart/scene.h"
#include "tools/chart/timing.h"

namespace scatmap::tools {
namespace {

constexpr std::size_t kErrorStep = 331;  // every so many pixels are compared with the reference

std::string size_text(const Instrument& in) { return std::to_string(in.columns) + " x " + std::to_string(in.rows); }

synth::Term truth_of(const Term& term) {
  synth::Term t;
  if (const auto* lobe = std::get_if<MicrofacetTerm>(&term)) {
    t.kind = synth::TermKind::kMicrofacet;
    t.rho = lobe->rho;
    t.m = lobe->m;
    t.n_re = lobe->n.real();
    t.n_im = lobe->n.imag();
    t.dtheta_deg = lobe->dtheta_rad * kDegPerRad;
    t.dphi_deg = lobe->dphi_rad * kDegPerRad;
  } else if (const auto* stripes = std::get_if<StripesTerm>(&term)) {
    t.kind = synth::TermKind::kStripes;
    t.rho = stripes->rho;
    t.a_um = stripes->a_m / kMetrePerUm;
    t.b_um = stripes->b_m / kMetrePerUm;
    t.c_um = stripes->c_m / kMetrePerUm;
    t.grating = stripes->form == StripesForm::kGrating;
  } else {
    t.rho = std::get<LambertianTerm>(term).rho;
  }
  return t;
}

// The simulator's long double on the pixel plane's own vectors: what is charted is the model, not the geometry.
class Reference {
 public:
  Reference(const Model& model, const SampleView& view, double distance_m) : view_(view) {
    truth_.wavelength_nm = model.wavelength_m / kMetrePerNm;
    truth_.polarization = model.polarization == Polarization::kUnpolarized ? synth::Polarization::kUnpolarized
                          : model.polarization == Polarization::kS         ? synth::Polarization::kS
                                                                           : synth::Polarization::kP;
    truth_.phi_ref_deg = model.phi_ref_rad * kDegPerRad;
    truth_.distance_mm = distance_m / kMetrePerMm;
    for (const Term& term : model.terms) truth_.terms.push_back(truth_of(term));
  }

  long double at(long double column, long double row) const {
    const auto vector = [](const Vector3<double>& v) { return synth::Vec3{v.x(), v.y(), v.z()}; };
    const synth::Vec3 ray = vector(view_.origin) + column * vector(view_.column_step) + row * vector(view_.row_step);
    return synth::brdf_per_sr(truth_, vector(view_.to_source), synth::unit(ray));
  }

  // Four by four Gauss points in each of `parts` by `parts` parts of the pixel.
  long double mean(int column, int row, int parts) const {
    constexpr long double kAt[] = {-0.430568155797026287612L, -0.169990521792428132401L, 0.169990521792428132401L,
                                   0.430568155797026287612L};
    constexpr long double kWeight[] = {0.173927422568726928687L, 0.326072577431273071313L, 0.326072577431273071313L,
                                       0.173927422568726928687L};
    const auto place = [&](int i) { return (i / 4 + 0.5L + kAt[i % 4]) / parts - 0.5L; };
    long double sum = 0;
    for (int i = 0; i < 4 * parts; ++i) {
      for (int j = 0; j < 4 * parts; ++j)
        sum += kWeight[i % 4] * kWeight[j % 4] * at(column + place(j), row + place(i));
    }
    return sum / (static_cast<long double>(parts) * parts);
  }

 private:
  const SampleView& view_;
  synth::ModelTruth truth_;
};

// The pixels that are compared: all over the frame, and twenty times as dense in its brightest fiftieth.
std::vector<std::size_t> compared_pixels(const std::vector<double>& values, std::size_t step) {
  std::vector<double> sorted;
  std::copy_if(values.begin(), values.end(), std::back_inserter(sorted), [](double v) { return !std::isnan(v); });
  if (sorted.empty()) return {};
  const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 50);
  std::nth_element(sorted.begin(), at, sorted.end(), std::greater<>());
  const double bright = *at;
  const std::size_t dense = std::max<std::size_t>(1, step / 20);
  std::vector<std::size_t> out;
  std::size_t seen = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    if (i % step == 0 || (values[i] >= bright && seen++ % dense == 0)) out.push_back(i);
  }
  return out;
}

struct Sample {
  std::vector<std::size_t> pixels;
  std::vector<double> truth;
  double peak = 0;
};

class ModelChart {
 public:
  ModelChart(const ChartSettings& s, const Instrument& in)
      : settings_(s),
        in_(in),
        view_(sample_view(in, s.pose)),
        reference_(s.model, view_, in.geometry.distance),
        values_(static_cast<std::size_t>(in.columns) * static_cast<std::size_t>(in.rows)) {}

  Sample sample(bool means) {
    fill({ModelMethod::kExact});
    Sample out;
    for (const double v : values_) out.peak = std::isnan(v) ? out.peak : std::max(out.peak, v);
    constexpr int kParts = 6;
    for (const std::size_t i : compared_pixels(values_, means ? 100 * kErrorStep : kErrorStep)) {
      out.pixels.push_back(i);
      const int row = row_of(i), column = column_of(i);
      out.truth.push_back(
          static_cast<double>(means ? reference_.mean(column, row, kParts) : reference_.at(column, row)));
    }
    return out;
  }

  ChartRow row(const std::string& name, const FrameModelOptions& options, int threads, const Sample& sample) {
    const FrameModel model(settings_.model, view_.to_source, in_.geometry.distance,
                           {view_.origin, view_.column_step, view_.row_step}, in_.rows, in_.columns, options);
    ChartRow out = labelled(name, threads);
    out.time = with_threads(threads, [&] {
      return time_per_item(values_.size(), settings_.seconds_per_method, [&] {
        model.fill(values_);
        keep(values_.data());
      });
    });
    add_errors(out, sample);
    out.bound =
        model_error_bound(options) + model_rounding_error(settings_.model, view_.to_source, in_.geometry.distance);
    return out;
  }

  ChartRow naive_row(const Sample& sample) {
    const double distance_m = in_.geometry.distance;
    constexpr int kRowStep = 16;  // it is too slow for all rows
    const auto pixels = static_cast<std::size_t>((in_.rows + kRowStep - 1) / kRowStep * in_.columns);
    ChartRow out = labelled("naive C++, double", 1);
    out.time = with_threads(1, [&] {
      return time_per_item(pixels, settings_.seconds_per_method, [&] {
        for (int row = 0; row < in_.rows; row += kRowStep) {
          for (int column = 0; column < in_.columns; ++column)
            values_[index(column, row)] = naive_model(settings_.model, view_, distance_m, column, row);
        }
        keep(values_.data());
      });
    });
    for (const std::size_t i : sample.pixels)
      values_[i] = naive_model(settings_.model, view_, distance_m, column_of(i), row_of(i));
    add_errors(out, sample);
    out.rival = true;
    out.note = "libm pixel by pixel, std::complex, angles by acos and atan2; every 16th row timed";
    return out;
  }

  // Time to write the result alone.
  double fill_ns() {
    return with_threads(1, [&] {
      return time_per_item(values_.size(), settings_.seconds_per_method,
                           [&] {
                             std::fill(values_.begin(), values_.end(), 0.1);
                             keep(values_.data());
                           })
          .minimum_ns;
    });
  }

 private:
  void fill(const FrameModelOptions& options) {
    FrameModel(settings_.model, view_.to_source, in_.geometry.distance,
               {view_.origin, view_.column_step, view_.row_step}, in_.rows, in_.columns, options)
        .fill(values_);
  }

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(in_.columns) + static_cast<std::size_t>(column);
  }
  int column_of(std::size_t i) const { return static_cast<int>(i) % in_.columns; }
  int row_of(std::size_t i) const { return static_cast<int>(i) / in_.columns; }

  ChartRow labelled(const std::string& name, int threads) const {
    ChartRow row;
    row.method = name;
    row.size = size_text(in_);
    row.threads = threads;
    return row;
  }

  void add_errors(ChartRow& row, const Sample& sample) const {
    if (sample.pixels.empty()) return;  // no pixel of the scene is above the horizon
    ErrorSample errors;
    for (std::size_t k = 0; k < sample.pixels.size(); ++k) {
      const std::size_t i = sample.pixels[k];
      errors.add((values_[i] - sample.truth[k]) / std::max(sample.truth[k], kPeakShare * sample.peak), column_of(i),
                 row_of(i));
    }
    row.largest_error = errors.largest();
    row.p99_error = errors.percentile(99);
    row.worst_at = errors.worst_at();
  }

  const ChartSettings& settings_;
  const Instrument& in_;
  SampleView view_;
  Reference reference_;
  std::vector<double> values_;
};

struct Named {
  const char* name;
  FrameModelOptions options;
};

std::vector<std::pair<int, int>> sizes(const ChartSettings& s) {
  return {{1024, 1024}, {s.instrument.columns, s.instrument.rows}};
}

Chart points_chart(const ChartSettings& s) {
  Chart chart{"model", "Model: values at pixel centres", "pixel", "error of the larger of value and 1e-6 of the peak",
              "",      "long double, separate formula",  {},      {},
              {}};
  const Named methods[] = {{"exact", {ModelMethod::kExact}},
                           {"vector", {ModelMethod::kVector}},
                           {"single", {ModelMethod::kSingle}},
                           {"culled 1e-9", {ModelMethod::kCulled, 1e-9}},
                           {"culled 1e-6", {ModelMethod::kCulled, 1e-6}},
                           {"culled 1e-3", {ModelMethod::kCulled, 1e-3}}};
  for (const auto& [columns, rows] : sizes(s)) {
    const Instrument in = resized(s.instrument, columns, rows);
    ModelChart measured(s, in);
    const Sample sample = measured.sample(false);
    chart.rows.push_back(measured.naive_row(sample));
    for (const Named& m : methods) {
      for (const int threads : {1, 2}) chart.rows.push_back(measured.row(m.name, m.options, threads, sample));
    }
    chart.time_lines = {{"writing the map", measured.fill_ns()}};
  }
  chart.error_lines = {{"FITS in single precision", 6e-8}};
  return chart;
}

Chart means_chart(const ChartSettings& s) {
  Chart chart{"model_pixel_average",
              "Model: means over the pixels",
              "pixel",
              "error of the larger of mean and 1e-6 of the peak",
              "",
              "long double quadrature, 24 x 24 points a pixel",
              {},
              {},
              {}};
  const Named methods[] = {{"average 1e-9", {ModelMethod::kCulled, 1e-9, true}},
                           {"average 1e-6", {ModelMethod::kCulled, 1e-6, true}},
                           {"average 1e-3", {ModelMethod::kCulled, 1e-3, true}}};
  for (const auto& [columns, rows] : sizes(s)) {
    const Instrument in = resized(s.instrument, columns, rows);
    ModelChart measured(s, in);
    const Sample sample = measured.sample(true);
    ChartRow centre = measured.row("values at centres (vector)", {ModelMethod::kVector}, 1, sample);
    centre.bound.reset();
    centre.note = "what averaging is worth";
    chart.rows.push_back(centre);
    for (const Named& m : methods) {
      for (const int threads : {1, 2}) chart.rows.push_back(measured.row(m.name, m.options, threads, sample));
    }
  }
  return chart;
}

}  // namespace

std::vector<Chart> chart_model(const ChartSettings& settings) {
  return {points_chart(settings), means_chart(settings)};
}

}  // namespace scatmap::tools
