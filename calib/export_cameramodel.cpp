#include "calib/export_cameramodel.h"

#include <Eigen/Geometry>
#include <sstream>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"

namespace scatmap::calib {

PinholeCamera pinhole_at_spot(const SampleView& view, int columns, int rows) {
  const Vector3<double> x = view.column_step.normalized(), y = view.row_step.normalized(), z = view.detector_normal;
  if (x.cross(y).dot(z) < 0) {
    throw Error({"detector.flip_columns, detector.flip_rows",
                 "mirror the image, which no camera model can express",
                 {},
                 "frames and flips turned so that both or none are flipped"});
  }
  const double distance_m = z.dot(view.origin);
  PinholeCamera out{columns,
                    rows,
                    distance_m / view.column_step.norm(),
                    distance_m / view.row_step.norm(),
                    -x.dot(view.origin) / view.column_step.norm(),
                    -y.dot(view.origin) / view.row_step.norm(),
                    {}};
  out.camera_from_sample << x.transpose(), y.transpose(), z.transpose();
  return out;
}

std::string to_cameramodel(const PinholeCamera& camera, const std::string& comment) {
  const Eigen::AngleAxisd turn(camera.camera_from_sample);
  const Eigen::Vector3d r = turn.angle() * turn.axis();
  std::string text, line;
  for (std::istringstream lines(comment); std::getline(lines, line);) text += "# " + line + "\n";
  const auto list = [](std::initializer_list<double> values) {
    std::string out;
    for (const double v : values) out += (out.empty() ? "[ " : ", ") + number_text(v);
    return out + " ]";
  };
  text +=
      "{\n    'lensmodel':  'LENSMODEL_PINHOLE',\n\n    # focal lengths and centre, pixels; integers are pixel "
      "centres\n";
  text += "    'intrinsics': " +
          list({camera.focal_column_px, camera.focal_row_px, camera.centre_column_px, camera.centre_row_px}) + ",\n\n";
  text +=
      "    # Rodrigues vector (rad) and translation (m) of the camera from the sample axes at the illuminated spot\n";
  text += "    'extrinsics': " + list({r.x(), r.y(), r.z(), 0, 0, 0}) + ",\n\n";
  return text + "    'imagersize': [ " + std::to_string(camera.columns) + ", " + std::to_string(camera.rows) +
         " ]\n}\n";
}

}  // namespace scatmap::calib
