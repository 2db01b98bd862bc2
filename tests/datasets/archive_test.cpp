#include "datasets/store/archive.h"

#include <gtest/gtest.h>

#include <limits>

namespace graintruth::datasets {

enum class Colour { red, green };
template <>
struct EnumWords<Colour> {
  static constexpr std::array<const char*, 2> words = {"red", "green"};
};

struct Grain {
  std::string name;
  double size = 0.0;
  std::optional<int> number;
  Colour colour = Colour::red;
};
template <class Archive>
void list_fields(Archive& archive, Grain& grain) {
  auto& [name, size, number, colour] = grain;
  archive("name", name)("size", size)("number", number)("colour", colour);
}

struct Bed {
  std::vector<Grain> grains;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  std::array<bool, 2> sides{};
  std::map<std::string, double> settings;
};
template <class Archive>
void list_fields(Archive& archive, Bed& bed) {
  auto& [grains, gravity, sides, settings] = bed;
  archive("grains", grains)("gravity", gravity)("sides", sides)("settings", settings);
}

namespace {

std::string complaint_about(const char* text) {
  try {
    from_json<Bed>(Json::parse(text));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Archive, ReadsBackEveryBitThatItWrote) {
  const Bed bed{{{"a", 0.1 + 0.2, 7, Colour::green},
                 {"b", -std::numeric_limits<double>::infinity(), std::nullopt, Colour::red}},
                {0.0, 1.0 / 3.0, -9.81},
                {true, false},
                {{"width", 5e-324}}};
  const Bed again = from_json<Bed>(Json::parse(to_json(bed).dump()));
  EXPECT_EQ(to_json(again).dump(), to_json(bed).dump());
  EXPECT_EQ(again.grains[0].size, bed.grains[0].size);
  EXPECT_EQ(again.grains[1].size, bed.grains[1].size);
  EXPECT_FALSE(again.grains[1].number);
  EXPECT_EQ(again.gravity, bed.gravity);
  EXPECT_EQ(again.settings, bed.settings);
}

TEST(Archive, WritesFieldsInTheOrderOfTheirListing) {
  const Grain grain{"a", std::numeric_limits<double>::quiet_NaN(), std::nullopt, Colour::green};
  EXPECT_EQ(to_json(grain).dump(), R"({"name":"a","size":null,"colour":"green"})");
}

TEST(Archive, NamesTheFieldThatDoesNotFit) {
  EXPECT_EQ(complaint_about(R"({"grains":[]})"), "'gravity' is missing");
  EXPECT_EQ(complaint_about(R"({"grains":[{"name":"a","size":"big"}]})"),
            "grains: size: must be a number");
  EXPECT_EQ(complaint_about(R"({"grains":[{"name":"a","size":1,"colour":"blue"}]})"),
            "grains: colour: must be one of red, green");
  EXPECT_EQ(complaint_about(R"({"grains":[],"gravity":[1,2]})"), "gravity: must be a list of 3");
}

TEST(Archive, KeepsDefaultsOfWhatIsMissingWhereAsked) {
  const Grain grain = from_json<Grain>(Json::parse(R"({"name":"a"})"), true);
  EXPECT_EQ(grain.name, "a");
  EXPECT_EQ(grain.size, 0.0);
}

}  // namespace
}  // namespace graintruth::datasets
