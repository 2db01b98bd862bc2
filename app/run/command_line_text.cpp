#include "app/run/command_line_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

namespace graintruth::app {

namespace {

// Visible options with a dash, then what stands without one.
std::vector<const CLI::Option*> dashed(const CLI::App& verb) {
  std::vector<const CLI::Option*> options;
  for (const CLI::Option* option : verb.get_options())
    if (!option->get_lnames().empty() && !option->get_group().empty()) options.push_back(option);
  for (const CLI::App* group : verb.get_subcommands([](const CLI::App* part) {
         return part->get_name().empty();  // an option group
       }))
    for (const CLI::Option* option : dashed(*group)) options.push_back(option);
  return options;
}

std::vector<const CLI::App*> verbs_of(const CLI::App& program) {
  return program.get_subcommands([](const CLI::App* part) { return !part->get_name().empty(); });
}

// The values of an option that takes one of a few: CLI11 shows them as TEXT:{a,b}.
std::vector<std::string> choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto open = type.find('{'), close = type.find('}');
  if (open == std::string::npos || close == std::string::npos) return {};
  return CLI::detail::split(type.substr(open + 1, close - open - 1), ',');
}

// "PCT" of "PCT:FLOAT in [0 - 100]"; nothing for a flag.
std::string placeholder(const CLI::Option& option) {
  if (option.get_items_expected_max() == 0) return "";
  const std::string type = option.get_type_name();
  return type.substr(0, type.find(':'));
}

// Text that man(7) prints as it is.
std::string man_text(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    const bool starts_line = escaped.empty() || escaped.back() == '\n';
    if (starts_line && (c == '.' || c == '\'')) escaped += "\\&";
    escaped += c == '\\' ? "\\e" : c == '-' ? "\\-" : std::string(1, c);
  }
  return escaped;
}

void append_verb(const CLI::App& verb, const std::string& path, std::string& page) {
  page +=
      fmt::format(".SS \"graintruth {}\"\n{}\n", man_text(path), man_text(verb.get_description()));
  for (const CLI::Option* option : verb.get_options()) {
    if (!option->get_positional() || option->get_group().empty()) continue;
    page += fmt::format(
        ".TP\n.I {}\n{}\n", man_text(placeholder(*option)), man_text(option->get_description()));
  }
  for (const CLI::Option* option : dashed(verb)) {
    if (option->get_lnames().front() == "help") continue;
    const std::vector<std::string> choices = choices_of(*option);
    const std::string value =
        choices.empty() ? placeholder(*option) : fmt::format("{}", fmt::join(choices, "|"));
    page += fmt::format(".TP\n.B \\-\\-{}{}\n{}\n",
                        man_text(option->get_lnames().front()),
                        value.empty() ? "" : " \\fI" + man_text(value) + "\\fR",
                        man_text(option->get_description()));
  }
  if (verbs_of(verb).empty()) {
    page += fmt::format(".PP\n.nf\n{}\n.fi\n", man_text(verb.get_footer()));
  }
  for (const CLI::App* part : verbs_of(verb))
    append_verb(*part, path + " " + part->get_name(), page);
}

std::vector<std::string> words_of(const CLI::App& verb) {
  std::vector<std::string> words;
  for (const CLI::App* part : verbs_of(verb)) words.push_back(part->get_name());
  for (const CLI::Option* option : dashed(verb))
    words.push_back("--" + option->get_lnames().front());
  return words;
}

struct ShellCases {
  std::string verbs;   // which words lead deeper
  std::string values;  // what stands after an option
  std::string words;   // what may stand otherwise
};

void append_cases(const CLI::App& verb, const std::string& path, ShellCases& cases) {
  for (const CLI::App* part : verbs_of(verb)) {
    const std::string deeper = path.empty() ? part->get_name() : path + " " + part->get_name();
    cases.verbs += fmt::format("      \"{}:{}\") path=\"{}\" ;;\n", path, part->get_name(), deeper);
    append_cases(*part, deeper, cases);
  }
  for (const CLI::Option* option : dashed(verb)) {
    const std::vector<std::string> choices = choices_of(*option);
    const std::string type = placeholder(*option);
    if (type.empty()) continue;
    const std::string finder = !choices.empty() ? fmt::format("-W \"{}\"", fmt::join(choices, " "))
                               : type == "DIR"  ? "-d"
                               : type == "FILE" ? "-f"
                                                : "-W \"\"";
    cases.values +=
        fmt::format("    \"{}:--{}\") COMPREPLY=($(compgen {} -- \"$current\")); return ;;\n",
                    path,
                    option->get_lnames().front(),
                    finder);
  }
  cases.words += fmt::format("    \"{}\") words=\"{}\" ;;\n", path, fmt::join(words_of(verb), " "));
}

}  // namespace

std::string man_page(const CLI::App& program, const std::string& version) {
  std::string page = fmt::format(
      ".TH GRAINTRUTH 1 \"\" \"graintruth {}\"\n"
      ".SH NAME\ngraintruth \\- {}\n"
      ".SH SYNOPSIS\n.B graintruth\n.I VERB\n.RI [ OPTIONS ]\n"
      ".SH VERBS\n",
      version,
      man_text(program.get_description()));
  for (const CLI::App* verb : verbs_of(program)) append_verb(*verb, verb->get_name(), page);
  page += fmt::format(".SH EXIT STATUS\n{}\n", man_text(program.get_footer()));
  return page;
}

std::string bash_completion(const CLI::App& program) {
  ShellCases cases;
  append_cases(program, "", cases);
  return fmt::format(
      R"(# Completion of graintruth for bash; made by the program from its own command line.
_graintruth() {{
  local current="${{COMP_WORDS[COMP_CWORD]}}" previous="${{COMP_WORDS[COMP_CWORD-1]}}" path="" words="" word
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case "$path:$word" in
{}    esac
  done
  case "$path:$previous" in
{}  esac
  case "$path" in
{}  esac
  COMPREPLY=($(compgen -W "$words" -- "$current"))
  if [ -n "$path" ] && [[ "$current" != -* ]]; then COMPREPLY+=($(compgen -f -- "$current")); fi
}}
complete -o filenames -F _graintruth graintruth
)",
      cases.verbs,
      cases.values,
      cases.words);
}

}  // namespace graintruth::app
