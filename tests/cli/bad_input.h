#pragma once
#include <cstdio>
#include <set>

#include "cli/spoil.h"

namespace scatmap::test {

/// One bad input: how it is made from the good laboratory, what is run, and what the tool must say.
struct BadInput {
  std::string name;
  std::vector<std::string> command;
  Spoil spoil;
  int status;                     ///< 1 bad data, 2 bad usage
  std::vector<std::string> says;  ///< parts of the message; % stands for the line that was edited
  bool not_for_root = false;      ///< rests on permissions, which do not bind root
};

inline std::string with_line(std::string part, long line) {
  const std::size_t at = part.find('%');
  return at == std::string::npos ? part : part.replace(at, 1, std::to_string(line));
}

/// What differs between two contents() of a laboratory.
inline std::vector<std::string> changes(const std::map<std::string, std::string>& before,
                                        const std::map<std::string, std::string>& after) {
  std::vector<std::string> out;
  for (const auto& [name, bytes] : after) {
    if (!before.contains(name)) {
      out.push_back("wrote " + name);
    } else if (before.at(name) != bytes) {
      out.push_back("changed " + name);
    }
  }
  for (const auto& [name, bytes] : before) {
    if (!after.contains(name)) out.push_back("removed " + name);
  }
  return out;
}

inline bool is_one_message(const std::string& err) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  return err.starts_with("scatmap: ") && err.ends_with("\n") && std::none_of(err.begin(), err.end() - 1, is_control);
}

/// Everything the tool does wrong with this input; empty: all is well.
inline std::vector<std::string> complaints(const BadInput& bad, const LabMaker& maker) {
  Lab lab = maker.fresh_copy();
  bad.spoil(lab);
  const auto before = lab.contents();
  const ToolRun run = run_tool(bad.command, lab.folder());
  std::vector<std::string> out = changes(before, lab.contents());
  if (run.status != bad.status) {
    out.push_back("exit status " + std::to_string(run.status) + " instead of " + std::to_string(bad.status));
  }
  if (!is_one_message(run.err)) out.push_back("no single line 'scatmap: …'");
  if (!run.out.empty()) out.push_back("standard output: " + run.out);
  for (const std::string& part : bad.says) {
    const std::string wanted = with_line(part, lab.edited_line());
    if (run.err.find(wanted) == std::string::npos) out.push_back("message lacks '" + wanted + "'");
  }
  if (!out.empty()) out.push_back("message: " + run.err);
  return out;
}

inline std::string joined(const std::vector<std::string>& parts) {
  std::string out;
  for (const std::string& p : parts) out += "\n    " + p;
  return out;
}

/// Runs the table. Cases named in `known_wrong` must fail, and are printed, so that a mended one leaves the list.
inline void check_table(const std::vector<BadInput>& table, const std::set<std::string>& known_wrong) {
  const LabMaker maker;
  for (const BadInput& bad : table) {
    if (bad.not_for_root && geteuid() == 0) {
      std::printf("NOT TRIED AS ROOT  %s\n", bad.name.c_str());
      continue;
    }
    std::string wrong;
    try {
      wrong = joined(complaints(bad, maker));
    } catch (const std::exception& e) {
      FAIL() << bad.name << ": the case could not be prepared: " << e.what();
    }
    const bool known = known_wrong.contains(bad.name);
    if (known && wrong.empty()) ADD_FAILURE() << bad.name << " is right now: take it off the known-wrong list";
    if (!known && !wrong.empty()) ADD_FAILURE() << bad.name << ":" << wrong;
    if (known && !wrong.empty()) std::printf("KNOWN WRONG  %s:%s\n", bad.name.c_str(), wrong.c_str());
  }
}

}  // namespace scatmap::test
