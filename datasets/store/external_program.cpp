#include "datasets/store/external_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <sstream>

namespace graintruth::datasets {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::size_t kept = 65536;  // bytes of what a program prints
constexpr std::chrono::milliseconds between_looks(50);
constexpr std::chrono::seconds to_end_in_peace(3);  // after SIGTERM, before SIGKILL

struct Pipe {
  int read = -1, write = -1;
  Pipe() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) == 0) read = ends[0], write = ends[1];
  }
  ~Pipe() {
    close_end(read);
    close_end(write);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  static void close_end(int& end) {
    if (end >= 0) ::close(end);
    end = -1;
  }
};

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> environment_of(const ExternalCall& call) {
  std::vector<std::string> settings;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view setting = *entry;
    if (!call.environment.contains(std::string(setting.substr(0, setting.find('=')))))
      settings.emplace_back(setting);
  }
  for (const auto& [name, value] : call.environment) settings.push_back(name + "=" + value);
  return settings;
}

// False when nothing more will come.
bool take_in(int& end, std::string& text) {
  char piece[4096];
  const ssize_t count = ::read(end, piece, sizeof piece);
  if (count < 0 && errno == EINTR) return true;
  if (count <= 0) {
    Pipe::close_end(end);
    return false;
  }
  text.append(piece, static_cast<std::size_t>(count));
  if (text.size() > 2 * kept) text.erase(0, text.size() - kept);
  return true;
}

// It and what it has started; true where it has ended by then.
bool end_family(pid_t child, int& code) {
  ::kill(-child, SIGTERM);
  const auto deadline = Clock::now() + to_end_in_peace;
  while (Clock::now() < deadline) {
    if (::waitpid(child, &code, WNOHANG) == child) {
      ::kill(-child, SIGKILL);
      return true;
    }
    ::usleep(20000);
  }
  ::kill(-child, SIGKILL);
  return ::waitpid(child, &code, 0) == child;
}

}  // namespace

std::string ExternalEnd::words() const {
  switch (how) {
    case How::by_itself:
      return fmt::format("ended with status {}", status);
    case How::by_signal:
      return fmt::format("was ended by signal {} ({})", status, ::strsignal(status));
    case How::not_started:
      return fmt::format("cannot be started ({})", err);
    case How::too_late:
      return "did not end in time";
    case How::stopped:
      return "was stopped";
  }
  return "";
}

std::optional<std::filesystem::path> find_program(std::string_view name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::filesystem::path program = std::filesystem::path(folder) / name;
    if (::access(program.c_str(), X_OK) == 0 && !std::filesystem::is_directory(program))
      return program;
  }
  return std::nullopt;
}

ExternalEnd run_external(const ExternalCall& call) {
  ExternalEnd end;
  const auto refuse = [&](int error) {
    end.how = ExternalEnd::How::not_started;
    end.err = std::strerror(error);
    return end;
  };
  // 1. All that needs memory, before the fork
  std::vector<std::string> words = call.words, settings = environment_of(call);
  if (words.front().find('/') == std::string::npos) {
    const auto found = find_program(words.front());
    if (!found) return refuse(ENOENT);
    words.front() = std::filesystem::absolute(*found).string();
  }
  const std::vector<char*> arguments = pointers_to(words), environment = pointers_to(settings);
  Pipe out, err, failure;
  if (failure.read < 0 || err.read < 0 || out.read < 0) return refuse(EMFILE);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) return refuse(errno);
  if (child == 0) {
    // In a group of its own, to be ended with all that it starts
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(127);
    sigset_t none;
    ::sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    ::dup2(::open("/dev/null", O_RDONLY), STDIN_FILENO);
    ::dup2(out.write, STDOUT_FILENO);
    ::dup2(err.write, STDERR_FILENO);
    if (call.folder.empty() || ::chdir(call.folder.c_str()) == 0)
      ::execve(arguments.front(), arguments.data(), environment.data());
    const int error = errno;
    [[maybe_unused]] const ssize_t written = ::write(failure.write, &error, sizeof error);
    ::_exit(127);
  }
  ::setpgid(child, child);
  for (Pipe* pipe : {&out, &err, &failure}) Pipe::close_end(pipe->write);
  int error = 0, code = 0;
  if (::read(failure.read, &error, sizeof error) == sizeof error) {
    ::waitpid(child, &code, 0);
    return refuse(error);
  }
  // 2. What it prints, until it ends
  const auto start = Clock::now();
  bool has_ended = false;
  while (!has_ended) {
    pollfd ends[2] = {{out.read, POLLIN, 0}, {err.read, POLLIN, 0}};
    const bool is_open = out.read >= 0 || err.read >= 0;
    if (is_open) {
      ::poll(ends, 2, static_cast<int>(between_looks.count()));
      if (ends[0].revents != 0) take_in(out.read, end.out);
      if (ends[1].revents != 0) take_in(err.read, end.err);
    } else {
      ::usleep(1000);
    }
    has_ended = ::waitpid(child, &code, WNOHANG) == child;
    if (has_ended) break;
    const std::chrono::duration<double> taken = Clock::now() - start;
    if (call.stop && call.stop()) {
      end.how = ExternalEnd::How::stopped;
    } else if (call.time_limit > 0.0 && taken.count() > call.time_limit) {
      end.how = ExternalEnd::How::too_late;
    } else {
      continue;
    }
    end_family(child, code);
    return end;
  }
  // 3. What is left in the pipes; who else holds them open is not waited for
  for (auto& [pipe, text] : {std::pair(&out, &end.out), std::pair(&err, &end.err)}) {
    pollfd left = {pipe->read, POLLIN, 0};
    while (pipe->read >= 0 && ::poll(&left, 1, 0) > 0 && take_in(pipe->read, *text)) {
    }
  }
  for (std::string* text : {&end.out, &end.err})
    if (text->size() > kept) text->erase(0, text->size() - kept);
  end.how = WIFSIGNALED(code) ? ExternalEnd::How::by_signal : ExternalEnd::How::by_itself;
  end.status = WIFSIGNALED(code) ? WTERMSIG(code) : WEXITSTATUS(code);
  return end;
}

}  // namespace graintruth::datasets
