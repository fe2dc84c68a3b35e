#pragma once

namespace scatmap::tools {

/// From now on SIGINT, SIGTERM and SIGHUP (where they are not ignored) take the unfinished outputs away and then end
/// the process as they would have done. Call it before any other thread starts.
void clean_up_on_signals();

}  // namespace scatmap::tools
