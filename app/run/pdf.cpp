#include "app/run/pdf.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "datasets/store/input_error.h"

namespace graintruth::app {

namespace {

constexpr std::chrono::seconds time_limit(60);  // a report of a calibration takes about 5 s

// The first of these that PATH knows.
std::optional<std::string> find_browser() {
  const char* path = std::getenv("PATH");
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
    std::istringstream folders(path == nullptr ? "" : path);
    for (std::string folder; std::getline(folders, folder, ':');) {
      const std::filesystem::path program = std::filesystem::path(folder) / name;
      if (::access(program.c_str(), X_OK) == 0) return program.string();
    }
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

// Runs a command in silence, its home in `home`. False when it fails or does not end in time.
bool run_quietly(const std::vector<std::string>& command, const std::filesystem::path& home) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  std::vector<std::string> settings = {"HOME=" + home.string()};
  for (char** entry = environ; *entry != nullptr; ++entry)
    if (!std::string_view(*entry).starts_with("HOME=")) settings.emplace_back(*entry);
  std::vector<char*> environment;
  for (std::string& setting : settings) environment.push_back(setting.data());
  environment.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&files, stream, "/dev/null", O_RDWR, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);  // to end it with its children
  pid_t child = 0;
  const int refused = posix_spawn(
      &child, command.front().c_str(), &files, &attributes, arguments.data(), environment.data());
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (refused != 0) return false;

  const auto deadline = std::chrono::steady_clock::now() + time_limit;
  int status = 0;
  while (::waitpid(child, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > deadline) {
      ::kill(-child, SIGKILL);
      ::waitpid(child, &status, 0);
      return false;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
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
  const bool printed = run_quietly(command, scratch.path()) &&
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
                    time_limit.count()));
  }
}

}  // namespace graintruth::app
