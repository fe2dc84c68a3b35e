#pragma once
#include <functional>
#include <string>

namespace scatmap {

/// Called by long work now and then: what it is doing, and how much of everything is done, 0 to 1. May be empty.
using Progress = std::function<void(const std::string& step, double done)>;

}  // namespace scatmap
