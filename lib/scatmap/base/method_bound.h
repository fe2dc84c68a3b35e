#pragma once

namespace scatmap {

/// One row of the table of promises: by how much a method may differ from its reference, anywhere in its domain.
/// `bound` is the constant of the method's header; tests/accuracy asserts it, `scatmap chart` prints it and
/// docs/accuracy.md quotes it.
struct MethodBound {
  const char* job;        ///< "angles", "model", …
  const char* method;     ///< "vector", …, as --method takes it
  const char* quantity;   ///< what is compared: "direction", "solid angle", "BRDF"
  const char* reference;  ///< what it is compared with
  const char* domain;     ///< where the bound holds
  const char* unit;       ///< "rad", "px", "relative"
  double bound;
};

}  // namespace scatmap
