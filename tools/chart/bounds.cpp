#include "tools/chart/bounds.h"

#include "scatmap/angles/angle_method.h"
#include "scatmap/base/number_text.h"
#include "scatmap/brdf/fused.h"
#include "scatmap/model/model_method.h"

namespace scatmap::tools {

std::string bounds_table() {
  std::string out = "| job | method | quantity | bound | unit | reference | domain |\n|---|---|---|---|---|---|---|\n";
  for (const auto& room : {angle_bounds(), model_method_bounds(), brdf_bounds()}) {
    for (const MethodBound& b : room) {
      out += std::string("| ") + b.job + " | " + b.method + " | " + b.quantity + " | " + number_text(b.bound) + " | " +
             b.unit + " | " + b.reference + " | " + b.domain + " |\n";
    }
  }
  return out;
}

nlohmann::json bounds_json() {
  nlohmann::json out = nlohmann::json::array();
  for (const auto& room : {angle_bounds(), model_method_bounds(), brdf_bounds()}) {
    for (const MethodBound& b : room) {
      out.push_back({{"job", b.job},
                     {"method", b.method},
                     {"quantity", b.quantity},
                     {"bound", b.bound},
                     {"unit", b.unit},
                     {"reference", b.reference},
                     {"domain", b.domain}});
    }
  }
  return out;
}

}  // namespace scatmap::tools
