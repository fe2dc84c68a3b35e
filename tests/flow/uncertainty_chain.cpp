#include "tests/flow/uncertainty_chain.h"

#include <unistd.h>

#include <cmath>
#include <random>

#include "data-synthetic/simulate.h"
#include "scatmap/brdf/from_frames.h"
#include "scatmap/brdf/map_uncertainty.h"
#include "scatmap/brdf/scale_statistics.h"
#include "scatmap/report/fits_file.h"
#include "tests/flow/chain_scene.h"

namespace scatmap::test {
namespace {

namespace fs = std::filesystem;

struct Folder {
  // In memory where there is such a place: thousands of small files, each flushed to disk.
  fs::path path = (fs::exists("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path()) /
                  ("scatmap-chain-" + std::to_string(getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
};

void simulate(const fs::path& folder, ChainCase which, const ChainDraw& w, unsigned seed) {
  write_text_file(folder / "scene.toml", chain_scene(which, w, seed), Overwrite::kForce);
  synth::simulate(folder / "scene.toml", folder / "data", Overwrite::kForce, {});
}

double total(const PixelSum& s, const Grid<double>& f) {
  double out = 0;
  for (std::size_t k = 0; k < s.pixels.size(); ++k) out += s.weights[k] * f[s.pixels[k]];
  return out;
}

// Pixels that the pose moves little, judged by a run of its own: a choice that saw the trial's noise would favour
// pixels whose noise hides a gradient.
std::vector<std::pair<int, int>> steady_pixels(const BrdfMap& map) {
  std::vector<std::pair<int, int>> out;
  for (int r = 1; r + 1 < map.mask.rows(); r += 3) {
    for (int c = 1; c + 1 < map.mask.columns(); c += 3) {
      if (map.u_pose_per_sr.empty() || map.u_pose_per_sr(r, c) < 0.2f * map.u_random_per_sr(r, c))
        out.emplace_back(r, c);
    }
  }
  return out;
}

// Pixels against the mean of their four neighbours; `ratio` takes the common factor out.
void add_random(const BrdfMap& map, const Grid<double>& truth, double ratio,
                const std::vector<std::pair<int, int>>& pixels, Claim& out) {
  const auto error = [&](int r, int c) { return map.brdf_per_sr(r, c) / ratio - truth(r, c); };
  for (const auto& [r, c] : pixels) {
    double value = error(r, c), variance = std::pow(map.u_random_per_sr(r, c), 2);
    for (const auto& [dr, dc] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      value -= error(r + dr, c + dc) / 4;
      variance += std::pow(map.u_random_per_sr(r + dr, c + dc), 2) / 16;
    }
    const double z = value * ratio / std::sqrt(variance);
    if (std::isfinite(z)) out.add(z, std::abs(z) < 1.959964);
  }
}

// Error over the exact standard deviation of true/reported, covered by the 95 % Monte Carlo interval.
void add_factor(const BrdfMap& map, const MapUncertainty& u, const PixelSum& sum, const Grid<double>& truth,
                Claim& out) {
  const SumUncertainty s = u.of(sum);
  const ScaleBudget factors = factor_budget(s, map.scale);
  const double additive = s.relative_additive(), factor = total(sum, truth) / s.value;
  const FactorStatistics mc = monte_carlo(factors, additive, 200'000);
  const FactorMoments exact = exact_moments(factors, additive);
  out.add((factor - exact.mean) / exact.sd, factor >= mc.symmetric.low && factor <= mc.symmetric.high);
}

struct Truth {
  Grid<double> brdf_per_sr;
  std::vector<std::pair<int, int>> steady;
};

void add_trial(ChainCase which, const BrdfResult& r, const Truth& known, ChainResult& out) {
  const Grid<double>& truth = known.brdf_per_sr;
  const BrdfMap& map = r.map;
  const MapUncertainty u(map);
  const ChainRegions regions = chain_regions(which);
  const PixelSum lobe = power_in(map, regions.lobe), faint = mean_over(map, regions.faint);
  const PixelSum left = mean_over(map, regions.left), right = mean_over(map, regions.right);
  add_random(map, truth, total(lobe, map.brdf_per_sr) / total(lobe, truth), known.steady, out.random);
  add_factor(map, u, lobe, truth, out.scale);
  add_factor(map, u, faint, truth, out.region);
  const Ratio ratio = ratio_of(u, left, right);
  const double true_ratio = total(left, truth) / total(right, truth);
  const double z = (ratio.value - true_ratio) / ratio.u;
  out.ratio_square += std::pow(ratio.value / true_ratio - 1, 2);
  out.structured.add(z, std::abs(z) < 1.959964);
  out.largest_u_scale = std::max(out.largest_u_scale, map.scale.standard());
  if (which == ChainCase::kOneExposure) out.first_order_fails += check_first_order(map.scale, 0, 1).valid ? 0 : 1;
  if (r.overlap) {
    for (const OverlapPair& p : r.overlap->solution.pairs) {
      if (p.used) out.largest_seam = std::max(out.largest_seam, std::abs(p.ln_ratio) - 3 * p.u);
    }
  }
  out.notes += static_cast<double>(map.notes.size());
  out.trials += 1;
}

}  // namespace

void Claim::add(double z, bool inside) {
  n += 1;
  sum += z;
  square += z * z;
  fourth += z * z * z * z;
  covered += inside ? 1 : 0;
}

double Claim::claimed_over_observed() const { return 1 / std::sqrt(square / n); }

double Claim::standard_error() const {
  const double variance = square / n;
  return std::sqrt((fourth / n - variance * variance) / n) / (2 * variance);
}

double ChainResult::rms_ratio_error() const { return std::sqrt(ratio_square / trials); }

ChainResult uncertainty_chain(ChainCase which, int trials, unsigned first_seed) {
  const Folder folder;
  const auto measured = [&] {
    Measurement m = read_measurement(folder.path / "data" / "measurement.toml");
    m.instrument.calibration = chain_calibration(which);
    return brdf_from_frames(m);
  };
  simulate(folder.path, which, {}, 1);
  const Truth truth{FitsReader(folder.path / "data" / "truth" / "brdf.fits").image_double("TRUTH_BRDF"),
                    steady_pixels(measured().map)};
  ChainResult out;
  for (int t = 0; t < trials; ++t) {
    const unsigned seed = first_seed + static_cast<unsigned>(t);
    std::mt19937_64 rng(seed);
    simulate(folder.path, which, chain_draw(which, rng), seed);
    add_trial(which, measured(), truth, out);
  }
  return out;
}

}  // namespace scatmap::test
