#pragma once
#include <array>

#include "scatmap/model/interval.h"

namespace scatmap {

/// Taylor coefficients f, f', f''/2, …, f^(N)/N! of a function of one variable, each as an interval that holds its
/// values all over a range of that variable (and of whatever else varies). With N = 0: plain interval arithmetic.
template <int N>
struct Series {
  std::array<Interval, N + 1> c;

  Series() = default;
  Series(double v) { c[0] = v; }           // NOLINT(google-explicit-constructor): a constant
  Series(const Interval& v) { c[0] = v; }  // NOLINT(google-explicit-constructor)
};

template <int N>
Series<N> operator+(const Series<N>& a, const Series<N>& b) {
  Series<N> out;
  for (int k = 0; k <= N; ++k) out.c[k] = a.c[k] + b.c[k];
  return out;
}

template <int N>
Series<N> operator-(const Series<N>& a, const Series<N>& b) {
  Series<N> out;
  for (int k = 0; k <= N; ++k) out.c[k] = a.c[k] - b.c[k];
  return out;
}

template <int N>
Series<N> operator*(const Series<N>& a, const Series<N>& b) {
  Series<N> out;
  for (int k = 0; k <= N; ++k) {
    out.c[k] = a.c[0] * b.c[k];
    for (int i = 1; i <= k; ++i) out.c[k] = out.c[k] + a.c[i] * b.c[k - i];
  }
  return out;
}

template <int N>
Series<N> operator*(double a, const Series<N>& b) {
  Series<N> out;
  for (int k = 0; k <= N; ++k) out.c[k] = Interval(a) * b.c[k];
  return out;
}

template <int N>
Series<N> square(const Series<N>& a) {
  Series<N> out = a * a;
  out.c[0] = square(a.c[0]);
  return out;
}

template <int N>
Series<N> operator/(const Series<N>& a, const Series<N>& b) {
  Series<N> out;
  for (int k = 0; k <= N; ++k) {
    Interval rest = a.c[k];
    for (int i = 0; i < k; ++i) rest = rest - out.c[i] * b.c[k - i];
    out.c[k] = rest / b.c[0];
  }
  return out;
}

template <int N>
Series<N> sqrt(const Series<N>& a) {
  Series<N> out;
  out.c[0] = sqrt(a.c[0]);
  for (int k = 1; k <= N; ++k) {
    Interval rest = a.c[k];
    for (int i = 1; i < k; ++i) rest = rest - out.c[i] * out.c[k - i];
    out.c[k] = rest / (Interval(2) * out.c[0]);
  }
  return out;
}

template <int N>
Series<N> exp(const Series<N>& a) {
  Series<N> out;
  out.c[0] = exp(a.c[0]);
  for (int k = 1; k <= N; ++k) {
    Interval sum = 0;
    for (int i = 1; i <= k; ++i) sum = sum + Interval(i) * a.c[i] * out.c[k - i];
    out.c[k] = sum / Interval(k);
  }
  return out;
}

/// cos(pi x).
template <int N>
Series<N> cos_pi(const Series<N>& x) {
  Series<N> cosine, sine;
  cosine.c[0] = cos_pi(x.c[0]);
  sine.c[0] = sin_pi(x.c[0]);
  const Interval pi(3.141592653589793, 3.1415926535897936);
  for (int k = 1; k <= N; ++k) {
    Interval cosine_sum = 0, sine_sum = 0;
    for (int i = 1; i <= k; ++i) {
      const Interval slope = pi * Interval(i) * x.c[i];
      cosine_sum = cosine_sum - slope * sine.c[k - i];
      sine_sum = sine_sum + slope * cosine.c[k - i];
    }
    cosine.c[k] = cosine_sum / Interval(k);
    sine.c[k] = sine_sum / Interval(k);
  }
  return cosine;
}

/// sin(pi x)/(pi x). It is the mean of cos(pi x t) over t in [0, 1], so its k-th derivative is within ±pi^k/(k + 1).
template <int N>
Series<N> sinc_pi(const Series<N>& x) {
  Series<N> step = x;  // x less where it starts
  step.c[0] = 0;
  Series<N> out, power(1.0);
  out.c[0] = sinc_pi(x.c[0]);
  double bound = 1;
  for (int k = 1; k <= N; ++k) {
    power = power * step;
    bound *= 3.1415926535897936 / k;
    const Interval coefficient(-bound / (k + 1) * (1 + 1e-15), bound / (k + 1) * (1 + 1e-15));
    out = out + Series<N>(coefficient) * power;
  }
  return out;
}

}  // namespace scatmap
