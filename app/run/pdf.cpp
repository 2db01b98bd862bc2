#include "app/run/pdf.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cctype>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "datasets/store/external_program.h"
#include "datasets/store/input_error.h"

namespace graintruth::app {

namespace {

constexpr double time_limit = 60.0;  // s; a report of a calibration takes about 5 s

// The first of these that PATH knows.
std::optional<std::string> find_browser() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
    if (const auto program = datasets::find_program(name)) return program->string();
  }
  return std::nullopt;
}

// A folder of the browser's own, gone in the end with all that it has put there.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "graintruth-pdf-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      throw datasets::InputError(fmt::format(
          "{}: no temporary folder can be made there; set TMPDIR to one that can be written.",
          std::filesystem::temp_directory_path().string()));
    }
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// A file's address as browsers read it: what has a meaning in addresses is written as %hh.
std::string address_of(const std::filesystem::path& file) {
  std::string address = "file://";
  for (const unsigned char c : std::filesystem::absolute(file).string()) {
    const bool plain = std::isalnum(c) || std::string_view("/-_.~").find(static_cast<char>(c)) !=
                                              std::string_view::npos;
    address += plain ? std::string(1, static_cast<char>(c)) : fmt::format("%{:02X}", c);
  }
  return address;
}

}  // namespace

void print_pdf(const std::filesystem::path& page, const std::filesystem::path& pdf) {
  const std::optional<std::string> browser = find_browser();
  if (!browser) {
    throw datasets::InputError(
        "a PDF is printed by Chromium, which is not installed here; install the package chromium, "
        "or open report.html in a browser and print it");
  }
  const ScratchFolder scratch;
  const std::filesystem::path unfinished = pdf.string() + ".unfinished";
  std::vector<std::string> command = {*browser,
                                      "--headless",
                                      "--disable-gpu",
                                      "--no-first-run",
                                      "--disable-background-networking",
                                      "--disable-component-update",
                                      "--disable-sync",
                                      "--no-pdf-header-footer",
                                      "--virtual-time-budget=20000",
                                      "--user-data-dir=" + (scratch.path() / "profile").string(),
                                      "--print-to-pdf=" + unfinished.string(),
                                      address_of(page)};
  // Chromium does not sandbox for root; the page is ours and its policy forbids the network
  if (::geteuid() == 0) command.insert(command.begin() + 1, "--no-sandbox");
  const bool printed = datasets::run_external({.words = command,
                                               .environment = {{"HOME", scratch.path().string()}},
                                               .time_limit = time_limit})
                           .succeeded() &&
                       std::filesystem::exists(unfinished) &&
                       std::filesystem::file_size(unfinished) > 0;
  std::error_code error;
  if (printed) std::filesystem::rename(unfinished, pdf, error);
  if (!printed || error) {
    std::error_code ignored;
    std::filesystem::remove(unfinished, ignored);
    throw datasets::InputError(
        fmt::format("{}: could not be written: {} failed or did not end within {} s; open "
                    "report.html in a browser and print it.",
                    pdf.string(),
                    *browser,
                    time_limit));
  }
}

}  // namespace graintruth::app
