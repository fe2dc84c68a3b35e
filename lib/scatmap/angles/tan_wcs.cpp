#include "scatmap/angles/tan_wcs.h"

#include <cmath>

#include "scatmap/base/units.h"

namespace scatmap {

TanWcs tan_wcs(const SampleView& view) {
  // Longitude is measured from −x towards −y: turn the sample axes by pi about z, then it is an ordinary longitude.
  const auto turned = [](const Vector3<double>& v) { return Vector3<double>(-v.x(), -v.y(), v.z()); };
  const Vector3<double> u = turned(view.column_step), v = turned(view.row_step), origin = turned(view.origin);
  // The TAN pole is the foot of the perpendicular, on the side of the plane where the pixels are.
  Vector3<double> pole = turned(view.detector_normal);
  double distance = pole.dot(origin);
  if (distance < 0) {
    pole = -pole;
    distance = -distance;
  }
  // At the pole of the world the longitude is arbitrary: 0. East and north there follow from the same choice.
  const double across = std::hypot(pole.x(), pole.y());
  const double cos_lon = across > 0 ? pole.x() / across : 1, sin_lon = across > 0 ? pole.y() / across : 0;
  const Vector3<double> east(-sin_lon, cos_lon, 0);
  const Vector3<double> north(-pole.z() * cos_lon, -pole.z() * sin_lon, across);

  TanWcs wcs{};
  const Vector3<double> in_plane = distance * pole - origin;
  wcs.crpix = {1 + in_plane.dot(u) / u.squaredNorm(), 1 + in_plane.dot(v) / v.squaredNorm()};
  double longitude = std::atan2(sin_lon, cos_lon) * kDegPerRad;
  if (longitude < 0) longitude += 360;
  wcs.crval_deg = {longitude, std::atan2(pole.z(), across) * kDegPerRad};
  const double scale = kDegPerRad / distance;
  wcs.cd = {{{east.dot(u) * scale, east.dot(v) * scale}, {north.dot(u) * scale, north.dot(v) * scale}}};
  return wcs;
}

}  // namespace scatmap
