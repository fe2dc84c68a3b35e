// What a message shows of hostile input: one line of valid UTF-8, and no more than a beginning of a long value. Does
// not prove that the words around it help.
#include "scatmap/base/error.h"

#include <gtest/gtest.h>

namespace scatmap {
namespace {

std::string shown(const std::string& got) { return Error({"w", "p", got, {}}).what(); }

TEST(Error, LeavesEmptyFieldsOut) {
  EXPECT_STREQ(Error({"w", "p", "g", "e"}).what(), "w: p, got g, expected e");
  EXPECT_STREQ(Error({{}, "p", {}, "e"}).what(), "p, expected e");
}

TEST(Error, ControlCharactersAndStrayBytesBecomeQuestionMarks) {
  EXPECT_EQ(shown("a\nb\033[31m\x7f"), "w: p, got a?b?[31m?");
  EXPECT_EQ(shown("\xff\xc3("), "w: p, got ?" "?(");
  EXPECT_EQ(shown("\xc2\x9b"
                  "31m"),
            "w: p, got ?31m");  // the 8-bit form of ESC [
  EXPECT_EQ(shown("\u00b5m"), "w: p, got \u00b5m");
  EXPECT_EQ(shown(std::string("\0x", 2)), "w: p, got ?x");
}

TEST(Error, LongValuesAreCutBetweenCharacters) {
  EXPECT_EQ(shown(std::string(kLongestGot, 'x')), "w: p, got " + std::string(kLongestGot, 'x'));
  EXPECT_EQ(shown(std::string(5000, 'x')), "w: p, got " + std::string(kLongestGot, 'x') + "...");
  EXPECT_EQ(shown(std::string(kLongestGot - 1, 'x') + "\u00b5\u00b5"),
            "w: p, got " + std::string(kLongestGot - 1, 'x') + "...");
  EXPECT_EQ(Error({"w", "p", std::string(5000, 'x'), {}}).detail().got.size(), 5000u);
}

}  // namespace
}  // namespace scatmap
