// One process a run folder: whoever comes second is told who is at work there.
#pragma once

#include <filesystem>
#include <string_view>

namespace graintruth::datasets {

// Holds a folder that is there, by a lock of the system on its file .lock. The lock goes with the
// process, however that ends; the file alone says nothing. On a network file system the lock holds
// between machines only where its server passes locks on.
class RunLock {
 public:
  // `work` is what the holder is called in the sentence of the other: "graintruth calibrate".
  // Throws InputError where another process holds the folder, or where the folder cannot be
  // written.
  RunLock(const std::filesystem::path& root, std::string_view work);
  ~RunLock();
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;

  // False where the file system knows no locks, so that nobody is kept out.
  bool holds() const { return holds_; }

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  bool holds_ = false;
};

}  // namespace graintruth::datasets
