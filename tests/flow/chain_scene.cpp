#include "tests/flow/chain_scene.h"

#include <Eigen/Cholesky>
#include <sstream>

namespace scatmap::test {
namespace {

constexpr double kTolerance = 0.05;
// The lab states the non-linearity at its own saturation, the simulator wants it at full scale.
constexpr double kBias_dn = 300, kFullScale_dn = 65535, kSaturation_dn = 60000, kNonlinear_percent = 0.5,
                 kNonlinearAtFullScale_percent =
                     kNonlinear_percent * (kFullScale_dn - kBias_dn) / (kSaturation_dn - kBias_dn);

struct Stack {
  double exposure_s;
  std::vector<std::string> filters;
};

struct Setting {
  std::vector<Stack> signatures, exposures;
  double u_time = 0, laser = 0;  // laser: half width
  std::string sensor;            // size, beam and laser
  std::string terms;
};

const std::vector<std::pair<std::string, double>> kFilters{{"nd40", 4.0},  {"nd30", 3.0},    {"nd20", 2.0},
                                                           {"nd03", 0.3},  {"nd10", 1.0},    {"nd06", 0.6},
                                                           {"nd03b", 0.3}, {"nd017", 0.1694}};
const std::vector<std::string> kSignature{"nd40", "nd10", "nd06", "nd03b", "nd017"};

const char* const kBroadSensor =
    "columns = 64\nrows = 64\npitch_um = [212.5, 212.5]\n[beam]\nsignature_diameter_mm = 1.7\n"
    "[laser]\nelectrons_per_s = 4.0e+11\n";
const char* const kBroadTerms =
    "[[term]]\nkind = \"microfacet\"\nrho = 0.5\nm = 3.5e-3\nn = [1.5, 0.0]\n"
    "[[term]]\nkind = \"lambertian\"\nrho = 1.0\n";
const char* const kPaperSensor =
    "columns = 96\nrows = 96\npitch_um = [26.5625, 26.5625]\n[beam]\nsignature_diameter_mm = 0.5\n"
    "[laser]\nelectrons_per_s = 9.73225e+12\n";
const char* const kPaperTerms =
    "[[term]]\nkind = \"microfacet\"\nrho = 0.015\nm = 2e-4\nn = [3.6, 0.0]\n"
    "[[term]]\nkind = \"stripes\"\nrho = 300.0\na_um = 800.0\nb_um = 10.0\nc_um = 40.0\nform = \"paper\"\n"
    "[[term]]\nkind = \"lambertian\"\nrho = 0.05\n";

Setting setting(ChainCase which) {
  const Stack paper{5, {"nd30", "nd03"}}, weak{0.5, {"nd20"}};
  switch (which) {
    case ChainCase::kOneExposure:
      return {{{2.5, kSignature}}, {paper}, 1e-3, 5e-3, kBroadSensor, kBroadTerms};
    case ChainCase::kThreeExposures:
      return {{{2.5, kSignature}}, {{10, kSignature}, paper, weak}, 1e-3, 5e-3, kBroadSensor, kBroadTerms};
    case ChainCase::kPaperSameStack:
      return {{{0.4, kSignature}},
              {{13.5, kSignature}, {0.15, {"nd30", "nd03"}}, {0.1, {"nd20"}}},
              5e-4,
              5e-4,
              kPaperSensor,
              kPaperTerms};
    case ChainCase::kPaperSignatures:
      break;
  }
  return {{{0.4, kSignature}, {0.035, {"nd40", "nd10"}}, {0.045, {"nd40", "nd06", "nd03b", "nd017"}}},
          {{0.6, {"nd40"}}, {0.15, {"nd30", "nd03"}}, {0.1, {"nd20"}}},
          5e-4,
          5e-4,  // small, so that the filters' part is seen
          kPaperSensor,
          kPaperTerms};
}

bool pose_is_known(ChainCase which) {
  return which == ChainCase::kPaperSameStack || which == ChainCase::kPaperSignatures;
}

std::string stack_text(const Stack& s, double time_error, double u_time, int frames) {
  std::ostringstream out;
  out.precision(17);
  out << "exposure_s = " << s.exposure_s << "\ntrue_exposure_s = " << s.exposure_s * (1 + time_error)
      << "\nu_exposure_percent = " << 100 * u_time << "\nframes = " << frames << "\ndarks = 4\nfilters = [";
  for (std::size_t i = 0; i < s.filters.size(); ++i) out << (i == 0 ? "\"" : ", \"") << s.filters[i] << '"';
  out << "]\n";
  return out.str();
}

std::string sensor_text(double nonlinear_percent) {
  std::ostringstream out;
  out.precision(17);
  out << "[sensor]\ngain_e_per_dn = 1.5\nread_noise_e = 8.0\nbias_dn = " << kBias_dn
      << "\nsaturation_dn = " << kFullScale_dn
      << "\nfull_well_e = 120000.0\ndark_e_per_s = 2.0\nnonlinearity_percent = " << nonlinear_percent
      << "\n[nominal.sensor]\nsaturation_dn = " << kSaturation_dn << "\nnonlinearity_percent = " << kNonlinear_percent
      << "\n";
  return out.str();
}

}  // namespace

std::optional<Calibration> chain_calibration(ChainCase which) {
  if (pose_is_known(which)) return std::nullopt;
  Calibration c;
  c.parameters = {"detector.distance_mm", "arm.zero_deg", "stage.zero_deg"};
  const Eigen::Vector3d sigma(0.5, 0.008, 0.006);
  Eigen::Matrix3d correlation;
  correlation << 1, 0.2, 0, 0.2, 1, 0.7, 0, 0.7, 1;
  c.covariance = sigma.asDiagonal() * correlation * sigma.asDiagonal();
  return c;
}

ChainDraw chain_draw(ChainCase which, std::mt19937_64& rng) {
  const Setting s = setting(which);
  std::uniform_real_distribution<double> within(-1, 1);
  std::normal_distribution<double> normal;
  ChainDraw d;
  for (std::size_t f = 0; f < kFilters.size(); ++f) d.od_error[f] = kTolerance * kFilters[f].second * within(rng);
  for (double& t : d.signature_time_error) t = s.u_time * normal(rng);
  for (double& t : d.time_error) t = s.u_time * normal(rng);
  d.laser = s.laser * within(rng);
  d.nonlinear_percent = kNonlinearAtFullScale_percent * within(rng);
  if (const auto calibration = chain_calibration(which))
    d.pose = calibration->covariance.llt().matrixL() * Eigen::Vector3d(normal(rng), normal(rng), normal(rng));
  return d;
}

std::string chain_scene(ChainCase which, const ChainDraw& d, unsigned seed) {
  const Setting s = setting(which);
  std::ostringstream out;
  out.precision(17);
  out << "kind = \"brdf\"\nseed = " << seed
      << "\nwavelength_nm = 632.8\npolarization = \"unpolarized\"\nstage_deg = 20.0\narm_deg = 40.0\n"
      << "[arm]\nzero_deg = " << d.pose[1] << "\n[stage]\nzero_deg = " << d.pose[2]
      << "\n[nominal.detector]\ndistance_mm = 325.0\n[nominal.arm]\nzero_deg = 0.0\n[nominal.stage]\n"
      << "zero_deg = 0.0\n"
      << sensor_text(d.nonlinear_percent) << "[detector]\ndistance_mm = " << 325 + d.pose[0] << "\n"
      << s.sensor << "drift_percent = " << 100 * d.laser << "\ndrift_tolerance_percent = " << 100 * s.laser << "\n";
  for (std::size_t f = 0; f < kFilters.size(); ++f) {
    out << "[filters." << kFilters[f].first << "]\nod = " << kFilters[f].second
        << "\ntolerance_percent = " << 100 * kTolerance << "\ntrue_od = " << kFilters[f].second + d.od_error[f] << "\n";
  }
  out << "[signature]\narm_deg = 180.0\n";
  for (std::size_t j = 0; j < s.signatures.size(); ++j) {
    if (s.signatures.size() > 1) out << "[[signature.exposure]]\n";
    out << stack_text(s.signatures[j], d.signature_time_error[j], s.u_time, 4);
  }
  for (std::size_t e = 0; e < s.exposures.size(); ++e)
    out << "[[exposure]]\n" << stack_text(s.exposures[e], d.time_error[e], s.u_time, 3);
  out << s.terms;
  return out.str();
}

ChainRegions chain_regions(ChainCase which) {
  if (pose_is_known(which))  // ratio: a fringe band, seen by the weak filter, against the peak, seen by the strong one
    return {{36, 36, 59, 59}, {44, 0, 52, 20}, {44, 70, 52, 90}, {40, 40, 55, 55}};
  return {{20, 20, 43, 43}, {2, 2, 13, 13}, {25, 27, 29, 36}, {34, 27, 38, 36}};
}

}  // namespace scatmap::test
