// The verbs that need films, the search or the thesis, in the program that is linked without them:
// the whole program does them, in place of this one.
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "app/run/programs.h"
#include "app/verbs/commands.h"
#include "datasets/store/input_error.h"

namespace graintruth::app {

namespace {

// This process's own arguments, as they were given.
std::vector<std::string> arguments_of_this() {
  std::ifstream stream("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> arguments;
  for (std::string word; std::getline(stream, word, '\0');) arguments.push_back(word);
  return arguments;
}

int hand_on() {
  const std::filesystem::path whole = whole_program();
  std::vector<std::string> words = arguments_of_this();
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  ::execv(whole.c_str(), pointers.data());
  throw datasets::InputError(
      fmt::format("{}: cannot be started ({}).", whole.string(), std::strerror(errno)));
}

}  // namespace

int run_annotate(const AnnotateCommand&) { return hand_on(); }
int run_calibrate(const CalibrateCommand&) { return hand_on(); }
int run_check(const CheckCommand&) { return hand_on(); }
int run_evaluate(const EvaluateCommand&) { return hand_on(); }
int run_reproduce(const ReproduceCommand&) { return hand_on(); }
int run_simulate(const SimulateCommand&) { return hand_on(); }
int run_track(const TrackCommand&) { return hand_on(); }
int run_validate(const ValidateCommand&) { return hand_on(); }

}  // namespace graintruth::app
