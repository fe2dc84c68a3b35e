#pragma once
#include <string>

namespace scatmap {

/// The shortest decimal text that reads back as the same double, bit for bit ("325", "0.1", "1e-05", "nan", "-0.0").
std::string number_text(double value);

/// The text of the number that a reader, multiplying by `unit`, turns into `inside` again, bit for bit. Every value
/// that came from a file has one; where no double does it, the nearest is written and `inside` moves by its last bit.
std::string number_text_in_unit(double inside, double unit);

}  // namespace scatmap
