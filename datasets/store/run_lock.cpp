#include "datasets/store/run_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>

#include "datasets/store/input_error.h"

namespace graintruth::datasets {

namespace {

std::string host() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "an unknown machine";
  return name.data();
}

// What the holder wrote of itself; nothing where it has not come so far.
std::string holder_in(int descriptor) {
  std::array<char, 512> text{};
  const ssize_t length = ::pread(descriptor, text.data(), text.size(), 0);
  return length > 0 ? std::string(text.data(), static_cast<std::size_t>(length)) : std::string();
}

// Whether the file is still the one of this name: its last holder may have removed it between our
// opening and our locking.
bool is_named(int descriptor, const std::filesystem::path& file) {
  struct stat opened {
  }, named{};
  return ::fstat(descriptor, &opened) == 0 && ::stat(file.c_str(), &named) == 0 &&
         opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
}

}  // namespace

RunLock::RunLock(const std::filesystem::path& root, std::string_view work) : file_(root / ".lock") {
  while (descriptor_ < 0) {
    descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor_ < 0) {
      throw InputError(fmt::format("{}: cannot be written ({}); choose another folder with --out.",
                                   root.string(),
                                   std::strerror(errno)));
    }
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) {
      holds_ = true;
      if (is_named(descriptor_, file_)) break;
    } else if (errno == EWOULDBLOCK) {
      const std::string holder = holder_in(descriptor_);
      ::close(descriptor_);
      throw InputError(
          fmt::format("{}: {} is at work in this folder; wait for its end, or use another folder.",
                      root.string(),
                      holder.empty() ? "another process" : holder));
    } else if (errno != EINTR) {
      return;  // no locks here
    }
    ::close(descriptor_);
    descriptor_ = -1;
    holds_ = false;
  }
  // A disk without room keeps nobody from holding the lock; the sentence then knows no name
  const std::string own = fmt::format("{} (process {} on {})", work, ::getpid(), host());
  if (::ftruncate(descriptor_, 0) != 0 || ::pwrite(descriptor_, own.data(), own.size(), 0) < 0)
    return;
}

RunLock::~RunLock() {
  if (descriptor_ < 0) return;
  ::unlink(file_.c_str());
  ::close(descriptor_);
}

}  // namespace graintruth::datasets
