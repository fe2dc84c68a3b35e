#pragma once
#include <cstdint>
#include <iterator>
#include <utility>

#include "scatmap/base/grid.h"

namespace scatmap {

/// Counts of a raw frame, DN: 16-bit whole numbers where the file holds such, which takes half the memory, else float.
/// Reads as rows × columns of float either way.
class RawCounts {
 public:
  RawCounts() = default;
  RawCounts(Grid<float> counts) : wide_(std::move(counts)) {}            // NOLINT: a grid of counts is one
  RawCounts(Grid<std::uint16_t> counts) : narrow_(std::move(counts)) {}  // NOLINT

  int rows() const { return is_narrow() ? narrow_.rows() : wide_.rows(); }
  int columns() const { return is_narrow() ? narrow_.columns() : wide_.columns(); }
  std::size_t size() const { return is_narrow() ? narrow_.size() : wide_.size(); }
  bool empty() const { return size() == 0; }
  template <class Other>
  bool same_shape(const Other& other) const {
    return rows() == other.rows() && columns() == other.columns();
  }

  float operator()(int row, int column) const { return is_narrow() ? narrow_(row, column) : wide_(row, column); }
  float operator[](std::size_t i) const { return is_narrow() ? narrow_[i] : wide_[i]; }
  /// To write: what is written may be any number, so the counts become floats.
  float& operator()(int row, int column) { return floats()(row, column); }
  float& operator[](std::size_t i) { return floats()[i]; }
  Grid<float>& floats();

  /// Columns [first, first + pixels) of a row: where they stand, or written to `buffer`.
  const float* part(int row, int first, int pixels, float* buffer) const;
  /// Asks for some columns of a row, to have them in a cache when they are read.
  void prefetch(int row, int first, int last) const;

  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = float;
    using difference_type = std::ptrdiff_t;
    using pointer = const float*;
    using reference = float;
    Iterator(const RawCounts& counts, std::size_t i) : counts_(&counts), i_(i) {}
    float operator*() const { return (*counts_)[i_]; }
    Iterator& operator++() {
      ++i_;
      return *this;
    }
    Iterator operator++(int) {
      Iterator before = *this;
      ++i_;
      return before;
    }
    friend bool operator==(const Iterator&, const Iterator&) = default;

   private:
    const RawCounts* counts_;
    std::size_t i_;
  };
  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, size()}; }

 private:
  bool is_narrow() const { return !narrow_.empty(); }

  Grid<std::uint16_t> narrow_;
  Grid<float> wide_;
};

}  // namespace scatmap
