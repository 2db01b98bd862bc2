// The documents against the program: no option, no key of an experiment file that only one of them
// knows.
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>

#include "datasets/parameters/parameter.h"
#include "tests/app/laboratory.h"
#include "tests/support/run_program.h"

namespace graintruth::tests {
namespace {

using Words = std::set<std::string>;

std::filesystem::path source() { return GRAINTRUTH_SOURCE_DIR; }

Words found(const std::string& text, const std::regex& pattern) {
  Words words;
  for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at)
    words.insert((*at)[1]);
  return words;
}

const std::regex option_pattern("(--[a-z][a-z0-9-]+)");

// Long options by verb, the parts of a verb ("fit beverloo") together; without --help. From the
// script for the shell, which the program makes from the definition of its command line.
std::map<std::string, Words> options_of_program() {
  const std::string script = run_program({"--print-bash-completion"}).out;
  const std::regex line("\"([a-z -]*)\"\\) words=\"([^\"]*)\"");
  std::map<std::string, Words> options;
  for (std::sregex_iterator at(script.begin(), script.end(), line), end; at != end; ++at) {
    const std::string path = (*at)[1];
    Words& of_verb = options[path.substr(0, path.find(' '))];
    for (const std::string& option : found((*at)[2], option_pattern)) of_verb.insert(option);
    of_verb.erase("--help");
  }
  return options;
}

// The same of docs/commands.md: what stands under "## VERB".
std::map<std::string, Words> options_of_document() {
  const std::string text = content_of(source() / "docs/commands.md");
  std::map<std::string, Words> options;
  for (auto at = text.find("\n## "); at != std::string::npos;) {
    const auto next = text.find("\n## ", at + 1);
    const std::string section =
        text.substr(at + 4, next == std::string::npos ? next : next - at - 4);
    options[section.substr(0, section.find_first_of(" \n"))] = found(section, option_pattern);
    at = next;
  }
  return options;
}

TEST(Documents, TellEveryOptionOfEveryVerbAndNoOther) {
  std::map<std::string, Words> program = options_of_program();
  ASSERT_GE(program.size(), 12u);
  EXPECT_EQ(program.at(""), Words({"--version"}));
  program.erase("");
  const std::map<std::string, Words> document = options_of_document();
  for (const auto& [verb, options] : program) {
    ASSERT_TRUE(document.contains(verb)) << verb << " is not in docs/commands.md";
    EXPECT_EQ(document.at(verb), options) << verb;
  }
  EXPECT_EQ(document.size(), program.size());
}

// Each example "graintruth VERB ... --option" anywhere in the documents.
TEST(Documents, ExamplesUseOptionsThatTheirVerbHas) {
  const std::map<std::string, Words> program = options_of_program();
  std::vector<std::filesystem::path> files = {source() / "README.md"};
  for (const auto& entry : std::filesystem::directory_iterator(source() / "docs"))
    if (entry.path().extension() == ".md") files.push_back(entry.path());
  int examples = 0;
  const std::regex command("graintruth ([a-z]+)( [^`\n]*)");
  for (const std::filesystem::path& file : files) {
    const std::string text = content_of(file);
    for (std::sregex_iterator at(text.begin(), text.end(), command), end; at != end; ++at) {
      for (const std::string& option : found((*at)[2], option_pattern)) {
        const auto verb = program.find((*at)[1]);
        ASSERT_NE(verb, program.end()) << file << ": " << (*at)[0];
        EXPECT_TRUE(verb->second.contains(option)) << file << ": " << (*at)[0];
        ++examples;
      }
    }
  }
  EXPECT_GE(examples, 5);
}

// Keys by their stems: what the reader of experiment files asks for, and what docs/experiment.md
// shows with a unit, or in a list of keys.
TEST(Documents, TellEveryKeyOfAnExperimentFileAndNoOther) {
  std::string reader;
  reader += content_of(source() / "datasets/scene/scene_particle.cpp");
  for (const char* folder : {"datasets/experiment", "datasets/rigs", "calibrate/observables"})
    for (const auto& entry : std::filesystem::directory_iterator(source() / folder))
      if (entry.path().extension() == ".cpp") reader += content_of(entry.path());
  Words keys =
      found(reader,
            std::regex("(?:quantity|whole_number|texts?|section|sections|rows|numbers|flag|setting)"
                       "\\(\\s*\"([a-z_]+)\""));
  for (const datasets::ParameterKind* kind : datasets::parameter_kinds())
    if (!kind->is_of_a_wall) keys.insert(std::string(kind->name));
  // {"rod", {"length", "diameter"}}
  for (const std::string& lengths :
       found(content_of(source() / "datasets/experiment/named_body.cpp"),
             std::regex("\\{\"[a-z]+\", \\{(\"[a-z_\", ]+\")\\}\\}")))
    for (const std::string& key : found(lengths, std::regex("\"([a-z_]+)\""))) keys.insert(key);
  ASSERT_GE(keys.size(), 60u);

  const std::string document = content_of(source() / "docs/experiment.md");
  Words told;
  const std::regex unit(
      "_(m|cm|mm|s|ms|kg|g|rad|deg|pa|kpa|mpa|gpa|hz|px|(m|cm|mm)_per_s2?|px_per_(m|cm|mm))$");
  for (const std::string& word : found(document, std::regex("\\b([a-z][a-z_]*[a-z0-9])\\b"))) {
    told.insert(word);
    told.insert(std::regex_replace(word, unit, ""));
  }
  for (const std::string& key : keys)
    EXPECT_TRUE(told.contains(key)) << "docs/experiment.md does not tell of " << key;

  // Columns of the corrections, which are no keys of the experiment
  const Words columns = {"x", "z", "angle"};
  for (const std::string& word : found(document, std::regex("\\b([a-z][a-z_]*[a-z0-9])\\b"))) {
    if (!std::regex_search(word, unit)) continue;
    const std::string stem = std::regex_replace(word, unit, "");
    EXPECT_TRUE(keys.contains(stem) || columns.contains(stem))
        << "docs/experiment.md tells of " << word << ", which no experiment file has";
  }
}

// The headings of the FAQ in backquotes are what a user has read on the terminal.
TEST(Documents, AnswerSentencesThatTheProgramSays) {
  std::string program;
  for (const char* folder : {"app", "tracking", "datasets", "calibrate", "reports"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(source() / folder))
      if (entry.path().extension() == ".cpp") program += content_of(entry.path());
  program = std::regex_replace(program, std::regex("\"\\s*\n\\s*\""), "");  // one literal
  int sentences = 0;
  for (const std::string& sentence :
       found(content_of(source() / "docs/faq.md"), std::regex("### `([^`]+)`"))) {
    EXPECT_NE(program.find(sentence), std::string::npos) << sentence;
    ++sentences;
  }
  EXPECT_GE(sentences, 15);
}

TEST(Documents, ShellAndManKnowTheProgram) {
  const std::string man = run_program({"--print-man-page"}).out;
  EXPECT_TRUE(man.starts_with(".TH GRAINTRUTH 1")) << man;
  for (const auto& [verb, options] : options_of_program()) {
    if (verb.empty()) continue;
    const std::string title = std::regex_replace(verb, std::regex("-"), "\\-");
    EXPECT_NE(man.find(".SS \"graintruth " + title), std::string::npos) << verb;
    for (const std::string& option : options) {
      const std::string escaped = std::regex_replace(option, std::regex("-"), "\\-");
      EXPECT_NE(man.find(".B " + escaped), std::string::npos) << option;
    }
  }
  // As bash asks it: what follows "graintruth export --to l"?
  TemporaryFolder folder;
  const auto script =
      folder.write("completion.bash",
                   run_program({"--print-bash-completion"}).out +
                       "COMP_WORDS=(graintruth export --to l) COMP_CWORD=3 && _graintruth\n"
                       "echo \"${COMPREPLY[*]}\"\n"
                       "COMP_WORDS=(graintruth fit bev) COMP_CWORD=2 && _graintruth\n"
                       "echo \"${COMPREPLY[0]}\"\n"
                       "COMP_WORDS=(graintruth report out/micro --p) COMP_CWORD=3 && _graintruth\n"
                       "echo \"${COMPREPLY[*]}\"\n");
  const std::string command =
      "bash '" + script.string() + "' >'" + (folder / "answers").string() + "' 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0);
  EXPECT_EQ(content_of(folder / "answers"), "liggghts lammps\nbeverloo\n--pdf\n");
}

}  // namespace
}  // namespace graintruth::tests
