#include "tests/flow/uncertainty_chain.h"

#include <unistd.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>
#include <sstream>

#include "data-synthetic/simulate.h"
#include "scatmap/brdf/from_frames.h"
#include "scatmap/brdf/map_uncertainty.h"
#include "scatmap/brdf/scale_statistics.h"
#include "scatmap/report/fits_file.h"

namespace scatmap::test {
namespace {

namespace fs = std::filesystem;

constexpr double kTolerance = 0.05, kLaser = 0.005, kTime = 0.001, kNonlinear_percent = 0.5;

struct Stack {
  double exposure_s;
  std::vector<std::string> filters;
};

const std::vector<std::pair<std::string, double>> kFilters{{"nd40", 4.0},  {"nd30", 3.0},    {"nd20", 2.0},
                                                           {"nd03", 0.3},  {"nd10", 1.0},    {"nd06", 0.6},
                                                           {"nd03b", 0.3}, {"nd017", 0.1694}};
const Stack kSignature{2.5, {"nd40", "nd10", "nd06", "nd03b", "nd017"}};

std::vector<Stack> stacks(ChainCase which) {
  if (which == ChainCase::kOneExposure) return {{5, {"nd30", "nd03"}}};
  return {{10, kSignature.filters}, {5, {"nd30", "nd03"}}, {0.5, {"nd20"}}};
}

Calibration calibration() {
  Calibration c;
  c.parameters = {"detector.distance_mm", "arm.zero_deg", "stage.zero_deg"};
  Eigen::Vector3d sigma(0.5, 0.008, 0.006);
  Eigen::Matrix3d correlation;
  correlation << 1, 0.2, 0, 0.2, 1, 0.7, 0, 0.7, 1;
  c.covariance = sigma.asDiagonal() * correlation * sigma.asDiagonal();
  return c;
}

// The draws of one trial; the default is a world without errors.
struct World {
  std::vector<double> od_error = std::vector<double>(kFilters.size(), 0);
  std::vector<double> time_error = std::vector<double>(4, 0);  // signature, exposures
  double laser = 0, nonlinear_percent = 0;
  Eigen::Vector3d pose = Eigen::Vector3d::Zero();
};

World drawn(std::mt19937_64& rng) {
  std::uniform_real_distribution<double> within(-1, 1);
  std::normal_distribution<double> normal;
  World w;
  for (std::size_t f = 0; f < kFilters.size(); ++f) w.od_error[f] = kTolerance * kFilters[f].second * within(rng);
  for (double& t : w.time_error) t = kTime * normal(rng);
  w.laser = kLaser * within(rng);
  w.nonlinear_percent = kNonlinear_percent * within(rng);
  Eigen::Vector3d z(normal(rng), normal(rng), normal(rng));
  w.pose = calibration().covariance.llt().matrixL() * z;
  return w;
}

std::string stack_text(const Stack& s, double time_error, int frames) {
  std::ostringstream out;
  out.precision(17);
  out << "exposure_s = " << s.exposure_s << "\ntrue_exposure_s = " << s.exposure_s * (1 + time_error)
      << "\nu_exposure_percent = " << 100 * kTime << "\nframes = " << frames << "\ndarks = 4\nfilters = [";
  for (std::size_t i = 0; i < s.filters.size(); ++i) out << (i == 0 ? "\"" : ", \"") << s.filters[i] << '"';
  out << "]\n";
  return out.str();
}

std::string scene_text(ChainCase which, const World& w, unsigned seed) {
  std::ostringstream out;
  out.precision(17);
  out << "kind = \"brdf\"\nseed = " << seed
      << "\nwavelength_nm = 632.8\npolarization = \"unpolarized\"\nstage_deg = 20.0\narm_deg = 40.0\n"
      << "[detector]\ncolumns = 64\nrows = 64\npitch_um = [212.5, 212.5]\ndistance_mm = " << 325 + w.pose[0]
      << "\n[arm]\nzero_deg = " << w.pose[1] << "\n[stage]\nzero_deg = " << w.pose[2]
      << "\n[nominal.detector]\ndistance_mm = 325.0\n[nominal.arm]\nzero_deg = 0.0\n[nominal.stage]\n"
      << "zero_deg = 0.0\n[beam]\nsignature_diameter_mm = 1.7\n[sensor]\ngain_e_per_dn = 1.5\nread_noise_e = "
         "8.0\nbias_dn = 300.0\n"
      << "saturation_dn = 65535.0\nfull_well_e = 120000.0\ndark_e_per_s = 2.0\nnonlinearity_percent = "
      << w.nonlinear_percent
      << "\n[nominal.sensor]\nsaturation_dn = 60000.0\nnonlinearity_percent = " << kNonlinear_percent
      << "\n[laser]\nelectrons_per_s = 4.0e+11\ndrift_percent = " << 100 * w.laser
      << "\ndrift_tolerance_percent = " << 100 * kLaser << "\n";
  for (std::size_t f = 0; f < kFilters.size(); ++f) {
    out << "[filters." << kFilters[f].first << "]\nod = " << kFilters[f].second
        << "\ntolerance_percent = " << 100 * kTolerance << "\ntrue_od = " << kFilters[f].second + w.od_error[f] << "\n";
  }
  out << "[signature]\n" << stack_text(kSignature, w.time_error[0], 4);
  std::size_t e = 1;
  for (const Stack& s : stacks(which)) out << "[[exposure]]\n" << stack_text(s, w.time_error[e++], 3);
  out << "[[term]]\nkind = \"microfacet\"\nrho = 0.5\nm = 3.5e-3\nn = [1.5, 0.0]\n[[term]]\nkind = \"lambertian\"\nrho "
         "= 1.0\n";
  return out.str();
}

struct Folder {
  // In memory where there is such a place: thousands of small files, each flushed to disk.
  fs::path path = (fs::exists("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path()) /
                  ("scatmap-chain-" + std::to_string(getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
};

void simulate(const fs::path& folder, ChainCase which, const World& w, unsigned seed) {
  write_text_file(folder / "scene.toml", scene_text(which, w, seed), Overwrite::kForce);
  synth::simulate(folder / "scene.toml", folder / "data", Overwrite::kForce, {});
}

double total(const PixelSum& s, const Grid<double>& f) {
  double out = 0;
  for (std::size_t k = 0; k < s.pixels.size(); ++k) out += s.weights[k] * f[s.pixels[k]];
  return out;
}

// Pixels against the mean of their four neighbours, where the pose moves little; `ratio` takes the common factor out.
void add_random(const BrdfMap& map, const Grid<double>& truth, double ratio, Claim& out) {
  const auto error = [&](int r, int c) { return map.brdf_per_sr(r, c) / ratio - truth(r, c); };
  for (int r = 1; r + 1 < truth.rows(); r += 3) {
    for (int c = 1; c + 1 < truth.columns(); c += 3) {
      if (!(map.u_pose_per_sr(r, c) < 0.2f * map.u_random_per_sr(r, c))) continue;
      double value = error(r, c), variance = std::pow(map.u_random_per_sr(r, c), 2);
      for (const auto& [dr, dc] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        value -= error(r + dr, c + dc) / 4;
        variance += std::pow(map.u_random_per_sr(r + dr, c + dc), 2) / 16;
      }
      const double z = value * ratio / std::sqrt(variance);
      if (std::isfinite(z)) out.add(z, std::abs(z) < 1.959964);
    }
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

void add_trial(ChainCase which, const BrdfResult& r, const Grid<double>& truth, ChainResult& out) {
  const BrdfMap& map = r.map;
  const MapUncertainty u(map);
  const PixelSum lobe = power_in(map, {20, 20, 43, 43}), faint = mean_over(map, {2, 2, 13, 13});
  const PixelSum left = mean_over(map, {25, 27, 29, 36}), right = mean_over(map, {34, 27, 38, 36});
  add_random(map, truth, total(lobe, map.brdf_per_sr) / total(lobe, truth), out.random);
  add_factor(map, u, lobe, truth, out.scale);
  add_factor(map, u, faint, truth, out.region);
  const Ratio ratio = ratio_of(u, left, right);
  const double z = (ratio.value - total(left, truth) / total(right, truth)) / ratio.u;
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

ChainResult uncertainty_chain(ChainCase which, int trials, unsigned first_seed) {
  const Folder folder;
  simulate(folder.path, which, {}, 1);
  const Grid<double> truth = FitsReader(folder.path / "data" / "truth" / "brdf.fits").image_double("TRUTH_BRDF");
  ChainResult out;
  for (int t = 0; t < trials; ++t) {
    const unsigned seed = first_seed + static_cast<unsigned>(t);
    std::mt19937_64 rng(seed);
    simulate(folder.path, which, drawn(rng), seed);
    Measurement m = read_measurement(folder.path / "data" / "measurement.toml");
    m.instrument.calibration = calibration();
    add_trial(which, brdf_from_frames(m), truth, out);
  }
  return out;
}

}  // namespace scatmap::test
