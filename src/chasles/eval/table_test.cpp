#include <limits>

#include <gtest/gtest.h>

#include <chasles/eval/table.hpp>

namespace chasles {
namespace {

const Table kTable{
    .header = {"set", "ATE m", "note"},
    .rows = {{"2018/0020", "2.88", "a|b"}, {"0°", "15.80", ""}, {"x", "-", "c, \"d\""}}};

TEST(Table, TextAlignsNumbersRightAndWordsLeft) {
  EXPECT_EQ(to_text(kTable),
            "set        ATE m  note\n"
            "2018/0020   2.88  a|b\n"
            "0°         15.80\n"
            "x              -  c, \"d\"\n");
}

TEST(Table, MarkdownMarksTheAlignmentAndEscapesBars) {
  EXPECT_EQ(to_markdown(kTable),
            "| set       | ATE m | note   |\n"
            "|-----------|------:|--------|\n"
            "| 2018/0020 |  2.88 | a\\|b   |\n"
            "| 0°        | 15.80 |        |\n"
            "| x         |     - | c, \"d\" |\n");
}

TEST(Table, CsvQuotesOnlyWhatNeedsIt) {
  EXPECT_EQ(to_csv(kTable),
            "set,ATE m,note\n2018/0020,2.88,a|b\n0°,15.80,\nx,-,\"c, \"\"d\"\"\"\n");
}

TEST(Table, RowsShorterThanTheHeaderHaveEmptyCells) {
  EXPECT_EQ(to_csv({.header = {"a", "b"}, .rows = {{"1"}}}), "a,b\n1,\n");
  EXPECT_EQ(to_text({.header = {"a", "b"}, .rows = {}}), "a  b\n");
}

TEST(Table, ACellWithoutValueIsADash) {
  EXPECT_EQ(cell(1.23456, 2), "1.23");
  EXPECT_EQ(cell(std::nullopt, 2), "-");
  EXPECT_EQ(cell(std::numeric_limits<double>::quiet_NaN(), 2), "-");
}

}  // namespace
}  // namespace chasles
