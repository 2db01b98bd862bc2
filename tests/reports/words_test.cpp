#include "reports/page/words.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reports/page/parameter_words.h"

namespace graintruth::reports {
namespace {

TEST(Decimal, ShowsAsManyPlacesAsAsked) { EXPECT_EQ(decimal(0.12345, 3), "0.123"); }
TEST(Decimal, HasATypographicMinus) { EXPECT_EQ(decimal(-1.5, 1), "−1.5"); }
TEST(Decimal, NeverShowsMinusZero) { EXPECT_EQ(decimal(-0.001, 2), "0.00"); }
TEST(Decimal, ShowsADashForWhatIsNotThere) { EXPECT_EQ(decimal(std::nan(""), 2), "–"); }
TEST(Significant, KeepsThreeDigitsWhereverThePointIs) {
  EXPECT_EQ(significant(0.0023456), "0.00235");
  EXPECT_EQ(significant(1234.5), "1234");
}
TEST(Significant, WritesVerySmallNumbersAsPowersOfTen) {
  EXPECT_EQ(significant(1.25e-5), "1.25 × 10⁻⁵");
}
TEST(Seconds, ReadsAsAPersonWouldSayIt) {
  EXPECT_EQ(seconds(0.8), "0.8 s");
  EXPECT_EQ(seconds(250.0), "4 min 10 s");
  EXPECT_EQ(seconds(7500.0), "2 h 5 min");
}
TEST(DecimalsOfInterval, ShowTwoDigitsOfTheHalfWidth) {
  EXPECT_EQ(decimals_of_interval(0.104, 0.140), 3);
  EXPECT_EQ(decimals_of_interval(0.1, 0.6), 2);
}
TEST(Ordinal, IsAWordThenANumber) {
  EXPECT_EQ(ordinal(6), "sixth");
  EXPECT_EQ(ordinal(13), "13th");
  EXPECT_EQ(ordinal(22), "22nd");
  EXPECT_EQ(ordinal(111), "111th");
}
TEST(ParameterName, IsThatOfTheRegistry) {
  EXPECT_EQ(parameter_name("friction_particle_particle"), "Friction, particle to particle");
  EXPECT_EQ(parameter_phrase("friction_particle_wall"), "friction between particles and walls");
  EXPECT_EQ(parameter_name("friction_particle_column_left"), "Friction, particle to column left");
  EXPECT_EQ(parameter_phrase("friction_particle_column_left"),
            "friction between particles and the wall column left");
  EXPECT_EQ(parameter_name("hardness_of_rain"), "hardness of rain");
}
TEST(ShownUnit, IsWhatAReaderExpectsOnAnAxis) {
  EXPECT_EQ(shown_unit("kg/s").text, "g/s");
  EXPECT_EQ(shown_unit("m").factor, 1000.0);
  EXPECT_EQ(shown_unit("kg/m2").text, "kg/m²");
  EXPECT_EQ(shown_unit("kg/m2").factor, 1.0);
  EXPECT_EQ(with_unit("Grains", shown_unit("-").text), "Grains");
  EXPECT_EQ(with_unit("Height", shown_unit("m").text), "Height (mm)");
}
TEST(ToInterval, GivesTheDigitsThatAnIntervalLeaves) {
  EXPECT_EQ(to_interval(0.12345, 0.104, 0.140), "0.123");
  EXPECT_EQ(to_interval(2.34567e-9, 2e-9, 3e-9), "2.35 × 10⁻⁹");
  EXPECT_EQ(to_interval(6.89e9, 6e9, 7e9), "6.89 × 10⁹");
  EXPECT_EQ(interval_text(0.104, 0.140), "0.104 to 0.140");
  EXPECT_EQ(interval_text(0.104, std::nan("")), "–");
}
TEST(Joined, PutsAnAndBeforeTheLast) {
  EXPECT_EQ(joined({"a"}), "a");
  EXPECT_EQ(joined({"a", "b", "c"}), "a, b and c");
}

TEST(ParameterWords, GiveAValueTheDigitsThatItIsKnownTo) {
  EXPECT_EQ(
      value_text({{"value", 0.12345}, {"lower", 0.104}, {"upper", 0.14}, {"status", "tuned"}}),
      "0.123");
  EXPECT_EQ(value_text({{"value", 0.6093}, {"bench_value", 0.83}, {"status", "not_identified"}}),
            "0.61");
  EXPECT_EQ(value_text({{"value", 0.835}, {"bench_value", 0.835}, {"status", "not_identified"}}),
            "0.835");
  EXPECT_EQ(value_text({{"value", 0.3125}, {"bench_value", 0.3125}, {"status", "fixed"}}),
            "0.3125");
}

}  // namespace
}  // namespace graintruth::reports
