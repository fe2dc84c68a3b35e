#include "scatmap/angles/angle_kernel.h"

namespace scatmap::kernel {

SCATMAP_CLONES void run_near(const NearSegment<double>& s, std::size_t n, double* theta, double* phi) {
  near_angles(s, n, theta, phi);
}
SCATMAP_CLONES void run_near(const NearSegment<float>& s, std::size_t n, float* theta, float* phi) {
  near_angles(s, n, theta, phi);
}
SCATMAP_CLONES void run_far(const FarSegment<double>& s, std::size_t n, double* theta, double* phi) {
  far_angles(s, n, theta, phi);
}
SCATMAP_CLONES void run_far(const FarSegment<float>& s, std::size_t n, float* theta, float* phi) {
  far_angles(s, n, theta, phi);
}
SCATMAP_CLONES void run_solid_angles(const FarSegment<double>& s, double scale, std::size_t n, double* out) {
  solid_angles(s, scale, n, out);
}
SCATMAP_CLONES void run_solid_angles(const FarSegment<float>& s, float scale, std::size_t n, float* out) {
  solid_angles(s, scale, n, out);
}
SCATMAP_CLONES void run_cosines(const FarSegment<double>& s, std::size_t n, double* out) { cosines(s, n, out); }
SCATMAP_CLONES void run_cosines(const FarSegment<float>& s, std::size_t n, float* out) { cosines(s, n, out); }
SCATMAP_CLONES void run_projected(const FarSegment<double>& s, double scale, std::size_t n, double* out) {
  projected_solid_angles(s, scale, n, out);
}
SCATMAP_CLONES void run_projected(const FarSegment<float>& s, float scale, std::size_t n, float* out) {
  projected_solid_angles(s, scale, n, out);
}

}  // namespace scatmap::kernel
