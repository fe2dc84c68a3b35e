#pragma once
#include <cassert>
#include <cstddef>
#include <span>
#include <vector>

#include "scatmap/base/huge_page_allocator.h"

namespace scatmap {

/// Rows × columns of T, row after row: element (row, column) is at row·columns + column. Row 0, column 0 is the first
/// pixel stored in a file; pixel centres are integers.
template <class T>
class Grid {
 public:
  Grid() = default;
  /// Uninitialised when T is trivial.
  Grid(int rows, int columns) : rows_(rows), columns_(columns), data_(count(rows, columns)) {}
  Grid(int rows, int columns, T value) : rows_(rows), columns_(columns), data_(count(rows, columns), value) {}

  int rows() const { return rows_; }
  int columns() const { return columns_; }
  std::size_t size() const { return data_.size(); }
  bool empty() const { return data_.empty(); }

  T& operator()(int row, int column) { return data_[index(row, column)]; }
  const T& operator()(int row, int column) const { return data_[index(row, column)]; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  T* data() { return data_.data(); }
  const T* data() const { return data_.data(); }
  std::span<T> row(int r) { return {data_.data() + index(r, 0), static_cast<std::size_t>(columns_)}; }
  std::span<const T> row(int r) const { return {data_.data() + index(r, 0), static_cast<std::size_t>(columns_)}; }
  auto begin() { return data_.begin(); }
  auto end() { return data_.end(); }
  auto begin() const { return data_.begin(); }
  auto end() const { return data_.end(); }

  template <class U>
  bool same_shape(const Grid<U>& other) const {
    return rows_ == other.rows() && columns_ == other.columns();
  }

 private:
  static std::size_t count(int rows, int columns) {
    assert(rows >= 0 && columns >= 0);
    return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  }
  std::size_t index(int row, int column) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }

  int rows_ = 0;
  int columns_ = 0;
  std::vector<T, HugePageAllocator<T>> data_;
};

}  // namespace scatmap
