#include <algorithm>

#include "scatmap/base/error.h"
#include "tools/chart/stability.h"

namespace scatmap::tools {

void require_no_failure(const std::vector<StabilityCell>& cells) {
  const auto fails = [](const StabilityCell& c) { return c.verdict == Verdict::kFails; };
  const auto first = std::find_if(cells.begin(), cells.end(), fails);
  if (first == cells.end()) return;
  throw Error({"stability",
               std::to_string(std::count_if(first, cells.end(), fails)) +
                   " FAILS (stability.csv), the first: " + first->job + ", " + first->regime + ", " + first->method,
               {},
               {}});
}

}  // namespace scatmap::tools
