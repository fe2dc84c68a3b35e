#pragma once
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace scatmap::test {

using Row = std::map<std::string, double>;

/// Rows of a CSV file of numbers in tests/oracle: '#' lines skipped, then one header line. Row::at throws for a name
/// that is not a column.
inline std::vector<Row> oracle_rows(const std::string& file) {
  std::ifstream in(std::string(SCATMAP_TEST_DATA) + "/" + file);
  if (!in) throw std::runtime_error("cannot open " + file);
  std::vector<std::string> names;
  std::vector<Row> rows;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::stringstream cells(line);
    std::vector<std::string> words;
    for (std::string cell; std::getline(cells, cell, ',');) words.push_back(cell);
    if (names.empty()) {
      names = words;
      continue;
    }
    Row row;
    for (std::size_t i = 0; i < names.size(); ++i) row[names[i]] = std::stod(words.at(i));
    rows.push_back(row);
  }
  return rows;
}

}  // namespace scatmap::test
