// Runs the built program (or another) as a user does: arguments in; stdout, stderr and exit status
// out.
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

namespace graintruth::tests {

struct ProgramOutcome {
  int status = -1;     // exit status; -1 where a signal ended the program
  int signal = 0;      // the signal that ended it
  double seconds = 0;  // from the start to the end
  std::string out;
  std::string err;
};

// The program under way. What it prints goes to files without a name, so that it never blocks.
class RunningProgram {
 public:
  explicit RunningProgram(const std::vector<std::string>& arguments,
                          const std::string& program = GRAINTRUTH_PROGRAM)
      : out_(std::tmpfile()), err_(std::tmpfile()), start_(Clock::now()) {
    if (out_ == nullptr || err_ == nullptr) throw std::runtime_error("no temporary file");
    std::vector<char*> argv = {const_cast<char*>(program.c_str())};
    for (const std::string& argument : arguments)
      argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    child_ = ::fork();
    if (child_ < 0) throw std::runtime_error("cannot fork");
    if (child_ == 0) {
      ::dup2(::open("/dev/null", O_RDONLY), STDIN_FILENO);
      ::dup2(::fileno(out_), STDOUT_FILENO);
      ::dup2(::fileno(err_), STDERR_FILENO);
      ::execv(program.c_str(), argv.data());
      ::_exit(127);
    }
  }
  ~RunningProgram() {
    if (child_ > 0) {
      ::kill(child_, SIGKILL);
      ::waitpid(child_, nullptr, 0);
    }
    std::fclose(out_);
    std::fclose(err_);
  }
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  void send(int signal) { ::kill(child_, signal); }

  ProgramOutcome wait() {
    int code = 0;
    ::waitpid(child_, &code, 0);
    child_ = 0;
    ProgramOutcome outcome;
    outcome.seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    if (WIFEXITED(code)) outcome.status = WEXITSTATUS(code);
    if (WIFSIGNALED(code)) outcome.signal = WTERMSIG(code);
    outcome.out = content_of(out_);
    outcome.err = content_of(err_);
    return outcome;
  }

 private:
  using Clock = std::chrono::steady_clock;

  static std::string content_of(std::FILE* file) {
    std::rewind(file);
    std::string content;
    char piece[4096];
    while (const std::size_t count = std::fread(piece, 1, sizeof piece, file))
      content.append(piece, count);
    return content;
  }

  std::FILE* out_;
  std::FILE* err_;
  Clock::time_point start_;
  pid_t child_ = 0;
};

inline ProgramOutcome run_program(const std::vector<std::string>& arguments,
                                  const std::string& program = GRAINTRUTH_PROGRAM) {
  return RunningProgram(arguments, program).wait();
}

}  // namespace graintruth::tests
