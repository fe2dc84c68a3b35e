#include "scatmap/brdf/merge.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scatmap/base/parallel.h"
#include "scatmap/counts/expected_signal.h"

namespace scatmap {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// One exposure at one pixel, in map units.
struct Sample {
  double value, floor, shot, dark;  // variance(E) = floor + dark + E·shot
  int dark_group;
  bool good;

  double variance(double expected) const { return floor + dark + std::max(0.0, expected) * shot; }
};

Sample sample(const ScaledCounts& e, int row, int column) {
  const Counts& c = *e.counts;
  const double f = e.factor, f2 = f * f;
  return {c.rate_dn_per_s(row, column) * f,
          c.frame_floor(row, column) * f2,
          c.shot(row, column) * f,
          c.dark_floor(row, column) * f2,
          e.dark_group,
          c.mask(row, column) == 0};
}

// Noise of a weighted mean as a model of the signal: variance(E) = floor + E·shot, shared darks added as amplitudes.
struct PixelModel {
  double value = 0, floor = 0, shot = 0;
};

PixelModel weighted_mean(const std::vector<Sample>& samples, const std::vector<double>& weight) {
  PixelModel m;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (weight[i] == 0) continue;
    const double w = weight[i], w2 = w * w;
    m.value += w * samples[i].value;
    m.floor += w2 * (samples[i].floor + samples[i].dark);
    m.shot += w2 * samples[i].shot;
    for (std::size_t j = 0; j < i; ++j) {  // same dark: errors f_i·d and f_j·d add as amplitudes
      if (weight[j] == 0 || samples[j].dark_group != samples[i].dark_group) continue;
      m.floor += 2 * w * weight[j] * std::sqrt(samples[i].dark * samples[j].dark);
    }
  }
  return m;
}

void weigh(const std::vector<Sample>& samples, double expected, std::vector<double>& weight) {
  double sum = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    weight[i] = samples[i].good ? 1 / samples[i].variance(expected) : 0;
    sum += weight[i];
  }
  for (double& w : weight) w /= sum;
}

// The good exposure that sees most of the light: a first idea of the signal.
double most_sensitive(const std::vector<Sample>& samples) {
  double value = kNaN, smallest = HUGE_VAL;
  for (const Sample& s : samples) {
    if (s.good && s.floor < smallest) {
      smallest = s.floor;
      value = s.value;
    }
  }
  return value;
}

double mean_at(const std::vector<Sample>& samples, double expected) {
  double sum = 0, weights = 0;
  for (const Sample& s : samples) {
    if (!s.good) continue;
    const double weight = 1 / s.variance(expected);
    sum += weight * s.value;
    weights += weight;
  }
  return sum / weights;
}

struct Model {
  Grid<double> value;
  Grid<float> floor, shot;
};

// `expected` absent: the first pass.
Model pass(std::span<const ScaledCounts> exposures, const Grid<double>* expected, Merged& out) {
  const int rows = out.mask.rows(), columns = out.mask.columns();
  Model model{{rows, columns}, {rows, columns}, {rows, columns}};
  for_each_row(rows, [&](int row) {
    std::vector<Sample> samples(exposures.size());
    std::vector<double> weight(exposures.size());
    for (int c = 0; c < columns; ++c) {
      for (std::size_t i = 0; i < exposures.size(); ++i) samples[i] = sample(exposures[i], row, c);
      PixelModel m{kNaN, kNaN, kNaN};
      if (out.mask(row, c) == 0) {
        weigh(samples, expected == nullptr ? most_sensitive(samples) : (*expected)(row, c), weight);
        m = weighted_mean(samples, weight);
        for (std::size_t i = 0; i < out.share.size(); ++i) out.share[i](row, c) = static_cast<float>(weight[i]);
      }
      model.value(row, c) = m.value;
      model.floor(row, c) = static_cast<float>(m.floor);
      model.shot(row, c) = static_cast<float>(m.shot);
    }
  });
  return model;
}

Grid<Mask> merged_mask(std::span<const ScaledCounts> exposures) {
  Grid<Mask> mask(exposures.front().counts->mask.rows(), exposures.front().counts->mask.columns());
  for_each_row(mask.rows(), [&](int row) {
    for (int c = 0; c < mask.columns(); ++c) {
      bool any_good = false;
      Mask all = 0;
      for (const ScaledCounts& e : exposures) {
        const Mask m = e.counts->mask(row, c);
        any_good = any_good || m == 0;
        all |= m;
      }
      mask(row, c) = any_good ? Mask{0} : all;
    }
  });
  return mask;
}

}  // namespace

Merged merge(std::span<const ScaledCounts> exposures) {
  Merged out;
  out.mask = merged_mask(exposures);
  const int rows = out.mask.rows(), columns = out.mask.columns();
  if (exposures.size() > 1) out.share.assign(exposures.size(), Grid<float>(rows, columns, 0.0f));
  Model model = pass(exposures, nullptr, out);
  out.expected = expected_signal(model.value, model.floor, model.shot, out.mask);
  if (exposures.size() > 1) {
    model = pass(exposures, &out.expected, out);
    out.expected = expected_signal(model.value, model.floor, model.shot, out.mask);
  }
  out.value = std::move(model.value);
  out.variance = Grid<float>(rows, columns);
  for_each_row(rows, [&](int row) {
    for (int c = 0; c < columns; ++c) {
      out.variance(row, c) =
          static_cast<float>(variance_at<double>(out.expected(row, c), model.floor(row, c), model.shot(row, c)));
    }
  });
  return out;
}

Merged merge_once(std::span<const ScaledCounts> exposures) {
  Merged out;
  out.mask = merged_mask(exposures);
  out.value = Grid<double>(out.mask.rows(), out.mask.columns());
  for_each_row(out.mask.rows(), [&](int row) {
    std::vector<Sample> samples(exposures.size());
    for (int c = 0; c < out.mask.columns(); ++c) {
      if (out.mask(row, c) != 0) {
        out.value(row, c) = kNaN;
        continue;
      }
      for (std::size_t i = 0; i < exposures.size(); ++i) samples[i] = sample(exposures[i], row, c);
      out.value(row, c) = mean_at(samples, most_sensitive(samples));
    }
  });
  return out;
}

}  // namespace scatmap
