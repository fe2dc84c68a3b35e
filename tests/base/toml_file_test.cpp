// The strict TOML reader: what it gives, and that it names file, line and key of what it refuses.
#include "scatmap/base/toml_file.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "scatmap/base/error.h"

namespace scatmap {
namespace {

template <class Work>
std::string message(Work&& work) {
  try {
    work();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

TEST(TomlTable, ReadsWhatStands) {
  const TomlTable t =
      TomlTable::parse("a = 1\nb = 2.5\nc = \"x\"\nd = [1, 2]\n[e]\nf = true\n[[g]]\nh = 1\n[[g]]\nh = 2\n", "f.toml");
  EXPECT_EQ(t.number("a"), 1);
  EXPECT_EQ(t.number("b"), 2.5);
  EXPECT_EQ(t.string("c"), "x");
  EXPECT_EQ(t.numbers("d", 2), (std::vector<double>{1, 2}));
  EXPECT_TRUE(t.table("e").boolean_or("f", false));
  const auto g = t.tables("g");
  ASSERT_EQ(g.size(), 2u);
  EXPECT_EQ(g[1].integer("h", 0, 9), 2);
  EXPECT_EQ(g[0].integer("h", 0, 9), 1);
  EXPECT_NO_THROW(t.reject_unknown_keys());
  EXPECT_EQ(t.number_or("absent", 7), 7);
  EXPECT_FALSE(t.optional_table("absent").has_value());
  EXPECT_TRUE(t.tables("absent").empty());
}

TEST(TomlTable, NamesFileLineAndKey) {
  const TomlTable t = TomlTable::parse("a = 1\n\n[b]\nc = \"x\"\nd = -1\n[[e]]\nf = 1\n", "f.toml");
  EXPECT_EQ(message([&] { t.table("b").number("c"); }),
            "f.toml:4: b.c: has the wrong type, got a string, expected a finite number");
  EXPECT_EQ(message([&] { t.table("b").number("d", kPositive); }),
            "f.toml:5: b.d: is out of range, got -1, expected a number > 0");
  EXPECT_NE(message([&] { t.table("b").number("z"); }).find("b.z: is missing"), std::string::npos);
  EXPECT_NE(message([&] { t.tables("e")[0].string("f"); }).find("f.toml:7: e.0.f"), std::string::npos);
  EXPECT_NE(message([&] { t.reject_unknown_keys(); }).find("is not a known key"), std::string::npos);
}

TEST(TomlTable, AMissingKeyNamesTheOneThatMayBeMeant) {
  const TomlTable t = TomlTable::parse("distance_mm = 3\nexposre_s = 1\nod = 2\n", "f.toml");
  EXPECT_EQ(message([&] { t.number("exposure_s", kPositive); }),
            "f.toml:1: exposure_s: is missing, got exposre_s in line 2, expected a number > 0");
  EXPECT_EQ(message([&] { t.string("distnce_m"); }),
            "f.toml:1: distnce_m: is missing, got distance_mm in line 1, expected a string");
  for (const char* other : {"exposure_ms_each", "id", "od_2"})
    EXPECT_EQ(message([&] { t.string(other); }).find("got"), std::string::npos) << other;
}

TEST(TomlTable, NonFiniteNumbersAreRefusedEverywhere) {
  const TomlTable t = TomlTable::parse("a = nan\nb = inf\nc = [1, nan]\nd = [[1, inf]]\n", "f.toml");
  EXPECT_THROW(t.number("a"), Error);
  EXPECT_THROW(t.number("b"), Error);
  EXPECT_THROW(t.numbers("c", 2), Error);
  EXPECT_THROW(t.matrix("d"), Error);
}

TEST(TomlTable, UnknownKeysInSubTablesAreFound) {
  const TomlTable t = TomlTable::parse("[a]\n[a.b]\nc = 1\n", "f.toml");
  const TomlTable b = t.table("a").table("b");
  EXPECT_NE(message([&] { t.reject_unknown_keys(); }).find("f.toml:3: a.b.c"), std::string::npos);
  b.number("c");
  EXPECT_NO_THROW(t.reject_unknown_keys());
}

TEST(TomlTable, SyntaxErrorsHaveALine) {
  EXPECT_EQ(message([] { TomlTable::parse("a = 1\nb = = 2\n", "f.toml"); }).rfind("f.toml:2: is not valid TOML", 0),
            0u);
  EXPECT_NE(message([] { TomlTable::parse("a = 1\na = 2\n", "f.toml"); }), "no error");
}

TEST(TomlTable, OtherFormatsAreNamed) {
  const auto parsed = [](const std::string& text) { return message([&] { TomlTable::parse(text, "f"); }); };
  EXPECT_EQ(parsed("SIMPLE  =                    T / standard"), "f: is a FITS file, not TOML");
  EXPECT_EQ(parsed("\x89PNG\r\n"), "f: is a PNG image, not TOML");
  EXPECT_EQ(parsed(std::string("II*\0", 4)), "f: is a TIFF image, not TOML");
  EXPECT_EQ(parsed(std::string("MM\0*", 4)), "f: is a TIFF image, not TOML");
  EXPECT_EQ(parsed("v/1\x01"), "f: is an OpenEXR image, not TOML");
  EXPECT_EQ(parsed(std::string("a = 1\n\0", 7)), "f: is no text file, expected TOML");
  EXPECT_EQ(parsed("SIMPLE = 1\n"), "no error");
}

// toml++ overflowed the stack with that many tables in each other.
TEST(TomlTable, KeysOfAMillionPartsAreRefused) {
  std::string key = "a", quoted = "'='";
  for (int i = 0; i < 1000000; ++i) key += ".a";
  for (int i = 0; i < 1000000; ++i) quoted += R"( . "#\"")";
  for (const std::string& text :
       {key + " = 1\n", "[" + key + "]\n", "[[" + key + "]]\n", quoted + " = 1\n", "a = {" + key + " = 1}\n",
        "a = \"\"\"\n\"\"\"\n" + key + " = 1\n", "a = 'b' # '\n" + key + " = 1\n", "a = '''\\'''\n" + key + " = 1\n"}) {
    const auto line = 1 + std::count(text.begin(), text.end() - 1, '\n');
    EXPECT_EQ(message([&] { TomlTable::parse(text, "deep.toml"); }),
              "deep.toml:" + std::to_string(line) + ": has a key of too many parts")
        << text.substr(0, 20);
  }
  EXPECT_THROW(TomlTable::parse("a = " + std::string(100000, '['), "deep.toml"), Error);
  std::string numbers = "a = [0.5";
  for (int i = 0; i < 1000; ++i) numbers += ", 0.5";
  const std::string dots(100, '.');
  EXPECT_NO_THROW(TomlTable::parse(numbers + "]\nb = \"" + dots + "\" # " + dots + "\nc = 1.5", "a.toml"));
}

}  // namespace
}  // namespace scatmap
