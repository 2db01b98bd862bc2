#include "calibrate/parameters.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "datasets/parameters/parameter.h"
#include "datasets/store/input_error.h"
#include "tests/support/parameters.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

using tests::TemporaryFolder;

const ParameterSpace space({{"friction_particle_wall", 0.1, 0.5}, {"restitution", 0.3, 0.9}},
                           tests::parameters(0.25, 0.0, 0.0));

TEST(ParameterSpace, GoesToTheUnitCubeAndBack) {
  const ParameterSet parameters = space.from_unit({0.25, 1.0});
  EXPECT_DOUBLE_EQ(parameters.of("friction_particle_particle"), 0.25);  // not tuned: the base value
  EXPECT_DOUBLE_EQ(parameters.of("friction_particle_wall"), 0.2);
  EXPECT_DOUBLE_EQ(parameters.of("restitution"), 0.9);
  EXPECT_NEAR(space.to_unit(parameters)[0], 0.25, 1e-15);
}

TEST(ParameterSpace, CanHoldAParameter) {
  const ParameterSpace held = space.with_fixed("restitution", 0.83);
  EXPECT_EQ(held.dimension(), 1U);
  EXPECT_EQ(held.from_unit({0.0}).of("restitution"), 0.83);
}

TEST(LoadParameters, ReadsAResultAndATable) {
  const TemporaryFolder folder;
  const auto json = folder.write("result.json",
                                 R"({"parameters": {"friction_particle_particle": {"value": 0.1},
                                     "friction_particle_wall": {"value": 0.2}, "restitution": {"value": 0.7}},
                                     "time_step": {"fraction": 0.2}})");
  const ParameterSet from_json = load_parameters(json, {});
  EXPECT_EQ(from_json.of("friction_particle_wall"), 0.2);
  EXPECT_EQ(load_time_step_fraction(json), 0.2);
  const auto toml = folder.write("p.toml", "friction_particle_particle = 0.3\n");
  const ParameterSet from_toml = load_parameters(toml, tests::parameters(0.5, 0.6, 0.7));
  EXPECT_EQ(from_toml.of("friction_particle_particle"), 0.3);
  EXPECT_EQ(from_toml.of("friction_particle_wall"), 0.6);
  EXPECT_FALSE(load_time_step_fraction(toml).has_value());
}

TEST(LoadParameters, RefusesWhatItCannotUse) {
  const TemporaryFolder folder;
  EXPECT_THROW(load_parameters(folder / "absent.json", {}), datasets::InputError);
  EXPECT_THROW(load_parameters(folder.write("a.json", "{"), {}), datasets::InputError);
  EXPECT_THROW(load_parameters(folder.write("b.json", "{\"parameters\": {}}"), {}),
               datasets::InputError);
  EXPECT_THROW(load_parameters(folder.write("c.toml", "friction_particle_particle = -1\n"), {}),
               datasets::InputError);
}

// What is said of a file; empty where nothing is.
std::string complaint_about(const std::filesystem::path& file) {
  try {
    load_parameters(file, tests::parameters(0.5, 0.6, 0.7));
    load_time_step_fraction(file);
  } catch (const datasets::InputError& error) {
    return error.what();
  }
  return "";
}

// A result.json with one parameter, or the step, as it is given here.
std::string result_with(const std::string& name, const std::string& value) {
  std::string text = "{\"parameters\": {";
  for (const char* known : {"friction_particle_particle", "friction_particle_wall", "restitution"})
    if (known != name) text += fmt::format("\"{}\": {{\"value\": 0.5}}, ", known);
  return text + fmt::format("\"{}\": {{\"value\": {}}}}}}}", name, value);
}

// The registry says what can be, to both.
TEST(LoadParameters, AResultHasTheBoundsOfATable) {
  const TemporaryFolder folder;
  for (const datasets::ParameterKind* kind : datasets::parameter_kinds()) {
    const std::string name = std::string(kind->name) + (kind->is_of_a_wall ? "floor" : "");
    for (const char* value : {"-0.1", "-1e308", "1e14", "1e308", "\"0.5\"", "[0.5]", "true"}) {
      const std::string said = complaint_about(folder.write("a.json", result_with(name, value)));
      EXPECT_NE(said.find("a.json: key 'parameters." + name + ".value' "), std::string::npos)
          << value << ": " << said;
      EXPECT_NE(said.find(kind->range.words), std::string::npos) << said;
      const std::string key = kind->units.front().suffix.empty()
                                  ? name
                                  : fmt::format("{}_{}", name, kind->units.front().suffix);
      EXPECT_NE(complaint_about(folder.write("a.toml", fmt::format("{} = {}\n", key, value))), "");
    }
    const double good = kind->range.includes_lower ? kind->range.lower : kind->range.upper;
    EXPECT_EQ(complaint_about(folder.write("a.json", result_with(name, fmt::format("{}", good)))),
              "");
  }
  EXPECT_NE(complaint_about(folder.write("a.json", result_with("restitution", "0"))), "");
}

TEST(LoadParameters, ASentenceSaysWhatIsNeeded) {
  const TemporaryFolder folder;
  const auto file = folder.write("p.json", result_with("friction_particle_particle", "-0.1"));
  EXPECT_EQ(
      complaint_about(file),
      file.string() +
          ": key 'parameters.friction_particle_particle.value' is -0.1, but a friction from 0 "
          "to 5 is needed.");
}

TEST(LoadParameters, RefusesResultsOfAnotherForm) {
  const TemporaryFolder folder;
  const std::string good = result_with("restitution", "0.5");
  const auto with_step = [&](const std::string& step) {
    return complaint_about(folder.write(
        "step.json", good.substr(0, good.size() - 1) + ", \"time_step\": " + step + "}"));
  };
  EXPECT_EQ(with_step("{\"fraction\": 1}"), "");
  for (const char* wrong : {"0", "-1", "50", "1e308", "null", "\"0.2\"", "[]"}) {
    const std::string said = with_step(fmt::format("{{\"fraction\": {}}}", wrong));
    EXPECT_NE(said.find("'time_step.fraction'"), std::string::npos) << wrong << said;
  }
  EXPECT_NE(with_step("0.2").find("'time_step' is no table"), std::string::npos);
  // NaN is written as null; some programs write words that are no JSON
  for (const char* wrong : {"null", "NaN", "1e999", "{}", ""})
    EXPECT_NE(complaint_about(folder.write("r.json", result_with("restitution", wrong))), "")
        << wrong;
  for (const char* wrong : {"[]",
                            "3",
                            "null",
                            "\"x\"",
                            "{}",
                            "{\"parameters\": []}",
                            "{\"parameters\": 1}",
                            "{\"parameters\": {\"restitution\": 0.5}}"})
    EXPECT_NE(complaint_about(folder.write("w.json", wrong)), "") << wrong;
  const std::string unknown = complaint_about(
      folder.write("u.json", "{\"parameters\": {\"frictoin\": {\"value\": 1}, " + good.substr(16)));
  EXPECT_NE(unknown.find("'parameters.frictoin' is unknown"), std::string::npos) << unknown;
}

}  // namespace
}  // namespace graintruth::calibrate
