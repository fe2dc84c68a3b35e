#pragma once
#include "scatmap/angles/angle_kernel_body.h"

/// The loops of angle_kernel_body.h, compiled for every instruction set (base/simd.h).
namespace scatmap::kernel {

void run_near(const NearSegment<double>& segment, std::size_t n, double* theta, double* phi);
void run_near(const NearSegment<float>& segment, std::size_t n, float* theta, float* phi);
void run_far(const FarSegment<double>& segment, std::size_t n, double* theta, double* phi);
void run_far(const FarSegment<float>& segment, std::size_t n, float* theta, float* phi);
void run_solid_angles(const FarSegment<double>& segment, double scale, std::size_t n, double* out);
void run_solid_angles(const FarSegment<float>& segment, float scale, std::size_t n, float* out);
void run_cosines(const FarSegment<double>& segment, std::size_t n, double* out);
void run_cosines(const FarSegment<float>& segment, std::size_t n, float* out);
void run_projected(const FarSegment<double>& segment, double scale, std::size_t n, double* out);
void run_projected(const FarSegment<float>& segment, float scale, std::size_t n, float* out);

}  // namespace scatmap::kernel
